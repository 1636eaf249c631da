"""Opens pages in headless Chromium, measures them and takes screenshots. Requires only the standard library.

    look.py CHROMIUM PAGE FOLDER

For each width and colour scheme it prints a line of JSON: the width of the window, the scheme, the width of the
content, the elements that reach beyond the window, the colour of the page, and whatever the browser complained of.
The browser is driven over a pipe, as its protocol says: https://chromedevtools.github.io/devtools-protocol/.
"""

import base64
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SCREENS = [(1280, 900), (360, 800)]
SCHEMES = ["light", "dark"]

# Chromium takes no screenshots of more than about 16,000 pixels. Measurements include the rest of the page.
HIGHEST = 8000

# The elements that extend beyond the window, the color of the page, and its headings.
MEASURE = """JSON.stringify({
  content: document.documentElement.scrollWidth,
  height: document.documentElement.scrollHeight,
  window: innerWidth,
  beyond: [...document.body.querySelectorAll('*')]
    .filter(one => one.getBoundingClientRect().right > innerWidth + 0.5)
    .map(one => one.outerHTML.slice(0, 120)).slice(0, 5),
  background: getComputedStyle(document.body).backgroundColor,
  heading: document.querySelector('h1').textContent,
  scripts: document.scripts.length,
})"""


class Browser:
    def __init__(self, program, profile):
        # The browser reads from file descriptor 3 and writes to 4.
        to_read, self.to = os.pipe()
        self.of, to_write = os.pipe()
        command = [
            program, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
            "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank",
        ]
        shell = f'exec "$@" 3<&{to_read} 4>&{to_write}'
        self.process = subprocess.Popen(
            ["bash", "-c", shell, "bash", *command], pass_fds=(to_read, to_write), stderr=subprocess.DEVNULL
        )
        os.close(to_read)
        os.close(to_write)
        self.rest, self.last, self.events = b"", 0, []
        target = self.ask("Target.createTarget", {"url": "about:blank"})["targetId"]
        session = self.ask("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        self.session = session

    session = None

    def ask(self, method, params=None):
        self.last += 1
        message = {"id": self.last, "method": method, "params": params or {}}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while (answer := self.read()).get("id") != self.last:
            self.events.append(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def read(self):
        while b"\0" not in self.rest:
            chunk = os.read(self.of, 1 << 16)
            if not chunk:
                raise RuntimeError("the browser ended")
            self.rest += chunk
        line, self.rest = self.rest.split(b"\0", 1)
        return json.loads(line)

    def wait(self, event):
        while all(seen.get("method") != event for seen in self.events):
            self.events.append(self.read())

    def end(self):
        self.process.terminate()
        self.process.wait()


def look(browser, page, folder, width, height, scheme):
    browser.ask(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500},
    )
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.ask("Emulation.setEmulatedMedia", {"features": features})
    browser.events.clear()
    browser.ask("Page.navigate", {"url": page.resolve().as_uri()})
    browser.wait("Page.loadEventFired")
    told = [event["params"] for event in browser.events if event.get("method") == "Log.entryAdded"]
    asked = [event for event in browser.events if event.get("method") == "Network.requestWillBeSent"]
    measures = {}
    # Collapsed elements must fit as well; the screenshot shows the page in its initial state.
    for name, before in [("closed", ""), ("open", "document.querySelectorAll('details').forEach(d => d.open = true);")]:
        result = browser.ask("Runtime.evaluate", {"expression": before + MEASURE})["result"]
        measures[name] = json.loads(result["value"])
        if name == "closed":
            clip = {"x": 0, "y": 0, "width": width, "height": min(measures[name]["height"], HIGHEST), "scale": 1}
            picture = browser.ask("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})["data"]
            path = folder / f"{page.stem}-{width}-{scheme}.png"
            path.write_bytes(base64.b64decode(picture))
    print(json.dumps({
        "width": width, "scheme": scheme, "told": told, "requests": len(asked), **measures,
    }))


def main():
    program, page, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        try:
            for domain in ["Page", "Log", "Network", "Runtime"]:
                browser.ask(f"{domain}.enable")
            for width, height in SCREENS:
                for scheme in SCHEMES:
                    look(browser, page, folder, width, height, scheme)
        finally:
            browser.end()


main()
