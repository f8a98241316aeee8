"""A Chromium that a test drives: keys, widths, files, what it says."""

import base64
import json
import shutil
import socket
import struct
import subprocess
import time
from contextlib import suppress
from urllib.request import urlopen

from einschalt.interfaces.reports.pdf_printer import BROWSERS, OPTIONS

PROGRAM = next((found for name in BROWSERS if (found := shutil.which(name))), None)
# with these it prints or draws a page, and opens no tab
OF_PRINTING = ("--virtual-time-budget", "--no-pdf-header-footer")
LIVING = [word for word in OPTIONS if not word.startswith(OF_PRINTING)]
PATIENCE = 60.0  # seconds, of computers that others use as well
KEYS = {
    "Tab": ("Tab", 9, ""),
    "Enter": ("Enter", 13, "\r"),
    "Right": ("ArrowRight", 39, ""),
}


class WebSocket:
    """As much of one as is needed to speak with a browser on this computer."""

    def __init__(self, address):
        host, _, path = address.removeprefix("ws://").partition("/")
        name, _, port = host.partition(":")
        self.socket = socket.create_connection((name, int(port)), timeout=PATIENCE)
        lines = [f"GET /{path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket"]
        lines += ["Connection: Upgrade", "Sec-WebSocket-Version: 13"]
        lines += ["Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", "", ""]
        self.socket.sendall("\r\n".join(lines).encode())
        self.file = self.socket.makefile("rb")
        while self.file.readline().strip():
            pass

    def send(self, text):
        data = text.encode()
        head = struct.pack("!BBQ", 0x81, 0x80 | 127, len(data))
        self.socket.sendall(head + bytes(4) + data)  # a mask that changes nothing

    def receive(self):
        whole, is_last = b"", False
        while not is_last:
            first, size = self.file.read(2)
            is_last = bool(first & 0x80)
            if size > 125:
                kind = "!H" if size == 126 else "!Q"
                (size,) = struct.unpack(kind, self.file.read(struct.calcsize(kind)))
            whole += self.file.read(size)
        return whole.decode()

    def close(self):
        self.file.close()
        self.socket.close()


class Chromium:
    """One tab of a Chromium; commands and answers of its DevTools protocol."""

    def __init__(self, folder):
        self.process = subprocess.Popen(
            [
                *(PROGRAM, *LIVING, "--no-sandbox", "--remote-debugging-port=0"),
                *(f"--user-data-dir={folder}", "about:blank"),
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.port_file = folder / "DevToolsActivePort"
        self.n_sent, self.errors, self.requests = 0, [], []
        self.socket = None

    def start(self):
        """Take its one tab, and listen."""
        end, pages = time.monotonic() + PATIENCE, []
        while not pages:
            assert time.monotonic() < end, "Chromium does not start"
            time.sleep(0.1)
            with suppress(OSError, IndexError):
                port = self.port_file.read_text().split()[0]
                with urlopen(f"http://127.0.0.1:{port}/json/list") as answer:
                    known = json.loads(answer.read())
                pages = [one for one in known if one["type"] == "page"]
        self.socket = WebSocket(pages[0]["webSocketDebuggerUrl"])
        for domain in ("Page", "Runtime", "Log", "Network", "DOM"):
            self(f"{domain}.enable")

    def __call__(self, method, **parameters):
        """Give a command, and wait for its answer."""
        self.n_sent += 1
        command = {"id": self.n_sent, "method": method, "params": parameters}
        self.socket.send(json.dumps(command))
        while True:
            message = json.loads(self.socket.receive())
            if message.get("id") == self.n_sent:
                assert "error" not in message, message
                return message["result"]
            self._hear(message)

    def _hear(self, message):
        method, facts = message.get("method"), message.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(facts["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append(str(facts["exceptionDetails"])[:500])
        elif method == "Log.entryAdded" and facts["entry"]["level"] == "error":
            self.errors.append(facts["entry"]["text"])
        elif method == "Runtime.consoleAPICalled" and facts["type"] == "error":
            self.errors.append(str(facts["args"])[:500])

    def value(self, script):
        """Value of an expression in the page."""
        how = {"awaitPromise": True, "returnByValue": True}
        found = self("Runtime.evaluate", expression=script, **how)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def until(self, script):
        """Wait until an expression is true; it may be asked of any page."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            try:
                value = self.value(
                    f"document.readyState === 'complete' && Boolean({script})"
                )
            except AssertionError:  # the page has changed while it was asked
                value = None
            if value:
                return value
            time.sleep(0.05)
        where = self.value("[location.href, document.body.innerText]")
        raise AssertionError((script, where))

    def open(self, address):
        """Load a page."""
        self("Page.navigate", url=address)
        self.until(f"location.href.startsWith({json.dumps(address.partition('?')[0])})")

    def press(self, key):
        """Press a key, and let it go."""
        name, code, text = KEYS[key]
        key = {"key": name, "code": name, "windowsVirtualKeyCode": code}
        self("Input.dispatchKeyEvent", type="keyDown", text=text, **key)
        self("Input.dispatchKeyEvent", type="keyUp", **key)

    def tab_to(self, text):
        """Move by the Tab key to what has a text or label."""
        said = "(document.activeElement.innerText || document.activeElement.name || '')"
        for _ in range(60):
            self.press("Tab")
            if self.value(f"{said}.trim()") == text:
                # where one is must be seen
                outline = "getComputedStyle(document.activeElement).outlineStyle"
                assert self.value(outline) != "none"
                return
        raise AssertionError(f"no {text!r} is reached by Tab")

    def look(self, width, *, dark=False):
        """Take a width [pixels] and a scheme of colours."""
        size = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": False}
        self("Emulation.setDeviceMetricsOverride", **size)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self("Emulation.setEmulatedMedia", features=[scheme])

    def picture(self, path):
        """Keep a picture of the whole page."""
        wide, high = self.value("[innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": wide, "height": high, "scale": 1}
        how = {"captureBeyondViewport": True, "clip": clip}
        data = self("Page.captureScreenshot", **how)["data"]
        path.write_bytes(base64.b64decode(data))

    def choose(self, selector, files):
        """Choose files in an input."""
        root = self("DOM.getDocument")["root"]["nodeId"]
        node = self("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self("DOM.setFileInputFiles", files=[str(file) for file in files], nodeId=node)

    def end(self):
        """End it."""
        if self.socket is not None:
            self.socket.close()
        self.process.kill()
        self.process.wait()
