#!/usr/bin/env python3
"""tests/serve/browser_speed.py PROGRAM SCENE... [--methods a,b] [--size 512x512] [--seconds 5]: frames a
second that a headless browser shows while its pointer orbits, and milliseconds from the pointer's event to
the frame that shows it, as the page itself counts them. The browser takes its share of the processors."""
import argparse
import json
import subprocess
import time
import urllib.request

from visitor import Server

ARGUMENTS = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu",
             "--window-size=1200,900"]


class Browser:
    def __init__(self, port):
        self.driver = subprocess.Popen(["chromedriver", f"--port={port}", "--silent"])
        self.root = f"http://127.0.0.1:{port}"
        time.sleep(1.0)
        match = {"browserName": "chrome", "goog:chromeOptions": {"args": ARGUMENTS}}
        answer = self.ask("POST", "/session", {"capabilities": {"alwaysMatch": match}})
        self.root += "/session/" + answer["sessionId"]

    def ask(self, verb, path, message=None):
        body = None if message is None else json.dumps(message).encode()
        kind = {"Content-Type": "application/json"}
        request = urllib.request.Request(self.root + path, body, kind, method=verb)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def tell(self, script):
        return self.ask("POST", "/execute/sync", {"script": script, "args": []})

    def close(self):
        self.ask("DELETE", "")
        self.driver.terminate()


# To and fro over the picture, an event for each picture of the screen; the mean of the seconds.
DRAG = """
const [seconds, done] = arguments, frame = document.getElementById("frame"), start = performance.now();
const at = (kind, x) => frame.dispatchEvent(new PointerEvent(kind, {bubbles: true, pointerId: 1, button: 0,
                                                                    buttons: 1, clientX: x, clientY: 300}));
frame.setPointerCapture = () => {};
const of_seconds = [], mean = of => of_seconds.reduce((sum, s) => sum + s[of], 0) / of_seconds.length;
at("pointerdown", 300);
const step = () => {
  const t = (performance.now() - start) / 1000;
  at("pointermove", 300 + 0.4 / Math.PI * frame.clientHeight * Math.sin(t));
  if (t >= of_seconds.length + 1) of_seconds.push(softlux.speed());
  if (t < seconds) requestAnimationFrame(step);
  else done({...softlux.speed(), frames: mean("frames"), bytes: mean("bytes")});
};
step();
"""


def drag(browser, seconds):
    return browser.ask("POST", "/execute/async", {"script": DRAG, "args": [seconds]})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--methods",
                        default="direct-radiance,light-octree,multi-mesh,shading-cache,splatting")
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--seconds", type=float, default=5.0)
    options = parser.parse_args()
    browser = Browser(9517)
    print(f"{'scene':24} {'method':16} frames/s  KB/s  median ms  95 % ms")
    for scene in options.scenes:
        for method in options.methods.split(","):
            server = Server(options.program, scene, "-s", options.size, "-m", method, "--quiet")
            browser.ask("POST", "/url", {"url": server.address})
            while not browser.tell("return document.querySelector('#frame.ready') !== null"):
                time.sleep(0.2)
            time.sleep(2.0)
            s = drag(browser, options.seconds)
            print(f"{scene.rsplit('/')[-1]:24} {method:16} {s['frames']:8.1f} {s['bytes'] / 1e3:5.0f} "
                  f"{s['median'] or 0:10.0f} {s['late'] or 0:8.0f}", flush=True)
            browser.ask("POST", "/url", {"url": "about:blank"})
            server.stop()
    browser.close()


main()
