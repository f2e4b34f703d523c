"""The pictures of `longreach ui`, of `longreach top` and of a run's report in the guide, from one run on the simulated rig:
`python -m tests.docs.page_pictures` (needs Chromium).
"""

from __future__ import annotations

import asyncio
import io
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image
from rich.console import Console
from rich.terminal_theme import MONOKAI

from daemon.live.source.feed import Feed
from daemon.live.terminal.glance import Glance
from daemon.reports.run_report import write_reports
from daemon.server.protocol import Client
from recording.files.reader import read_log
from tests.support.daemon.running_daemon import RunningDaemon, arm, until
from tests.support.live.browser import browser, resize
from tests.support.live.gentle_rig import gentle_rig
from tests.support.live.page_server import page_server
from tests.test_rooms import CHECKOUT

PICTURES = CHECKOUT / "docs" / "pictures"
COLOURS = 64
TERMINAL_PX = (1000, 490)
RUN: dict[str, Any] = {"maneuver": {"name": "paper_line"}, "approach": True, "shaper": {"kind": "adaptive"}, "countdown_s": 1.0}
CHOOSE = """
const form = document.getElementById("maneuver");
form.maneuver.value = "paper_line";
form.maneuver.dispatchEvent(new Event("change"));
form.shaper.value = "adaptive";
form.approach.checked = true;
document.getElementById("plan").click();
"""


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with (
            RunningDaemon(folder, gentle_rig(folder)) as daemon,
            daemon.wait_until_ready() as client,
            page_server(daemon.socket, folder, "--control") as served,
            browser(folder, 1280, 900) as driver,
        ):
            driver.get(served.address)
            resize(driver, 1280, 900)
            _run(client, driver)
            _keep(driver, "ui.png")
            resize(driver, 400, 800)
            until(lambda: driver.execute_script("return document.documentElement.scrollWidth") <= 400, 30.0)
            _keep(driver, "ui-narrow.png")
            glance = asyncio.run(_glance(str(daemon.socket)))
            until(lambda: client.call("status")["run"]["validity"] != "running", 60.0)
            log = Path(client.call("wait", run=1, timeout_s=1.0)["log"])
            client.call("disarm")
            resize(driver, *TERMINAL_PX)
            driver.get(_written(folder / "top.html", glance))
            _keep(driver, "top.png")
            until(lambda: read_log(log).complete, 60.0)
            (page,) = write_reports(log, [1])
            resize(driver, 1280, 900)
            driver.get(page.as_uri())
            _keep(driver, "report.png")


def _run(client: Client, driver: Any) -> None:
    """Until ten seconds of the paper's line are on the screen, with its plan."""
    arm(client)
    until(lambda: driver.execute_script("return document.querySelectorAll('[name=maneuver] option').length"), 60.0)
    driver.execute_script(CHOOSE)
    until(lambda: "takes" in driver.execute_script("return document.getElementById('planned').textContent"), 90.0)
    client.call("start", **RUN)
    until(lambda: client.call("status")["run"]["elapsed_s"] > 10.0, 60.0)


async def _glance(socket: str) -> Console:
    """What `top` shows on a terminal of 100 by 24."""
    feed, glance, missing = Feed(socket), Glance(), {"samples", "status", "checks"}
    feeding = asyncio.create_task(feed.run())
    with feed.watched() as pending:
        while missing:
            content = await pending.take()
            glance.take(content)
            missing -= content.keys()
    feeding.cancel()
    console = Console(record=True, width=100, height=24, file=io.StringIO(), force_terminal=True)
    console.print(glance.lines(24))
    return console


def _written(path: Path, console: Console) -> str:
    """Its address as a page."""
    path.write_text(console.export_html(theme=MONOKAI, inline_styles=True))
    return path.as_uri()


def _keep(driver: Any, name: str) -> None:
    picture = Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB").quantize(COLOURS)
    picture.save(PICTURES / name, optimize=True)
    print(f"docs/pictures/{name}", (PICTURES / name).stat().st_size, "bytes")


if __name__ == "__main__":
    main()
