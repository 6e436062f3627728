"""Take the two pictures of docs/studio.md: needs Chromium (make browser)."""

from __future__ import annotations

import io
import shutil
import threading
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from subskin.studio.opening import bound, served
from subskin.studio.server import Keys
from subskin.studio.studio import Studio

HERE = Path(__file__).parent


def main() -> None:
    port = bound(0)
    studio, keys = Studio(), Keys(port.getsockname()[1])
    server = served(studio, keys)
    threading.Thread(target=server.run, kwargs={"sockets": [port]}, daemon=True).start()
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1240, "height": 880}, device_scale_factor=1)
        page.goto(keys.address)
        page.locator(".status[data-status=OK]").wait_for(timeout=60_000)
        page.wait_for_timeout(1000)
        keep(page.screenshot(), "studio_finger.png")
        page.locator("a[data-view=memo]").click()
        page.get_by_label("Figure").select_option("13")
        page.locator("math mfrac").first.wait_for()
        page.wait_for_timeout(1000)
        keep(page.screenshot(), "studio_memo.png")
        browser.close()
    server.should_exit = True
    studio.close()


def keep(picture: bytes, name: str) -> None:
    """As a palette: a fraction of the bytes."""
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    image.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(HERE / name, optimize=True)


if __name__ == "__main__":
    main()
