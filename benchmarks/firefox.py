"""Firefox without a window, driven by Selenium: what a person does with a page, in few words."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions import interaction
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.firefox.options import Options
from selenium.webdriver.firefox.service import Service
from websockets.sync.client import connect

__all__ = ["Firefox"]

_PAUSE = 0.03
_LABELLED = """
const fields = [...document.querySelectorAll('main input, main select, main textarea')]
  .filter((one) => one.checkVisibility())
  .map((one) => [one, one.getAttribute('aria-label') ?? one.labels?.[0]?.textContent ?? '']);
return (fields.find(([, label]) => label === given) ?? fields.find(([, label]) => label.includes(given)) ?? [null])[0];
"""
_BUTTON = """
const name = arguments[0];
return [...document.querySelectorAll('button')].find((one) => one.checkVisibility() && !one.disabled
  && (one.getAttribute('aria-label') ?? one.textContent) === name) ?? null;
"""


class Firefox:
    """The browser, and what its page asked for and said.

    Parameters
    ----------
    browser, driver : str
        Firefox and geckodriver.
    folder : Path
        Where what is downloaded goes.
    """

    def __init__(self, browser: str, driver: str, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        options = Options()
        options.binary_location = browser
        options.add_argument("-headless")
        options.set_capability("webSocketUrl", True)
        for name, value in {
            "browser.download.folderList": 2,
            "browser.download.dir": str(folder),
            "browser.download.always_ask_before_handling_new_types": False,
            "browser.download.alwaysOpenPanel": False,  # it would take the keyboard away from the page
            "dom.w3c_touch_events.enabled": 1,
            "ui.prefersReducedMotion": 1,
        }.items():
            options.set_preference(name, value)
        self.driver = webdriver.Firefox(options=options, service=Service(driver, log_output="/dev/null"))
        found = self.driver.capabilities
        self.version, self.driver_version = found["browserVersion"], found["moz:geckodriverVersion"]
        self.asked: list[str] = []
        self.failed: list[str] = []
        self.wrong: list[str] = []
        self._socket = connect(found["webSocketUrl"], max_size=None)
        self._number, self._heard = 0, threading.Condition()
        self._answers: dict[int, dict[str, Any]] = {}
        threading.Thread(target=self._listen, daemon=True).start()
        self._tell("session.subscribe", events=["network.beforeRequestSent", "log.entryAdded"])
        self.size(1280, 900)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._socket.close()
        self.driver.quit()

    def _listen(self) -> None:
        for text in self._socket:
            said = json.loads(text)
            if said.get("method") == "network.beforeRequestSent":
                self.asked.append(said["params"]["request"]["url"])
            elif said.get("method") == "log.entryAdded" and said["params"]["level"] == "error":
                self.failed.append(str(said["params"]["text"]))
            elif "id" in said:
                with self._heard:
                    self._answers[said["id"]] = said
                    self._heard.notify_all()

    def _tell(self, method: str, **given: Any) -> None:
        """Something of WebDriver BiDi."""
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": given}))
        with self._heard:
            assert self._heard.wait_for(lambda: self._number in self._answers, 30), f"{method}: no answer"
            assert self._answers[self._number]["type"] == "success", self._answers[self._number]

    @contextmanager
    def seen(self, what: str) -> Iterator[list[str]]:
        """A step: what it adds to the list is told; what goes wrong is told, and kept."""
        told: list[str] = []
        began = time.perf_counter()
        try:
            yield told
        except Exception as error:
            self.wrong.append(what)
            said = str(error).partition("\n")[0]
            print(f"  {what}: WRONG, {type(error).__name__}: {said}; the page: {self.text('main')[:600]}", flush=True)
        else:
            print(f"  {what}: {'; '.join(told) or 'as it has to be'} ({time.perf_counter() - began:.1f} s)", flush=True)

    def open(self, url: str) -> None:
        """Another page."""
        self.driver.get(url)

    def size(self, width: int, height: int) -> None:
        """The page's own size, however small a window may be."""
        self._tell(
            "browsingContext.setViewport",
            context=self.driver.current_window_handle,
            viewport={"width": width, "height": height},
        )

    def view(self, name: str) -> None:
        """One of the page's views."""
        self.until(lambda: self.shown(f"a[data-view={name}]"), f"the view {name}")
        self.one(f"a[data-view={name}]").click()

    def run(self, script: str, *given: Any) -> Any:
        """What a script returns."""
        return self.driver.execute_script(script, *given)

    def later(self, script: str) -> Any:
        """What a script hands to `done`."""
        return self.driver.execute_async_script(f"const done = arguments[0]; {script}")

    def until(self, found: Callable[[], Any], what: str, seconds: float = 30.0) -> Any:
        """The first thing that is found."""
        end = time.monotonic() + seconds
        while not (one := found()):
            if time.monotonic() > end:
                raise TimeoutError(f"{what}: not within {seconds:g} s")
            time.sleep(_PAUSE)
        return one

    def one(self, css: str) -> Any:
        """The first element that is seen."""
        return self.run(
            "return [...document.querySelectorAll(arguments[0])].find((e) => e.checkVisibility()) ?? null", css
        )

    def shown(self, css: str) -> bool:
        """Whether such an element is seen."""
        return self.one(css) is not None

    def wait(self, css: str) -> None:
        """Until such an element is seen."""
        self.until(lambda: self.shown(css), css, 90)

    def count(self, css: str) -> int:
        """How many there are."""
        return int(self.run("return document.querySelectorAll(arguments[0]).length", css))

    def text(self, css: str) -> str:
        """What the first element that is seen says."""
        find = "const e = [...document.querySelectorAll(arguments[0])].find((e) => e.checkVisibility());"
        return str(self.run(find + "return (e?.innerText ?? '').replaceAll(/\\s+/g, ' ').trim()", css))

    def attribute(self, css: str, name: str) -> str:
        """One of its attributes."""
        return str(self.one(css).get_attribute(name))

    def slider(self, name: str) -> float:
        """Where a handle is."""
        return float(self.attribute(f"[data-handle={name}]", "aria-valuenow"))

    def labelled(self, label: str) -> Any:
        """The field with a label."""
        return self.run(f"const given = arguments[0]; {_LABELLED}", label)

    def value(self, label: str) -> str:
        """What the field holds."""
        return str(self.run(f"const given = arguments[0]; return (() => {{ {_LABELLED} }})()?.value", label))

    def fill(self, label: str, text: str) -> None:
        """Type into a field, and leave it."""
        field = self.until(lambda: self.labelled(label), f'a field "{label}"')
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text, Keys.TAB)

    def choose(self, label: str, value: str) -> None:
        """One of a list, by the mouse."""
        field = self.until(lambda: self.labelled(label), f'a list "{label}"')
        options = f"option[value='{value}']"
        self.until(lambda: field.find_elements("css selector", options), f'"{value}" in the list "{label}"')
        self._near(field).find_element("css selector", options).click()

    def button(self, name: str) -> Any:
        """The button with a name."""
        return self.run(_BUTTON, name)

    def click(self, name: str) -> None:
        """Click on a button."""
        self.until(lambda: self.button(name), f'a button "{name}"').click()

    def press_button(self, name: str, key: str) -> None:
        """Press a key on a button."""
        self.until(lambda: self.button(name), f'a button "{name}"').send_keys(getattr(Keys, key))

    def press(self, css: str, key: str, *held: str) -> None:
        """Press a key on an element, with others held."""
        self.run("document.querySelector(arguments[0]).focus()", css)
        chain = ActionChains(self.driver)
        for one in held:
            chain.key_down(getattr(Keys, one))
        chain.send_keys(getattr(Keys, key, key))
        for one in held:
            chain.key_up(getattr(Keys, one))
        chain.perform()

    def press_labelled(self, label: str, key: str) -> None:
        """Press a key on a field."""
        self.labelled(label).send_keys(getattr(Keys, key))

    def mouse_drag(self, css: str, dx: int, dy: int) -> None:
        """Drag an element by the mouse."""
        chain = ActionChains(self.driver, duration=20).click_and_hold(self._near(self.one(css)))
        for _ in range(6):
            chain.move_by_offset(round(dx / 6), round(dy / 6))
        chain.release().perform()

    def touch_drag(self, css: str, dx: int, dy: int) -> None:
        """Drag an element by a finger."""
        finger = PointerInput(interaction.POINTER_TOUCH, "finger")
        does = ActionBuilder(self.driver, mouse=finger, duration=20)
        does.pointer_action.move_to(self._near(self.one(css))).pointer_down()
        for _ in range(6):
            does.pointer_action.move_by(round(dx / 6), round(dy / 6))
        does.pointer_action.pointer_up()
        does.perform()

    def tap(self, name: str) -> None:
        """Tap on a button with a finger."""
        self._tap(self.until(lambda: self.button(name), f'a button "{name}"'), 0)

    def touch_labelled(self, label: str, share: float) -> None:
        """Tap on a slider, at a share of its width."""
        field = self.labelled(label)
        self._tap(field, round((share - 0.5) * field.size["width"]))

    def _tap(self, element: Any, right: int) -> None:
        does = ActionBuilder(self.driver, mouse=PointerInput(interaction.POINTER_TOUCH, "finger"), duration=20)
        does.pointer_action.move_to(self._near(element), right, 0).pointer_down().pointer_up()
        does.perform()

    def _near(self, element: Any) -> Any:
        """The element, where it can be reached."""
        self.run("arguments[0].scrollIntoView({block: 'center'})", element)
        return element
