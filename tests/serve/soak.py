#!/usr/bin/env python3
"""tests/serve/soak.py PROGRAM [MINUTES]: a scripted visitor for so long (1): edits, switches of method and
size, reconnects, slow viewers and garbage. At the end memory has stayed level, the live picture is the one
that its log leads to, the exact one that which `render` makes, to the bit, and Ctrl-C ends the server with
0. Numbers are drawn from SEED (1)."""
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

from visitor import Closed, Server, Visitor

PROGRAM, MINUTES = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
SCENE = os.environ.get("SCENE", "scenes/cornell-glossy.json")
SLACK = float(os.environ.get("SLACK", "1"))  # sanitizers are slower, and take more
METHODS = ["splatting", "direct-radiance", "light-octree", "multi-mesh", "shading-cache", "path",
           "bidirectional"]
dice = random.Random(int(os.environ.get("SEED", "1")))


def vector(least, most):
    return [dice.uniform(least, most) for _ in range(3)]


def an_edit(scene):
    kind = dice.choice(["object", "material", "light", "add-light", "remove-light", "sky", "sun"])
    lights = len(scene["lights"])
    if kind == "object":
        x, z = dice.uniform(-30, 30), dice.uniform(-30, 30)
        return {"kind": kind, "object": dice.choice([6, 7]), "matrix": [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, z]}
    if kind == "material":
        return {"kind": kind, "material": dice.randint(2, 5), "diffuse": vector(0, 0.5),
                "specular": vector(0, 0.4), "exponent": dice.choice([1, 20, 200])}
    if kind == "add-light" and lights < 6:
        return {"kind": kind, "position": [dice.uniform(100, 450) for _ in range(3)], "power": vector(0, 5e4)}
    if kind in ("light", "remove-light") and lights:
        number = {"kind": kind, "light": dice.randint(1, lights)}
        return number if kind == "remove-light" else {**number, "scale": dice.uniform(0.5, 2)}
    return {"kind": "material", "material": 6, "emission": vector(0, 20)}


def garbage(server):
    """Somebody who knows no manners; the server goes on for the others."""
    way = dice.randint(0, 6)
    try:
        if way == 0:
            Visitor(server, token="0" * 32)
            raise AssertionError("let in without a token")
        if way == 1:
            Visitor(server, origin="http://elsewhere.example")
            raise AssertionError("let in from elsewhere")
        if way == 2:
            server.fetch("/" + "x" * dice.randint(1, 3000))
            return
        v = Visitor(server)
        if way == 3:
            v.send(bytes(dice.randrange(256) for _ in range(dice.randint(1, 300))))
        elif way == 4:
            v.send(b'{"do":"edit","edits":' + b"[" * 3000)
        elif way == 5:
            v.send(b"{" + b"x" * 20000)
        else:
            v.socket.sendall(os.urandom(dice.randint(1, 200)))  # no WebSocket any more
            v.close()
            return
        while True:
            if v.read(10) is None:
                raise AssertionError("garbage is not answered")
    except (Closed, ConnectionError, OSError):
        pass


def drain(visitor, seconds):
    """Reads for a while; the newest description of the scene, if any."""
    scene, end = None, time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        message = visitor.read(left)
        if message and message.get("is") == "scene":
            scene = message
    return scene


def a_while(visitor, scene):
    act = dice.random()
    if act < 0.45:
        for i in range(dice.randint(2, 15)):
            visitor.say(do="camera", eye=[278 + dice.uniform(-60, 60), 273, -790], target=[278, 273, 280])
            scene = drain(visitor, 0.03) or scene
    elif act < 0.75:
        for i in range(dice.randint(1, 8)):
            visitor.say(do="edit", edits=[an_edit(scene)], drag=i % 3 > 0)
            scene = drain(visitor, 0.05) or scene
    elif act < 0.85:
        visitor.say(do=dice.choice(["undo", "redo"]))
    elif act < 0.93:
        side = dice.choice("aab")
        visitor.say(do="method", side=side, name=dice.choice(METHODS + [""] * (side == "b")))
    elif act < 0.95:
        visitor.say(do="size", width=dice.choice([64, 96, 128]), height=dice.choice([64, 96]))
    elif act < 0.97:
        visitor.say(do=dice.choice(["reference", "difference", "error"]), on=dice.random() < 0.4)
    else:
        visitor.say(do=dice.choice(["story", "pick"]), x=dice.randint(0, 60), y=dice.randint(0, 60))
        visitor.say(do="passes", on=dice.random() < 0.3)
    return drain(visitor, 0.1) or scene


def compare(one, other):
    result = subprocess.run([PROGRAM, "compare", one, other, "--json"], capture_output=True, text=True,
                            check=True)
    assert json.loads(result.stdout)["identical"], f"{one} and {other} differ"


def check_pictures(server, visitor, folder):
    wait = 600 * SLACK
    visitor.say(do="passes", on=False)
    for what in ("reference", "difference", "error"):
        visitor.say(do=what, on=False)
    visitor.say(do="keep", what="log")
    kept = visitor.wait_for(lambda m: m.get("is") == "kept" and m["what"] == "log", wait)
    log = os.path.join(folder, kept["name"])
    subprocess.run([PROGRAM, "serve", SCENE, "--replay", log, "-o", folder], check=True)
    compare(log.replace(".json", "-a.exr"), os.path.join(folder, "replay-1.exr"))
    visitor = Visitor(server)  # who has read nothing for minutes is let go
    visitor.wait_for(lambda m: m.get("is") == "hello", wait)
    visitor.say(do="method", name="direct-radiance")
    visitor.say(do="exact")
    told = visitor.wait_for(lambda m: m.get("is") == "exact" and m["done"], wait)
    words = told["command"].split()
    subprocess.run([PROGRAM, *words[1:-1], os.path.join(folder, "render.exr"), "--quiet"], check=True)
    compare(words[-1], os.path.join(folder, "render.exr"))


def main():
    folder = tempfile.mkdtemp()
    server = Server(PROGRAM, SCENE, "-s", "96x96", "-m", "direct-radiance", "-o", folder, "--quiet")
    visitor, slow = Visitor(server), Visitor(server, slow=True)
    hello = visitor.wait_for(lambda m: m.get("is") == "hello", 300 * SLACK)
    scene, begin, told, levels, turns = hello["scene"], time.monotonic(), 0, [], 0
    while time.monotonic() - begin < 60 * MINUTES:
        scene, turns = a_while(visitor, scene), turns + 1
        if turns % 7 == 0:
            garbage(server)
        if turns % 11 == 0:  # a reload in the middle of a drag
            visitor.close()
            visitor = Visitor(server)
            scene = visitor.wait_for(lambda m: m.get("is") == "hello", 300 * SLACK)["scene"]
        if turns % 13 == 0:
            slow.close()
            slow = Visitor(server, slow=True)
        if (minute := int((time.monotonic() - begin) / 60 * 4)) > told:
            told = minute
            levels.append(server.memory_kib())
            if minute % 20 == 0:
                print(f"{minute / 4:.0f} min: {levels[-1] // 1024} MiB, {server.descriptors()} descriptors",
                      flush=True)
    check_pictures(server, visitor, folder)
    status = server.stop()
    half = len(levels) // 2
    first, last = max(levels[:half] or [1]), max(levels[half:] or [1])
    print(f"{turns} turns in {MINUTES:g} min, memory {first // 1024} MiB at most in the first half, "
          f"{last // 1024} MiB in the second")
    shutil.rmtree(folder)
    assert status == 0, f"the server ends with {status}"
    assert MINUTES < 30 or last < 1.15 * first + 8192, f"memory grows: {levels}"


main()
