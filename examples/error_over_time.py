#!/usr/bin/env python3
"""Draws the error of pictures over the time that they took, by two methods, as an SVG. Wants the package
softlux (docs/python.md) and nothing else.

    python3 examples/error_over_time.py [SCENE [OUT.svg [WIDTHxHEIGHT [SAMPLES]]]]

Both are held against the light paths that splatting computes, traced with so many samples a pixel: what is
left is error, not what a method leaves out.
"""
import sys
import time
from math import floor, log10

import softlux

METHODS = {"splatting": "#c0392b", "path": "#2460a7"}
WIDTH, HEIGHT, MARGIN = 640, 400, 60


def errors_over_time(scene, settings, reference):
    """Seconds and relative squared error after each batch, without the share of the reference's own noise."""
    method = softlux.Method(scene, settings, seed=1)
    seconds, points = 0.0, []
    begin = time.perf_counter()
    for progress in method:
        seconds += time.perf_counter() - begin
        told = softlux.compare(method.resolve(), reference)
        error = told.rel_mse - told.rel_mse_noise
        points.append((seconds, error))
        print(f"{settings['method']:12} {seconds:8.3f} s  {100 * progress.fraction:3.0f} %  relative MSE {error:.6f}")
        begin = time.perf_counter()  # what looking takes does not count
    return [(x, y) for x, y in points if x > 0 and y > 0]


def drawing(curves):
    """An SVG with decades on both axes."""
    every = [point for points in curves.values() for point in points]
    low, high = zip(*((floor(log10(min(v))), floor(log10(max(v))) + 1) for v in zip(*every)))

    def at(axis, value):
        share = (log10(value) - low[axis]) / (high[axis] - low[axis])
        across, down = WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN
        return MARGIN + share * across if axis == 0 else HEIGHT - MARGIN - share * down

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             'font-family="sans-serif" font-size="13"><rect width="100%" height="100%" fill="white"/>']
    for power in range(low[0], high[0] + 1):
        x = at(0, 10.0**power)
        parts.append(f'<path d="M{x:.1f} {MARGIN}V{HEIGHT - MARGIN}" stroke="#ddd"/>'
                     f'<text x="{x:.1f}" y="{HEIGHT - MARGIN + 20}" text-anchor="middle">'
                     f'{10.0**power:g} s</text>')
    for power in range(low[1], high[1] + 1):
        y = at(1, 10.0**power)
        parts.append(f'<path d="M{MARGIN} {y:.1f}H{WIDTH - MARGIN}" stroke="#ddd"/>'
                     f'<text x="{MARGIN - 8}" y="{y + 4:.1f}" text-anchor="end">{10.0**power:g}</text>')
    for row, (method, points) in enumerate(curves.items()):
        line = " ".join(f"{at(0, x):.1f},{at(1, y):.1f}" for x, y in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{METHODS[method]}" stroke-width="2"/>'
                     f'<text x="{WIDTH - MARGIN}" y="{MARGIN + 18 * row}" text-anchor="end" '
                     f'fill="{METHODS[method]}">{method}</text>')
    parts.append(f'<text x="{MARGIN}" y="{MARGIN - 20}">relative MSE over time</text></svg>\n')
    return "\n".join(parts)


def main(path="scenes/cornell.json", out="error.svg", size="100x100", samples="256"):
    scene = softlux.Scene.load(path)
    settings = {"size": size, "filter": "centre", "bounces": 1, "transport": "matched:splatting"}
    reference = softlux.render(scene, settings, method="path", spp=samples)
    curves = {name: errors_over_time(scene, {**settings, "method": name}, reference) for name in METHODS}
    with open(out, "w", encoding="utf-8") as file:
        file.write(drawing(curves))
    print(out)


if __name__ == "__main__":
    main(*sys.argv[1:])
