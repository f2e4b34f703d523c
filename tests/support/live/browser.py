"""A headless Chromium for tests of the page; they skip where there is none."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
)
LOAD_LIMIT_S = 60


@contextmanager
def browser(directory: Path, width: int = 1280, height: int = 1000) -> Iterator[Any]:
    """A Selenium driver with a profile of its own in `directory`, whose console is kept."""
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("chromium and chromedriver are not installed (apt install chromium chromium-driver)")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, f"--window-size={width},{height}", f"--user-data-dir={directory / 'profile'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(executable_path=driver, env={**os.environ, "HOME": str(directory)})
    opened = webdriver.Chrome(options=options, service=service)
    opened.set_page_load_timeout(LOAD_LIMIT_S)
    try:
        yield opened
    finally:
        opened.quit()


def console_errors(opened: Any) -> list[str]:
    """What the console has complained about since it was last asked."""
    return [entry["message"] for entry in opened.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]


def resize(opened: Any, width: int, height: int = 1000) -> None:
    """The page itself gets this size, also below what a window may have."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
