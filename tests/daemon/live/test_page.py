"""The page in a browser, beside a real daemon: seen, driven, stopped."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from daemon.server.protocol import Client
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.browser import browser, console_errors, resize
from tests.support.live.gentle_daemon import gentle_daemon
from tests.support.live.page_server import PageServer, page_server
from tests.support.live.page_steps import LIMIT_S, click, select, shows, text, with_arm

pytestmark = [pytest.mark.slow, pytest.mark.clock]  # a browser that draws: seconds of both processors

DARK_PIXELS = """
const canvas = document.querySelectorAll("#plots canvas")[arguments[0]];
const {width, height} = canvas;
const copy = Object.assign(document.createElement("canvas"), {width, height}).getContext("2d", {willReadFrequently: true});
copy.drawImage(canvas, 0, 0);
const {data} = copy.getImageData(0, 0, width, height);
let drawn = 0;
for (let at = 3; at < data.length; at += 4) drawn += data[at] > 128;
return drawn;
"""


@pytest.fixture(scope="module")
def page(daemon: RunningDaemon, tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    with page_server(daemon.socket, tmp_path_factory.mktemp("page"), "--control") as served:
        yield served


@pytest.fixture
def opened(page: PageServer, daemon: RunningDaemon, tmp_path: Path) -> Iterator[Any]:
    """A browser with the page open and live; whatever it did, the arm is disarmed afterwards and the console was silent."""
    with browser(tmp_path) as driver:
        driver.get(page.address)
        shows(driver, lambda: text(driver, "mode") == "disarmed")
        yield driver
        assert console_errors(driver) == []
    with Client(daemon.socket) as client:
        client.call("disarm")
        if client.call("status")["mode"] == "fault":
            client.call("reset")


@pytest.mark.parametrize("width", [1280, 400])
def test_plots_and_arm_are_seen_and_nothing_is_cut_off(opened: Any, width: int) -> None:
    resize(opened, width)
    shows(opened, lambda: opened.execute_script(f"return innerWidth === {width}"))
    shows(opened, lambda: opened.execute_script("return document.documentElement.scrollWidth") <= width)
    titles = opened.execute_script("return [...document.querySelectorAll('.plot h3')].map(each => each.textContent)")
    assert {"rotary position / deg", "prismatic position / in", "pressures / psi", "timing / us"} <= set(titles)
    for number in range(len(titles)):
        opened.execute_script("document.querySelectorAll('.plot')[arguments[0]].scrollIntoView()", number)
        shows(opened, lambda number=number: opened.execute_script(DARK_PIXELS, number) > 500)
        left, right = opened.execute_script(
            "const box = document.querySelectorAll('.plot canvas')[arguments[0]].getBoundingClientRect(); return [box.left, box.right]",
            number,
        )
        assert 0 <= left < right <= width
    assert opened.execute_script("return document.querySelector('#arm .link').getBBox().height") == pytest.approx(1.016, rel=0.05)


def test_the_e_stop_is_the_first_stop_of_the_keyboard_has_a_name_and_stays_where_it_is(opened: Any, daemon: RunningDaemon) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    button = opened.find_element(By.ID, "estop")
    assert (button.aria_role, button.accessible_name) == ("button", "E-STOP")
    opened.find_element(By.TAG_NAME, "body").send_keys(Keys.TAB)
    assert opened.switch_to.active_element == button
    for width in (1280, 400):
        resize(opened, width)
        places = []
        for scroll in (0, 10000):
            opened.execute_script("scrollTo(0, arguments[0])", scroll)
            box = opened.execute_script("const b = estop.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]")
            on_top = opened.execute_script("const b = estop.getBoundingClientRect(); return document.elementFromPoint(b.x + 9, b.y + 9).id")
            assert on_top == "estop"
            assert box[2] <= width
            places.append(box)
        assert places[0] == places[1]
    button.send_keys(Keys.ENTER)
    shows(opened, lambda: text(opened, "mode") == "fault")
    with Client(daemon.socket) as client:
        assert client.call("status")["fault"]["text"] == "e-stop was asked for"


def test_a_second_finger_stops_the_arm_while_the_first_one_drives_it(opened: Any, daemon: RunningDaemon) -> None:
    """A browser makes no click of it."""
    from selenium.webdriver.common.by import By

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        opened.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def middle(element: Any) -> tuple[float, float]:
        box = opened.execute_script(
            "const b = arguments[0].getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]", element
        )
        return box[0], box[1]

    opened.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    with_arm(opened)
    click(opened, "drive")
    shows(opened, lambda: text(opened, "mode") == "running" and opened.find_elements(By.CSS_SELECTOR, "#pads button"))
    pad = next(each for each in opened.find_elements(By.CSS_SELECTOR, "#pads button") if each.text == "+ rotary")
    opened.execute_script("arguments[0].scrollIntoView({block: 'end'})", pad)
    held, stop = middle(pad), middle(opened.find_element(By.ID, "estop"))
    touch("touchStart", held)
    touch("touchStart", held, stop)
    shows(opened, lambda: text(opened, "mode") == "fault")
    touch("touchEnd")
    with Client(daemon.socket) as client:
        assert client.call("status")["fault"]["text"] == "e-stop was asked for"


@pytest.mark.parametrize(("button", "mode"), [("estop", "fault"), ("stop", "holding"), ("disarm", "disarmed")])
def test_what_stops_does_not_stand_in_line_behind_other_requests(opened: Any, daemon: RunningDaemon, button: str, mode: str) -> None:
    """A browser has six connections to a server; `wait` for a run that goes on holds each of them."""
    with_arm(opened)
    with Client(daemon.socket) as client:
        run = client.call("start", maneuver={"name": "hold"}, parameters={"duration": "300 s"}, countdown_s=0.0)["run"]
    waiting = f"JSON.stringify({{method: 'wait', params: {{run: {run}, timeout_s: 100}}}})"
    headers = "{Authorization: 'Bearer ' + sessionStorage.getItem('token'), 'Content-Type': 'application/json'}"
    opened.execute_script(f"for (let k = 0; k < 12; k++) fetch('/api/request', {{method: 'POST', headers: {headers}, body: {waiting}}})")
    shows(opened, lambda: text(opened, "mode") == "running")
    opened.execute_script("document.getElementById(arguments[0]).click()", button)
    shows(opened, lambda: text(opened, "mode") == mode)


def test_a_run_is_planned_started_watched_and_stopped_by_key(opened: Any, daemon: RunningDaemon) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    with_arm(opened)
    select(opened, "maneuver", "jog")
    for name, value in (("of.by", "40 deg"), ("of.speed", "4 deg/s")):
        field = opened.find_element(By.NAME, name)
        field.clear()
        field.send_keys(value)
    click(opened, "plan")
    shows(opened, lambda: re.search(r"to (39\.9|40\.0)\d deg", text(opened, "planned")))  # from where an e-stop before has left the arm
    assert opened.execute_script("return document.querySelector('#arm .path').getTotalLength()") == pytest.approx(1.016 * 0.698, rel=0.02)
    before = opened.execute_script("return document.querySelector('#arm .tip').getAttribute('cx')")
    click(opened, "start")
    shows(opened, lambda: text(opened, "mode") == "running")
    shows(
        opened,
        lambda: abs(float(opened.execute_script("return document.querySelector('#arm .tip').getAttribute('cx')")) - float(before)) > 0.02,
    )
    number = int(text(opened, "run").removeprefix("run ").partition(":")[0])
    assert f"run {number}: jog" in text(opened, "run")
    opened.find_element(By.NAME, "of.by").send_keys(Keys.ESCAPE)
    shows(opened, lambda: text(opened, "mode") == "fault")
    shows(opened, lambda: "e-stop was asked for" in text(opened, "run"))
    shows(opened, lambda: "e-stop was asked for" in text(opened, "events"))
    with Client(daemon.socket) as client:
        assert client.call("wait", run=number, timeout_s=5)["validity"] == "invalid"


def test_stop_ends_a_run_and_holds(opened: Any) -> None:
    with_arm(opened)
    select(opened, "maneuver", "jog")
    opened.execute_script("document.getElementsByName('of.by')[0].value = '-40 deg'")
    click(opened, "start")
    shows(opened, lambda: text(opened, "mode") == "running")
    click(opened, "stop")
    shows(opened, lambda: text(opened, "mode") == "holding" and "stop was asked for" in text(opened, "run"))


def test_a_paused_plot_stays_and_a_picked_signal_gets_a_plot(opened: Any) -> None:
    newest = "const u = document.querySelector('.plot'); return document.querySelector('#behind').textContent"
    shows(opened, lambda: opened.execute_script(newest))
    click(opened, "pause")
    paused = text(opened, "behind")
    cycle = text(opened, "loop")
    shows(opened, lambda: text(opened, "loop") != cycle)
    assert text(opened, "behind") == paused
    click(opened, "pause")
    shows(opened, lambda: text(opened, "behind") != paused)
    plots = opened.execute_script("return document.querySelectorAll('.plot').length")
    opened.execute_script("picker.open = true; document.querySelector('#signals input[value=\"overruns\"]').click()")
    assert opened.execute_script("return document.querySelectorAll('.plot').length") == plots + 1


def test_runs_are_listed_and_a_report_opens_without_a_complaint(opened: Any, daemon: RunningDaemon) -> None:
    with Client(daemon.socket) as client:
        client.call("arm")
        run = client.call("start", maneuver={"name": "jog"}, countdown_s=0.0)["run"]
        client.call("wait", run=run, timeout_s=30)
        client.call("disarm")
    click(opened, "list-runs")
    shows(opened, lambda: "jog" in text(opened, "runs"))
    first = opened.current_window_handle
    opened.execute_script("document.querySelector('#runs button').click()")
    shows(opened, lambda: len(opened.window_handles) == 2)
    opened.switch_to.window(next(each for each in opened.window_handles if each != first))
    until(lambda: "/report/" in opened.current_url and opened.execute_script("return document.querySelectorAll('svg').length") > 3, LIMIT_S)
    assert "run" in opened.title
    assert console_errors(opened) == []
    opened.close()
    opened.switch_to.window(first)


def test_without_the_token_nothing_is_shown_and_the_page_says_why(page: PageServer, tmp_path: Path) -> None:
    with browser(tmp_path) as driver:
        driver.get(f"http://127.0.0.1:{page.port}/")
        shows(driver, lambda: "token is missing or wrong" in text(driver, "lost"))
        assert text(driver, "rig") == "longreach"
        assert driver.execute_script("return document.querySelectorAll('.plot').length") == 0


def test_a_daemon_that_ends_is_said_within_seconds_with_what_to_do(tmp_path: Path) -> None:
    with gentle_daemon(tmp_path) as daemon, page_server(daemon.socket, tmp_path) as page, browser(tmp_path) as driver:
        driver.get(page.address)
        shows(driver, lambda: text(driver, "mode") == "disarmed")
        assert driver.execute_script("return document.getElementById('start').hidden && document.getElementById('control').hidden")
        daemon.process.kill()
        begun = time.monotonic()
        shows(driver, lambda: "no answer from the daemon" in text(driver, "lost") and "longreach estop" in text(driver, "lost"))
        assert time.monotonic() - begun < 15.0
        assert driver.execute_script("return document.body.classList.contains('stale')")
        assert console_errors(driver) == []


def rotary(daemon: RunningDaemon) -> float:
    with Client(daemon.socket) as client:
        return float(client.call("status")["joints"]["rotary"]["target"])


def rests(daemon: RunningDaemon) -> bool:
    before = rotary(daemon)
    time.sleep(0.1)  # of motion, if there is any
    return rotary(daemon) == before


@pytest.mark.parametrize("by", ["pointer", "key"])
def test_the_arm_moves_while_a_button_is_held_and_stops_when_it_is_let_go(opened: Any, daemon: RunningDaemon, by: str) -> None:
    """Where the machine stands still for half a second, the daemon rightly ends the run: then once more."""
    with_arm(opened)
    for _ in range(5):
        held_and_let_go(opened, daemon, by)
        if text(opened, "drive") == "End driving":
            click(opened, "drive")
        shows(opened, lambda: text(opened, "mode") == "holding" and not opened.execute_script("return pads.children.length"))
        if "set points arriving" not in text(opened, "run"):
            break
    assert re.search(r"by hand, .*, valid", text(opened, "run"))


def held_and_let_go(driver: Any, daemon: RunningDaemon, by: str) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    click(driver, "drive")
    shows(driver, lambda: text(driver, "mode") == "running")
    shows(driver, lambda: text(driver, "drive-filter").startswith("Filter adaptive on rotary, prismatic"))
    pad = next(each for each in driver.find_elements(By.CSS_SELECTOR, "#pads button") if each.text == "+ rotary")
    before = rotary(daemon)
    if by == "pointer":
        ActionChains(driver).click_and_hold(pad).perform()
    else:
        driver.execute_script("arguments[0].focus()", pad)
        ActionChains(driver).key_down(Keys.SPACE).perform()
    shows(driver, lambda: rotary(daemon) > before + 0.03 or text(driver, "mode") == "holding")
    (ActionChains(driver).release() if by == "pointer" else ActionChains(driver).key_up(Keys.SPACE)).perform()
    shows(driver, lambda: rests(daemon))


def test_a_page_that_leaves_while_a_button_is_held_stops_the_arm(opened: Any, daemon: RunningDaemon) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    with_arm(opened)
    click(opened, "drive")
    shows(opened, lambda: text(opened, "mode") == "running")
    before = rotary(daemon)
    pad = next(each for each in opened.find_elements(By.CSS_SELECTOR, "#pads button") if each.text == "− rotary")
    ActionChains(opened).click_and_hold(pad).perform()
    shows(opened, lambda: rotary(daemon) < before - 0.02)
    opened.get("about:blank")
    with Client(daemon.socket) as client:
        until(lambda: client.call("status")["mode"] == "holding")
        run = client.call("status")["run"]
        assert run["validity"] == "invalid"
        assert any(check in run["reason"] for check in ("driving client", "set points arriving"))  # whichever is seen first
