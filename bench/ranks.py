#!/usr/bin/env python3
"""How much faster many ranks would be: one rank's batches (SOFTLUX_BATCHES, bench/ranks/batch_log.c) on a
network.

bench/ranks.py [--check]       table of docs/many-machines.md; --check: what two ranks do here, beside it
bench/ranks.py LOG...          of logs that are there
bench/ranks.py --network       what exchanges of two ranks take here, beside what is predicted of this network
"""
import math
import os
import subprocess
import sys

PROGRAM = "build/softlux-mpi"
REPLAY = "build/ranks-replay"
RANKS = [2, 4, 8, 16, 32, 64]
NETWORKS = {"data centre": (2e-6, 10e9), "office": (100e-6, 110e6)}  # seconds, bytes a second
COPY = 2e9  # bytes a second that a rank puts side by side and back, into new memory
HEAD = 424  # bytes a rank: items, bytes, counters
ONE_BY_ONE = 50000  # bytes beyond which MPI passes pieces on from neighbour to neighbour
SCENES = {"atrium": "scenes/generated/atrium.json", "figure": "scenes/generated/figure.json",
          "Sponza": "bench/scenes/sponza.json"}
NEEDS = {"Sponza": "../shared/scenes/sponza-dabrovic/sponza-dabrovic.obj"}
METHODS = {"splatting high": ["-m", "splatting", "-q", "high"], "path": ["-m", "path"],
           "multi-mesh": ["-m", "multi-mesh", "--batches", "100"],
           "shading-cache": ["-m", "shading-cache"], "direct radiance": ["-m", "direct-radiance"]}


def arguments(scene, method):
    return ["render", SCENES[scene], "--allow-outside", *METHODS[method], "-s", "128x128", "-t", "1",
            "--quiet", "-o", "build/ranks/picture.exr"]


def new_log(scene, method, name):
    os.makedirs("build/ranks", exist_ok=True)
    subprocess.run([PROGRAM, *arguments(scene, method)], check=True,
                   env={**os.environ, "SOFTLUX_BATCHES": name.removesuffix(".0")})
    return name


def log_of(scene, method):
    name = f"build/ranks/{scene}-{method.replace(' ', '-')}.0"
    return name if os.path.exists(name) else new_log(scene, method, name)


def read(name):
    """Serial seconds before a batch, bytes of all its items, seconds of 1, 2, 4 .. 64 ranks' items."""
    with open(name) as file:
        lines = [line.split() for line in file]
    return [(float(f[0]), int(f[1]) * int(f[2]), [float(x) for x in f[3:]]) for f in lines]


def exchange(size, ranks, latency, bandwidth):
    rounds = math.ceil(math.log2(ranks))
    heads = rounds * latency + (ranks - 1) * HEAD / bandwidth
    if not size:
        return heads
    steps = rounds if size < ONE_BY_ONE else ranks / 2
    return heads + steps * latency + size * (ranks - 1) / ranks / bandwidth + 2 * size / COPY


def predict(batches, ranks, network):
    """Seconds from the first batch on; what is serial of them, what waits for the slowest rank, what is the
    network's."""
    serial = sum(b[0] for b in batches[1:])
    work = sum(b[2][0] for b in batches) / ranks
    most = sum(b[2][int(math.log2(ranks))] for b in batches)
    net = sum(exchange(b[1], ranks, *network) for b in batches[:-1]) if ranks > 1 else 0.0
    return serial + most + net, serial, most - work, net


def row(title, batches):
    one = predict(batches, 1, (0, 1))[0]
    centre = {n: predict(batches, n, NETWORKS["data centre"]) for n in RANKS}
    office = one / predict(batches, 16, NETWORKS["office"])[0]
    total, *lost = centre[16]
    cells = [f"{batches[0][0]:.1f}", f"{one:.1f}"] + [f"{one / centre[n][0]:.1f}" for n in RANKS]
    cells += [f"{office:.1f}"] + [f"{100 * x / total:.0f} %" for x in [one / 16, *lost]]
    print("| " + " | ".join([title, *cells]) + " |", flush=True)


def two_ranks(scene, method):
    """Seconds until the slower one has done each batch."""
    subprocess.run(["mpirun", "-n", "2", PROGRAM, *arguments(scene, method)], check=True,
                   env={**os.environ, "SOFTLUX_BATCHES": "build/ranks/two"})
    ranks = [read(f"build/ranks/two.{r}") for r in range(2)]
    return sum(max(a[0] + a[2][0], b[0] + b[2][0]) for a, b in list(zip(*ranks, strict=True))[1:])


def check(scene, method):
    """The best of three of each, since other work disturbs them; an exchange of two costs nothing here."""
    logs = [read(new_log(scene, method, "build/ranks/one.0")) for _ in range(3)]
    one = min(predict(batches, 1, (0, 1))[0] for batches in logs)
    said = max(predict(b, 1, (0, 1))[0] / predict(b, 2, (0, math.inf))[0] for b in logs)
    two = min(two_ranks(scene, method) for _ in range(3))
    print(f"| {scene}, {method} | {said:.2f} | {one / two:.2f} |", flush=True)


def network(scene, method):
    """Only exchanges, of all batches, without their work; the best of three."""
    batches = read(log_of(scene, method))
    runs = [[float(x) for x in subprocess.run(["mpirun", "-n", "2", REPLAY, log_of(scene, method)],
                                              check=True, capture_output=True, text=True).stdout.split()]
            for _ in range(3)]
    latency, bandwidth, took = min(runs, key=lambda run: run[2])
    said = sum(exchange(b[1], 2, latency, bandwidth) for b in batches)
    megabytes = sum(b[1] for b in batches) / 1e6
    cells = [f"{scene}, {method}", f"{len(batches)}", f"{megabytes:.1f}", f"{1e6 * latency:.0f}",
             f"{bandwidth / 1e6:.0f}", f"{1e3 * said:.0f}", f"{1e3 * took:.0f}"]
    print("| " + " | ".join(cells) + " |", flush=True)


def main(names):
    cases = [(s, m) for s in SCENES for m in METHODS if os.path.exists(NEEDS.get(s, SCENES[s]))]
    if names in (["--check"], ["--network"]):
        for case in cases:
            {"--check": check, "--network": network}[names[0]](*case)
        return
    for name in names:
        row(name, read(name))
    for case in cases if not names else []:
        row(", ".join(case), read(log_of(*case)))


main(sys.argv[1:])
