"""A page in headless Chromium, driven through the pipe of its DevTools protocol: no port, no further library."""
import atexit
import base64
import io
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

import numpy as np
from PIL import Image

CHROMIUM = shutil.which("chromium")


class Chromium:
    """The process, and the pipes to it. It takes a second to start: all pages of a program are opened in one."""

    running = None

    @classmethod
    def shared(cls):
        if cls.running is None:
            cls.running = cls()
            atexit.register(cls.running.stop)
        return cls.running

    def __init__(self):
        self.last = 0
        self._buffer = b""
        self._profile = tempfile.mkdtemp(prefix="pliant-browser-")
        read_commands, self._commands = os.pipe()
        self._events, write_events = os.pipe()
        # Chromium reads commands from descriptor 3 and writes to 4. Pictures are drawn without a graphics card.
        arguments = [CHROMIUM, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--disable-dev-shm-usage",
                     "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                     "--disable-extensions", "--no-first-run", "--disable-background-networking", "--disable-component-update",
                     f"--user-data-dir={self._profile}", "about:blank"]
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", f'exec "$@" 3<&{read_commands} 4>&{write_events}', "bash", *arguments],
            pass_fds=(read_commands, write_events), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(read_commands)
        os.close(write_events)

    def stop(self):
        atexit.unregister(self.stop)
        Chromium.running = None
        for descriptor in (self._commands, self._events):
            os.close(descriptor)
        self._process.terminate()
        self._process.wait(timeout=20)
        shutil.rmtree(self._profile, ignore_errors=True)

    def send(self, message):
        """Returns the number of the message."""
        self.last += 1
        os.write(self._commands, json.dumps({"id": self.last, **message}).encode() + b"\0")
        return self.last

    def receive(self, end):
        """Messages that have come; none if it has ended, or says nothing until then."""
        ready, _, _ = select.select([self._events], [], [], max(0.0, end - time.monotonic()))
        read = os.read(self._events, 1 << 20) if ready else b""
        if not read:
            self.stop()  # the next page has another one
            return None
        *messages, self._buffer = (self._buffer + read).split(b"\0")
        return list(map(json.loads, messages))


class Browser:
    """A window with one page; to be used with `with`. Collects in `errors` whatever the page complains of."""

    def __init__(self, size=(1280, 900)):
        self.errors = []
        self._answers = {}
        self._session = None
        self._chromium = Chromium.shared()
        self._target = self.call("Target.createTarget", url="about:blank", newWindow=True, width=size[0], height=size[1])["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=self._target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.resize(*size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._chromium is Chromium.running:
            self._session = None
            self.call("Target.closeTarget", targetId=self._target)

    def call(self, method, timeout=60, **parameters):
        """The answer of the browser to a command."""
        number = self._chromium.send({"method": method, "params": parameters} | ({"sessionId": self._session} if self._session else {}))
        end = time.monotonic() + timeout
        while number not in self._answers:
            self._receive(end, method)
        answer = self._answers.pop(number)
        if "error" in answer:
            raise AssertionError(f"{method}: {answer['error']}")
        return answer["result"]

    def _receive(self, end, method):
        messages = self._chromium.receive(end)
        if messages is None:
            raise AssertionError(f"{method}: the browser does not answer; it complained of {self.errors}")
        for message in messages:
            if "id" in message:
                self._answers[message["id"]] = message
            elif message.get("sessionId") != self._session:
                continue  # of a page that was closed
            elif message["method"] == "Runtime.exceptionThrown":
                details = message["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description", details["text"]))
            elif message["method"] == "Runtime.consoleAPICalled" and message["params"]["type"] in ("error", "assert"):
                self.errors.append(str([a.get("value", a.get("description")) for a in message["params"]["args"]]))
            elif message["method"] == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
                self.errors.append(message["params"]["entry"]["text"])

    def resize(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def prefer(self, scheme):
        """`light` or `dark`."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def open(self, file):
        self.call("Page.navigate", url=f"file://{os.path.abspath(file)}")

    def evaluate(self, expression):
        """The value of a JavaScript expression; of a promise, what it promised."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise AssertionError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, expression, timeout=40):
        """Until it is true."""
        end = time.monotonic() + timeout
        while not self.evaluate(expression):
            if time.monotonic() > end:
                raise AssertionError(f"never true: {expression}; the page complained of {self.errors}")
            time.sleep(0.05)

    def drawn(self):
        """Waits until the page has drawn what was set."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def click(self, place):
        """The mouse on the middle of an element, or on (x, y) of the window."""
        if isinstance(place, str):
            place = self.evaluate(f"""(element => {{ element.scrollIntoView({{ block: "nearest" }});
                const {{ x, y, width, height }} = element.getBoundingClientRect(); return [x + width / 2, y + height / 2];
            }})(document.querySelector({json.dumps(place)}))""")
        x, y = place
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        self.drawn()

    def press(self, *keys):
        """Keys of the keyboard, by their names: "ArrowLeft", " ", "5"."""
        codes = {"Tab": 9, "Enter": 13, " ": 32, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40}
        for key in keys:
            text = {"Enter": "\r"}.get(key, key if len(key) == 1 else None)
            more = {"key": key, "code": {" ": "Space"}.get(key, key), "windowsVirtualKeyCode": codes.get(key, ord(key.upper()) if key.isalnum() and len(key) == 1 else 0)}
            self.call("Input.dispatchKeyEvent", type="keyDown", **more, **({"text": text} if text else {}))
            self.call("Input.dispatchKeyEvent", type="keyUp", **more)
        self.drawn()

    def enter(self, selector, text):
        """Another text in a field."""
        self.click(selector)
        self.evaluate(f"document.querySelector({json.dumps(selector)}).select()")
        self.press(*text, "Enter")

    def choose(self, selector, text):
        """The option of a list whose text begins so, as a user does who does not look at the menu: by its keys."""
        self.evaluate(f"document.querySelector({json.dumps(selector)}).focus()")
        at, to = self.evaluate(f"""(list => [list.selectedIndex, [...list.options].findIndex(o => o.textContent.startsWith({json.dumps(text)}))]
            )(document.querySelector({json.dumps(selector)}))""")
        if to < 0:
            raise AssertionError(f"{selector} has no choice {text}")
        self.press(*abs(to - at) * ["ArrowDown" if to > at else "ArrowUp"])
        self.drawn()

    def picture(self, selector=None, file=None):
        """Pixels of an element, or of the window: height x width x 3."""
        more = {}
        if selector:
            x, y, width, height = self.evaluate(
                f"(({{x, y, width, height}}) => [x + scrollX, y + scrollY, width, height])(document.querySelector({json.dumps(selector)})"
                ".getBoundingClientRect())")
            more = {"clip": {"x": x, "y": y, "width": width, "height": height, "scale": 1}, "captureBeyondViewport": True}
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png", **more)["data"])
        if file:
            with open(file, "wb") as output:
                output.write(png)
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
