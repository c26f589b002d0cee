#!/usr/bin/env python3
"""tests/serve/speed.py PROGRAM SCENE... [--methods a,b] [--size 512x512] [--seconds 5]: frames and bytes a
second while a visitor orbits at 60 events a second, and milliseconds from an event to the frame that shows
it, by method; then milliseconds of a processor: to draw a frame, to encode it, and of all threads by
frame."""
import argparse
import math
import time

from visitor import Server, Visitor


def orbit(visitor, camera, seconds):
    """Counts frames, bytes, and the milliseconds of events that frames were the first to show."""
    eye, target = camera["eye"], camera["target"]
    d = [a - b for a, b in zip(eye, target)]
    start = due = time.monotonic()
    waiting, latencies, work, frames, size = {}, [], [], 0, 0
    visitor.say(do="reset")
    event = visitor.wait_for(lambda m: m.get("is") == "did" and m["do"] == "reset")["event"]
    while (now := time.monotonic()) < start + seconds:
        if now >= due:
            due += 1 / 60
            a = 0.4 * math.sin(now - start)
            place = [target[0] + math.cos(a) * d[0] + math.sin(a) * d[2], eye[1],
                     target[2] + math.cos(a) * d[2] - math.sin(a) * d[0]]
            event += 1
            waiting[event] = now
            visitor.say(do="camera", eye=place, target=target, up=[0, 1, 0])
        message = visitor.read(max(0.0, due - time.monotonic()))
        if message and message.get("is") == "state":
            work.append((message["drawing"], message["encoding"]))
        if not message or message.get("kind") != 0:
            continue
        frames, size = frames + 1, size + len(message["file"])
        shown = [e for e in waiting if e <= message["event"]]
        latencies += [1e3 * (time.monotonic() - waiting[e]) for e in shown[-1:]]
        for e in shown:
            del waiting[e]
    means = [sum(w[i] for w in work) / max(1, len(work)) for i in range(2)]
    return frames / seconds, size / seconds, sorted(latencies) or [math.inf], means


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--methods",
                        default="direct-radiance,light-octree,multi-mesh,shading-cache,splatting,path")
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--seconds", type=float, default=5.0)
    options = parser.parse_args()
    print(f"{'scene':24} {'method':16} frames/s  KB/s  median ms  95 % ms  drawing ms "
          "encoding ms all a frame")
    for scene in options.scenes:
        for method in options.methods.split(","):
            server = Server(options.program, scene, "-s", options.size, "-m", method, "--quiet")
            visitor = Visitor(server)
            camera = visitor.wait_for(lambda m: m.get("is") == "hello")["scene"]["camera"]
            visitor.wait_for(lambda m: m.get("kind") == 0)
            time.sleep(1.0)
            before = server.processor_seconds()
            rate, size, late, work = orbit(visitor, camera, options.seconds)
            busy = server.processor_seconds() - before
            print(f"{scene.rsplit('/')[-1]:24} {method:16} {rate:8.1f} {size / 1e3:5.0f} "
                  f"{late[len(late) // 2]:10.0f} {late[int(0.95 * len(late))]:8.0f} "
                  f"{work[0]:10.1f} {work[1]:11.1f} {1e3 * busy / max(1.0, rate * options.seconds):12.1f}",
                  flush=True)
            visitor.close()
            server.stop()


main()
