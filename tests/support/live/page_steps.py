"""What a person does on the page, and what they wait for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.support.daemon.running_daemon import until

LIMIT_S = 60.0


def text(driver: Any, identity: str) -> str:
    return str(driver.execute_script("return document.getElementById(arguments[0]).textContent", identity))


def shows(driver: Any, condition: Callable[[], Any]) -> None:
    """Wait until the page shows something."""
    try:
        until(condition, LIMIT_S)
    except AssertionError as error:
        shown = ", ".join(f"{name}: {text(driver, name)!r}" for name in ("mode", "run", "message", "planned"))
        fields = driver.execute_script("return [...document.forms.maneuver.elements].map((one) => `${one.name}=${one.value}`).join(', ')")
        raise AssertionError(f"{shown}; {fields}") from error


def click(driver: Any, identity: str) -> None:
    from selenium.webdriver.common.by import By

    shows(driver, lambda: driver.find_element(By.ID, identity).is_enabled())
    driver.find_element(By.ID, identity).click()


def select(driver: Any, name: str, value: str) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import Select

    shows(driver, lambda: driver.find_elements(By.CSS_SELECTOR, f"[name={name}] option"))
    Select(driver.find_element(By.NAME, name)).select_by_value(value)


def with_arm(driver: Any) -> None:
    shows(
        driver, lambda: driver.execute_script("return !document.getElementById('reset').disabled || loop.textContent.includes('released')")
    )
    if driver.execute_script("return !document.getElementById('reset').disabled"):
        click(driver, "reset")
        shows(driver, lambda: "e-stop released" in text(driver, "loop"))
    click(driver, "arm-button")
    shows(driver, lambda: text(driver, "mode") == "holding")
