"""The studio's page: from a move of the hand to the picture, and a live stream that is drawn and recorded.

Drags the touch and the depth of the sensors in Chromium with a field of 80 x 200 points on a half plane, a layer and
areas, and shows a stream of 64 channels at 1 kHz while it is recorded. Needs Chromium (make browser). A busy machine
makes all of it slower.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from subskin.studio.opening import bound, served
from subskin.studio.server import Keys
from subskin.studio.studio import Studio

ROW = """\
[skin]
kind = "half_plane"
young = "0.4 MPa"
[sensors]
count = 8
pitch = "1.5 mm"
depth = "2 mm"
noise = 5e-4
"""
LAYERS = 'kind = "layers"\nlayers = [{young = "0.4 MPa", thickness = "6 mm"}]\n'
LAYER = ROW.replace('kind = "half_plane"\nyoung = "0.4 MPa"\n', LAYERS)
AREA = """\
[skin]
kind = "half_space"
young = "0.4 MPa"
[sensors]
layout = "grid"
shape = [{side}, {side}]
pitch = "3 mm"
depth = "3 mm"
kind = "mean_pressure"
noise = 20.0
"""
LAYERED_AREA = AREA.format(side=4).replace('kind = "half_space"\nyoung = "0.4 MPa"\n', LAYERS)
WATCH = """() => {
  window.seen = {moves: [], sent: [], heard: [], drawn: [], painted: 0};
  const at = () => performance.now();
  addEventListener('pointermove', () => seen.moves.push(at()), true);
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (text) {
    if (text.includes('"finger"')) seen.sent.push([JSON.parse(text).id, at()]);
    if (!this.watched) {
      this.watched = true;
      this.addEventListener('message', (event) => {
        const length = new DataView(event.data).getUint32(0, true);
        seen.heard.push([JSON.parse(new TextDecoder().decode(new Uint8Array(event.data, 4, length))).id, at()]);
      });
    }
    return send.call(this, text);
  };
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (...given) {
    seen.drawn.push(at());
    return draw.apply(this, given);
  };
  const clear = CanvasRenderingContext2D.prototype.clearRect;
  CanvasRenderingContext2D.prototype.clearRect = function (...given) {
    if (this.canvas.getAttribute('aria-label') === 'What touches now') seen.painted += 1;
    return clear.apply(this, given);
  };
}"""


def delays(seen: dict[str, Any]) -> np.ndarray:
    """From each move to the first picture that holds it [ms]."""
    heard = dict(seen["heard"])
    out = []
    for move in seen["moves"]:
        answer = next((heard[k] for k, at in seen["sent"] if at >= move and k in heard), None)
        drawn = None if answer is None else next((at for at in seen["drawn"] if at >= answer), None)
        if drawn is not None:
            out.append(drawn - move)
    return np.array(out)


def dragged(page: Any, handle: str = "position", moves: int = 300) -> np.ndarray:
    """The touch is dragged to and fro, or the sensors up and down, 60 moves a second."""
    box = page.locator(f"[data-handle={handle}]").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate("() => Object.values(seen).forEach((list) => Array.isArray(list) && (list.length = 0))")
    for k in range(moves):
        swing = np.sin(0.04 * k)
        page.mouse.move(*((x + 120 * swing, y) if handle == "position" else (x, y + 20 * swing)))
        time.sleep(1 / 60)
    time.sleep(0.3)
    found = delays(page.evaluate("() => seen"))
    page.mouse.up()
    return found


def streamed(page: Any, folder: Path) -> str:
    """Ten seconds of 64 channels at 1 kHz, drawn and recorded."""
    page.locator("a[data-view=live]").click()
    page.get_by_label("device or recording").fill("demo?rate=1000")
    page.get_by_role("button", name="Start").click()
    page.locator(".status", has_text="running").wait_for(timeout=60_000)
    page.get_by_role("button", name="Record").click()
    page.get_by_role("button", name="Stop recording").wait_for()
    time.sleep(1.0)
    before, began = page.evaluate("() => seen.painted"), time.perf_counter()
    time.sleep(10.0)
    painted = (page.evaluate("() => seen.painted") - before) / (time.perf_counter() - began)
    page.get_by_role("button", name="Stop recording").click()
    page.locator(".note", has_text="Recorded:").wait_for()
    page.get_by_role("button", name="Stop", exact=True).click()
    from pyarrow import parquet

    kept = next(folder.glob("*.parquet"))
    rows = parquet.read_table(kept, columns=["kind", "sequence"]).to_pydict()
    kept.unlink()
    number = np.array([n for n, kind in zip(rows["sequence"], rows["kind"], strict=True) if kind == "frame"])
    missing = int((np.diff(number) - 1).sum())
    return f"drawn {painted:.0f} times a second; {number.size} frames recorded, {missing} missing"


def main() -> None:
    """Run it."""
    chromium = next((found for name in ("chromium", "chromium-browser") if (found := shutil.which(name))), None)
    if chromium is None:
        sys.exit("bench_studio.py: needs Chromium: make browser")
    from playwright.sync_api import sync_playwright

    folder = Path(tempfile.mkdtemp())
    home = Path.cwd()
    os.chdir(folder)  # recordings go where the studio was started
    args = ["--no-sandbox"] if os.geteuid() == 0 else []
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print("move to drawn [ms]                p50    p90    p99  moves")
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=args)
        for name, text in (
            ("half plane", ROW),
            ("layer", LAYER),
            ("area, 4 x 4", AREA.format(side=4)),
            ("layer, 4 x 4", LAYERED_AREA),
            ("live, 64 in a row", ROW.replace("count = 8", "count = 64")),
            ("live, 8 x 8", AREA.format(side=8)),
        ):
            (folder / "finger.toml").write_text(text)
            here = bound(0)
            studio, keys = Studio(folder / "finger.toml"), Keys(here.getsockname()[1])
            server = served(studio, keys)
            thread = threading.Thread(target=server.run, kwargs={"sockets": [here]}, daemon=True)
            thread.start()
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(keys.address)
            page.evaluate(WATCH)
            page.locator(".status[data-status]").first.wait_for(timeout=60_000)
            page.wait_for_timeout(4000)  # until the field is fine
            if name.startswith("live"):
                print(f"{name}, 1 kHz: {streamed(page, folder)}")
            else:
                for handle, what in (("position", name), ("sensors", f"{name}, depth")):
                    ms = dragged(page, handle)
                    part = "".join(f"{np.percentile(ms, q):7.1f}" for q in (50, 90, 99))
                    print(f"{what:28s}{part}{ms.size:7d}")
            page.close()
            server.should_exit = True
            thread.join(5)
            studio.close()
        browser.close()
    os.chdir(home)
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
