"""Chromium without a window, driven over a pipe by the DevTools protocol: real mouse and keys."""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape

from inspector.widgets.fonts import font_folder

# No screen, no graphics card, no network of its own.
OPTIONS = (
    *("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-background-networking", "--disable-component-update", "--no-first-run"),
    *("--disable-sync", "--disable-extensions", "--metrics-recording-only", "--mute-audio"),
)
PATIENCE = 60.0  # seconds


def found_browser() -> str | None:
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((found for name in names if (found := shutil.which(name))), None)


def with_fonts(profile: Path) -> Path:
    """A configuration of fonts with the program's own beside the machine's, which may have none."""
    profile.mkdir(parents=True, exist_ok=True)
    own = profile / "fonts.conf"
    machine = os.environ.get("FONTCONFIG_FILE", "/etc/fonts/fonts.conf")
    own.write_text(
        f'<fontconfig><include ignore_missing="yes">{escape(machine)}</include>'
        f"<dir>{escape(str(font_folder()))}</dir></fontconfig>"
    )
    return own


class Browser:
    """One page of one browser; `messages`: whatever it said, `asked`: whatever it fetched."""

    def __init__(self, profile: Path, *options: str) -> None:
        program = found_browser()
        assert program, "no Chromium here: python3 dev.py test installs one"
        to_browser, self._to = os.pipe()
        self._from, from_browser = os.pipe()

        def as_three_and_four() -> None:  # where Chromium looks for its pipe
            os.dup2(to_browser, 1003)
            os.dup2(from_browser, 1004)
            os.dup2(1003, 3)
            os.dup2(1004, 4)

        command = [program, *OPTIONS, *options, f"--user-data-dir={profile}"]
        self._process = subprocess.Popen(
            [*command, "--remote-debugging-pipe", "about:blank"],
            preexec_fn=as_three_and_four,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"HOME": str(profile), "FONTCONFIG_FILE": str(with_fonts(profile))},
        )
        os.close(to_browser)
        os.close(from_browser)
        self._buffer, self._number, self._session = b"", 0, ""
        self.messages: list[str] = []
        self.asked: list[str] = []
        self._events: list[str] = []
        self._shown = ""
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(t["targetId"] for t in targets if t["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=page, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(PATIENCE)
        os.close(self._to)
        os.close(self._from)

    def call(self, method: str, **parameters: object) -> dict:
        """One command and its answer."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            said = self._hear()
            if said.get("id") == self._number:
                assert "error" not in said, (method, said["error"])
                return said["result"]

    def open(self, address: str) -> None:
        """Load a page, and wait until it is there and drawn."""
        self.load(address)
        self.settle()

    def load(self, address: str) -> None:
        """Load a page; where scripts are off nobody can tell when it is drawn."""
        # A page that is open already is loaded again, and an anchor of it as well.
        again = "#" in address or address == self._shown
        for place in ("about:blank", address) if again else (address,):
            self._events.clear()
            self.call("Page.navigate", url=place)
            while "Page.loadEventFired" not in self._events:
                self._hear()
        self._shown = address

    @contextlib.contextmanager
    def without_scripts(self) -> Iterator[None]:
        """Pages that are loaded meanwhile run none."""
        self.call("Emulation.setScriptExecutionDisabled", value=True)
        try:
            yield
        finally:
            self.call("Emulation.setScriptExecutionDisabled", value=False)

    def words(self) -> str:
        """The text of the page's elements that are laid out; no script of ours tells it."""
        tree = self.call("Accessibility.getFullAXTree")["nodes"]
        texts = (n for n in tree if n["role"]["value"] == "StaticText")
        return " ".join(str(n["name"]["value"]) for n in texts)

    def tell(self, script: str) -> object:
        """The value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True,
                           awaitPromise=True)  # fmt: skip
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def settle(self) -> None:
        """Until the page has drawn twice."""
        twice = "requestAnimationFrame(() => requestAnimationFrame(done))"
        self.tell(f"new Promise((done) => {twice})")

    def drag(self, start: tuple[float, float], stop: tuple[float, float], steps: int = 8) -> None:
        """With the left button, in steps."""
        self._mouse("mouseMoved", *start)
        self._mouse("mousePressed", *start)
        for k in range(1, steps + 1):
            x, y = (a + (b - a) * k / steps for a, b in zip(start, stop, strict=True))
            self._mouse("mouseMoved", x, y)
        self._mouse("mouseReleased", *stop)
        self.settle()

    def click(self, selector: str) -> None:
        """In the middle of an element."""
        x, y = self.middle(selector)
        self._mouse("mouseMoved", x, y)
        self._mouse("mousePressed", x, y)
        self._mouse("mouseReleased", x, y)
        self.settle()

    def press(self, key: str) -> None:
        """A key by its name, such as ArrowRight or Tab."""
        codes = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9,
                 "Enter": 13, "End": 35, "Home": 36, "b": 66}  # fmt: skip
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode=codes[key])  # fmt: skip
        self.settle()

    def middle(self, selector: str) -> tuple[float, float]:
        """Of an element, pixels."""
        left, top, wide, high = self.box(selector)
        return left + wide / 2, top + high / 2

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width and height of an element, pixels."""
        found = json.dumps(selector)
        text = self.tell(
            f"(() => {{ const b = document.querySelector({found}).getBoundingClientRect();"
            " return JSON.stringify([b.left, b.top, b.width, b.height]); })()"
        )
        return tuple(json.loads(str(text)))

    def size(self, width: int, height: int, *, dark: bool = False) -> None:
        """Of the page, and the theme that the system asks for."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.settle()

    def picture(self, whole: bool = False) -> bytes:
        """What is seen as a PNG; whole: what has to be scrolled to as well."""
        answer = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        return base64.b64decode(answer["data"])

    def _mouse(self, kind: str, x: float, y: float) -> None:
        down = kind != "mouseReleased"
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1,
                  buttons=int(down))  # fmt: skip

    def _hear(self) -> dict:
        """The next message; what the page says and fetches is noted."""
        ends = time.monotonic() + PATIENCE
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._from], [], [], max(ends - time.monotonic(), 0.0))
            chunk = os.read(self._from, 1 << 20) if ready else b""
            assert chunk, "Chromium says nothing any more"
            self._buffer += chunk
        text, self._buffer = self._buffer.split(b"\0", 1)
        said = json.loads(text)
        method, own = said.get("method", ""), said.get("params", {})
        self._events.append(method)
        if method == "Runtime.consoleAPICalled":
            self.messages.append(" ".join(str(a.get("value")) for a in own["args"]))
        elif method == "Runtime.exceptionThrown":
            details = own["exceptionDetails"]
            self.messages.append(str(details.get("exception", details).get("description")))
        elif method == "Log.entryAdded":
            self.messages.append(own["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.asked.append(own["request"]["url"])
        return said
