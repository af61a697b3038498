"""A real browser that a test drives by keyboard and mouse, over the pipe of its developer tools."""

import base64
import fcntl
import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from browser import CHROMIUM

PATIENCE = 60.0  # seconds until something that is waited for has to be there

KEYS = {
    "Enter": (13, "\r"),
    "Escape": (27, ""),
    "Backspace": (8, ""),
    "ArrowLeft": (37, ""),
    "ArrowRight": (39, ""),
    "ArrowUp": (38, ""),
    "ArrowDown": (40, ""),
    "Home": (36, ""),
    "End": (35, ""),
    " ": (32, " "),
}


def _high(handle: int) -> int:
    """The same file under a number that the browser's own two do not need."""
    return fcntl.fcntl(handle, fcntl.F_DUPFD_CLOEXEC, 10)


class Browser:
    """One page in a Chromium without a window.

    Arguments:
        profile: a folder for what the browser keeps.
        size: of the page (pixels).
    """

    def __init__(self, profile: Path, size: tuple[int, int] = (1400, 900), dark: bool = False):
        command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        command += [f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}", "about:blank"]
        (self._in, theirs_out), (theirs_in, self._out) = os.pipe(), os.pipe()
        files = [
            *((os.POSIX_SPAWN_DUP2, fd, place) for fd, place in [(_high(theirs_in), 3), (_high(theirs_out), 4)]),
            (os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0),
        ]
        self._process = os.posix_spawn(command[0], command, os.environ, file_actions=files)  # never a fork
        for handle in (theirs_in, theirs_out, files[0][1], files[1][1]):
            os.close(handle)
        self._rest, self._number, self._session = b"", 0, None
        self.errors: list[str] = []
        targets = self._call("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        attached = self._call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime"):
            self._call(f"{domain}.enable")
        self.resize(size)
        if dark:
            feature = {"name": "prefers-color-scheme", "value": "dark"}
            self._call("Emulation.setEmulatedMedia", features=[feature])

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *error: object) -> None:
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        os.close(self._in)
        os.close(self._out)

    def resize(self, size: tuple[int, int]) -> None:
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", **metrics)

    def open(self, address: str, ready: str = "document.body.dataset.ready === 'yes'") -> None:
        """Shows a page, and waits until `ready`, an expression of its script, holds."""
        self._call("Page.navigate", url="about:blank")
        self._call("Page.navigate", url=address)
        self.wait(ready)

    def run(self, expression: str) -> Any:
        """The value of an expression of the page's script."""
        asked = {"expression": expression, "returnByValue": True, "awaitPromise": True}
        found = self._call("Runtime.evaluate", **asked)
        if "exceptionDetails" in found:
            raise AssertionError(found["exceptionDetails"].get("exception", found["exceptionDetails"]))
        return found["result"].get("value")

    def text(self, selector: str) -> str:
        return self.run(f"document.querySelector({json.dumps(selector)})?.innerText ?? ''")

    def wait(self, expression: str, patience: float = PATIENCE) -> Any:
        """Waits until an expression holds, and gives its value."""
        until = time.monotonic() + patience
        while True:
            try:
                if found := self.run(expression):
                    return found
            except AssertionError:  # the page is not there yet
                pass
            if time.monotonic() > until:
                raise AssertionError(f"never came true: {expression}; the page says {self.text('body')[:1500]!r}")
            time.sleep(0.03)

    def wait_for_text(self, selector: str, text: str) -> None:
        self.wait(f"(document.querySelector({json.dumps(selector)})?.innerText ?? '').includes({json.dumps(text)})")

    def press(self, *keys: str, shift: bool = False) -> None:
        """Presses keys one after the other."""
        for key in keys:
            number, text = KEYS[key] if key in KEYS else (ord(key.upper()), key)
            code = f"Digit{key}" if key.isdigit() else f"Key{key.upper()}" if key.isalpha() and len(key) == 1 else key
            about = {
                "key": key.upper() if shift and len(key) == 1 else key,
                "code": code,
                "windowsVirtualKeyCode": number,
            }
            about["modifiers"] = 8 if shift else 0
            self._call("Input.dispatchKeyEvent", type="keyDown", **about, **({"text": text} if text else {}))
            self._call("Input.dispatchKeyEvent", type="keyUp", **about)

    def click(self, x: float, y: float) -> None:
        about = {"x": x, "y": y, "button": "left", "clickCount": 1}
        self._call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        for kind in ("mousePressed", "mouseReleased"):
            self._call("Input.dispatchMouseEvent", type=kind, **about)

    def click_on(self, selector: str, text: str = "") -> None:
        """Clicks the first element that a selector finds and that holds a text."""
        every = f"[...document.querySelectorAll({json.dumps(selector)})]"
        found = f"{every}.find(n => n.innerText.includes({json.dumps(text)}))"
        box = self.wait(
            f"(() => {{ const n = {found}; if (!n) return null; n.scrollIntoView({{block: 'nearest'}});"
            " const b = n.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()"
        )
        self.click(*box)

    def picture(self, path: Path) -> None:
        """Writes a picture of the page (PNG)."""
        path.write_bytes(base64.b64decode(self._call("Page.captureScreenshot", format="png")["data"]))

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        return self._await(lambda found: found.get("id") == self._number)

    def _await(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        while True:
            while b"\0" not in self._rest:
                piece = os.read(self._in, 1 << 16)
                if not piece:
                    raise AssertionError("the browser has ended")
                self._rest += piece
            line, self._rest = self._rest.split(b"\0", 1)
            found = json.loads(line)
            if found.get("method") == "Runtime.exceptionThrown":
                details = found["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description", details["text"]))
            if wanted(found):
                if "error" in found:
                    raise AssertionError(found["error"])
                return found["result"]
