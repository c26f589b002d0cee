#!/usr/bin/env python3
"""tests/serve/browser_speed.py PROGRAM SCENE... [--methods a,b] [--size 512x512] [--seconds 5] [--lamp]
[--eye X,Y,Z] [--target X,Y,Z]: frames a second that a headless browser shows while its pointer orbits, and
milliseconds from the pointer's event to the frame that shows it, as the page itself counts them; with --lamp
the first lamp is carried to and fro instead, from a picture that is done or a minute old, and it tells how
far from its last picture the page was when the lamp stopped, and the seconds until half of that was gone, and
nine tenths. The browser takes its share of the processors."""
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
        self.ask("POST", "/timeouts", {"script": 110000})

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


# Looks ten times a second at a small copy of the picture, of values between 0 and 1 as a screen shows them.
LAMP = """
const [seconds, done] = arguments, picture = document.getElementById("left"), size = 128, looks = [];
const small = new OffscreenCanvas(size, size).getContext("2d", {willReadFrequently: true});
const look = at => {
  small.drawImage(picture, 0, 0, size, size);
  looks.push({at, values: small.getImageData(0, 0, size, size).data});
};
const apart = (a, b) => Math.sqrt(a.reduce((sum, x, i) => sum + (x - b[i]) ** 2, 0) / a.length) / 255;
const gone = (errors, share) => looks.find((l, i) => errors[i] <= share * errors[0])?.at;
const tell = () => {
  const last = looks[looks.length - 1], errors = looks.map(l => apart(l.values, last.values));
  done({wrong: errors[0], half: gone(errors, .5), tenth: gone(errors, .1)});
};
const carry = edit => {
  const {objects, materials} = softlux.world.scene, low = Math.min(...objects.map(o => o.bounds[0])),
        reach = .2 * (Math.max(...objects.map(o => o.bounds[3])) - low), start = performance.now(),
        lamp = objects.find(o => materials.some(m => m.material === o.material && m.emission.some(e => e > 0)));
  const wait = () => {
    const at = (performance.now() - start) / 1000 - seconds;
    look(at);
    if (softlux.states.a.done && at > 2 || at > 40) tell();
    else setTimeout(wait, 100);
  };
  const step = () => {
    const t = (performance.now() - start) / 1000, x = lamp.matrix[3] + reach * Math.sin(t);
    if (t >= seconds) return wait();
    edit({kind: "object", object: lamp.object, matrix: lamp.matrix.with(3, x)}, true);
    requestAnimationFrame(step);
  };
  step();
};
import(new URL("touch.js", document.querySelector("script[type=module]").src)).then(touch => carry(touch.edit));
"""


def play(browser, script, seconds):
    return browser.ask("POST", "/execute/async", {"script": script, "args": [seconds]})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--methods",
                        default="direct-radiance,light-octree,multi-mesh,shading-cache,splatting")
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--lamp", action="store_true")
    parser.add_argument("--eye", help="of serve: an orbit inside of walls must stay there")
    parser.add_argument("--target")
    options = parser.parse_args()
    view = [word for name, at in (("--eye", options.eye), ("--target", options.target)) if at
            for word in (name, at)]
    browser = Browser(9517)
    told = "wrong %  to half s  to a tenth s" if options.lamp else "frames/s  KB/s  median ms  95 % ms"
    print(f"{'scene':24} {'method':16} {told}")
    for scene in options.scenes:
        for method in options.methods.split(","):
            server = Server(options.program, scene, "-s", options.size, "-m", method, "--quiet", *view)
            browser.ask("POST", "/url", {"url": server.address})
            while not browser.tell("return document.querySelector('#frame.ready') !== null"):
                time.sleep(0.2)
            time.sleep(2.0)
            for _ in range(120 if options.lamp else 0):
                if browser.tell("return softlux.states.a?.done"):
                    break
                time.sleep(0.5)
            s = play(browser, LAMP if options.lamp else DRAG, options.seconds)
            print(f"{scene.rsplit('/')[-1]:24} {method:16} " +
                  (f"{100 * s['wrong']:7.2f} {s['half']:10.2f} {s['tenth']:13.2f}" if options.lamp else
                   f"{s['frames']:8.1f} {s['bytes'] / 1e3:5.0f} {s['median'] or 0:10.0f} {s['late'] or 0:8.0f}"),
                  flush=True)
            browser.ask("POST", "/url", {"url": "about:blank"})
            server.stop()
    browser.close()


main()
