#!/usr/bin/env python3
"""Maps of squares entered after 500 and 2,000 epochs (figures 5.8 and 5.10) and the accuracy of the
transition models over time (section 4.3.4), under the defaults.

    VENV/bin/python docs/calibration/over_time.py --evswarm target/release/evswarm --out DIR

VENV has docs/calibration/search/requirements.txt. A run of fewer epochs is the beginning of a longer
one to the last bit, so a run of each length shows what a run had come to. DIR gets over-time.csv,
where runs that it has are not run again, over-time.md and maps-ARENA.png.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import matplotlib
import numpy

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of what draws)

ARENAS = ("easy", "graph", "maze")
METHODS = ("curiosity", "discovery", "im", "ev-iter-c", "ev-iter-d")
EPOCHS = (100, 250, 500, 1000, 2000)
SHOWN = (500, 2000)
SEEDS = range(1, 6)
FIELDS = ["arena", "method", "epochs", "seed", "p1", "p10", "pairs", "divergence_nats"]


def run(evswarm, out, arena, method, epochs, seed):
    spec = {"arena": arena, "controller": {"method": method}, "epochs": epochs, "seed": seed}
    with tempfile.TemporaryDirectory(prefix="over-time-") as scratch:
        scratch = pathlib.Path(scratch)
        (scratch / "spec.json").write_text(json.dumps(spec))
        subprocess.run([evswarm, "run", scratch / "spec.json", "--out", scratch / "out"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        result = json.loads((scratch / "out" / "result.json").read_text())
        if seed == SEEDS[0] and epochs in SHOWN:
            visits = numpy.load(scratch / "out" / "visits.npy")
            numpy.save(out / f"{arena}-{method}-{epochs}.npy", visits)
    model = result["model"] or {"pairs": "", "divergence_nats": ""}
    return [arena, method, epochs, seed, result["p1"], result["p10"], model["pairs"],
            model["divergence_nats"]]


def draw(out, arena):
    levels = (0, 1, 2, 5, 10, 10_000_000)
    colours = matplotlib.colors.ListedColormap(["#ffffff", "#c7e9c0", "#74c476", "#238b45", "#00441b"])
    norm = matplotlib.colors.BoundaryNorm(levels, colours.N)
    figure, axes = pyplot.subplots(len(SHOWN), len(METHODS), figsize=(2 * len(METHODS), 2.2 * len(SHOWN)))
    for row, epochs in zip(axes, SHOWN):
        for axis, method in zip(row, METHODS):
            visits = numpy.load(out / f"{arena}-{method}-{epochs}.npy")
            axis.imshow(visits.reshape(100, 100), origin="lower", cmap=colours, norm=norm)
            axis.set_title(f"{method}, {epochs}", fontsize=9)
            axis.set_xticks([])
            axis.set_yticks([])
    figure.tight_layout()
    figure.savefig(out / f"maps-{arena}.png", dpi=110)
    pyplot.close(figure)


def table(rows):
    lines = ["| arena | method | " + " | ".join(f"{epochs} epochs" for epochs in EPOCHS) + " |",
             "|---|---|" + "---|" * len(EPOCHS)]
    for arena in ARENAS:
        for method in METHODS:
            cells = []
            for epochs in EPOCHS:
                found = [float(row["divergence_nats"]) / int(row["pairs"]) for row in rows
                         if (row["arena"], row["method"], row["epochs"]) == (arena, method, str(epochs))
                         and row["pairs"] not in ("", "0")]
                if found:
                    cells.append(f"{statistics.mean(found):.3f} ± {statistics.stdev(found):.3f}")
            if cells:
                lines.append(f"| {arena} | `{method}` | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evswarm", default="target/release/evswarm")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "over-time.csv"
    if not path.exists():
        path.write_text(",".join(FIELDS) + "\n")
    with path.open(newline="") as file:
        known = {tuple(row[name] for name in FIELDS[:4]) for row in csv.DictReader(file)}
    wanted = [(arena, method, epochs, seed) for arena in ARENAS for seed in SEEDS
              for method in METHODS for epochs in EPOCHS]
    missing = [key for key in wanted if tuple(map(str, key)) not in known]
    with ThreadPoolExecutor(arguments.threads) as pool:
        for row in pool.map(lambda key: run(arguments.evswarm, arguments.out, *key), missing):
            with path.open("a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    (arguments.out / "over-time.md").write_text(table(rows))
    for arena in ARENAS:
        draw(arguments.out, arena)


if __name__ == "__main__":
    main()
