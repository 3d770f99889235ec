#!/usr/bin/env python3
"""Which settings decide, alone and in pairs: Sobol indices of a forest over the search's first rung.

    VENV/bin/python docs/calibration/search/sensitivity.py --data DIR --out DIR

A random forest (scikit-learn) learns from all points of a space what the runs gave; SALib finds the
forest's first-order, total and second-order indices. Its fit on points that a tree has not seen
(out of bag) is told beside them: indices of a forest that explains little say little.
"""

import argparse
import csv
import json
import pathlib

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sampling
from sklearn.ensemble import RandomForestRegressor

import loss as losses
import space as spaces

SEED = 1
TARGETS = {
    "loss": "distance to the published means; fewer than 8 states refused",
    "p1": "squares entered at least once",
    "p10": "squares entered at least ten times",
    "states": "states, logarithm to base 2",
}
# Whether phase 3 goes on where the last epoch ended decides so much that the rest is looked at
# without it too.
PARTS = {"all points": None, "points that start anew": "reset"}


def read(folder):
    with (folder / "points.csv").open(newline="") as file:
        points = list(csv.DictReader(file))
    with (folder / "runs.csv").open(newline="") as file:
        return points, losses.by(csv.DictReader(file), lambda row: row["point"])


def coordinates(space, settings):
    """A point in the unit cube: choices at the middles of equal parts."""
    found = []
    for name, dimension in space.items():
        choices = spaces.choices(dimension)
        if choices:
            found.append((choices.index(settings[name]) + 0.5) / len(choices))
        else:
            low, high, scale = dimension
            at = (lambda x: np.log(x)) if scale == "log" else (lambda x: x)
            found.append((at(settings[name]) - at(low)) / (at(high) - at(low)))
    return found


def told(rows):
    """What the run of ev-iter-c on easy of a point says, by target; None where there is none."""
    for row in rows:
        if (row["arena"], row["method"], row["seed"]) == ("easy", "ev-iter-c", "6001"):
            return {
                "loss": losses.loss([row]), "p1": float(row["p1"]), "p10": float(row["p10"]),
                "states": float(np.log2(float(row["states"]))),
            }
    return None


def snapped(space, cube):
    """Coordinates with choices at the middles of their parts, as the forest knows them."""
    cube = cube.copy()
    for column, dimension in enumerate(space.values()):
        choices = spaces.choices(dimension)
        if choices:
            n = len(choices)
            cube[:, column] = (np.minimum(np.floor(cube[:, column] * n), n - 1) + 0.5) / n
    return cube


def indices(space, x, y):
    forest = RandomForestRegressor(500, oob_score=True, min_samples_leaf=3, max_features=0.5,
                                   random_state=SEED, n_jobs=2).fit(x, y)
    problem = {"num_vars": len(space), "names": list(space), "bounds": [[0.0, 1.0]] * len(space)}
    cube = sampling.sample(problem, 512, calc_second_order=True, seed=SEED)
    found = analysis.analyze(problem, forest.predict(snapped(space, cube)), calc_second_order=True,
                             seed=SEED)
    return forest.oob_score_, found


def line(target, fit, found, names):
    """A row of the table."""
    top = lambda values, n: ", ".join(
        f"{names[i]} {values[i]:.2f}" for i in np.argsort(-values)[:n] if values[i] >= 0.01)
    pairs = sorted(((found["S2"][i, j], names[i], names[j])
                    for i in range(len(names)) for j in range(i + 1, len(names))), reverse=True)[:4]
    pairs = ", ".join(f"{a} x {b} {v:.2f}" for v, a, b in pairs if v >= 0.01)
    return f"| {target} | {fit:.2f} | {top(found['S1'], 5)} | {top(found['ST'], 6)} | {pairs} |"


def draw(bars, heat, title, fit, found, names):
    """Effects alone and in all as bars, pairs as a map."""
    order = np.argsort(found["ST"])
    bars.barh(np.arange(len(names)), found["ST"][order], color="#c6d5e6", label="with all others")
    bars.barh(np.arange(len(names)), found["S1"][order], color="#2f5f95", label="alone", height=0.45)
    bars.set_yticks(np.arange(len(names)), [names[i] for i in order])
    bars.set_title(f"{title}: p1 of ev-iter-c, fit {fit:.2f}")
    bars.legend(loc="lower right")
    most = order[::-1][:8]
    pair = np.nan_to_num(found["S2"]) + np.nan_to_num(found["S2"]).T
    shown = heat.imshow(np.maximum(pair[np.ix_(most, most)], 0.0), cmap="Blues", vmin=0.0)
    heat.set_xticks(range(len(most)), [names[i] for i in most], rotation=60, ha="right")
    heat.set_yticks(range(len(most)), [names[i] for i in most])
    heat.set_title(f"{title}: pairs")
    heat.figure.colorbar(shown, ax=heat, shrink=0.5)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    points, runs = read(arguments.data)
    lines = []
    figure, axes = plt.subplots(1, 2 * len(spaces.SPACES), figsize=(20, 8))
    for place, (study, whole) in enumerate(spaces.SPACES.items()):
        for part, episodes in PARTS.items():
            space = {name: d for name, d in whole.items() if episodes is None or name != "episodes"}
            seen = []
            for row in points:
                settings = json.loads(row["settings"])
                if row["study"] != study or episodes not in (None, settings["episodes"]):
                    continue
                inside = all(
                    settings[n] in c if (c := spaces.choices(d)) else d[0] <= settings[n] <= d[1]
                    for n, d in space.items())
                found = told(runs.get(row["point"], []))
                if inside and found:
                    seen.append((coordinates(space, settings), found))
            x, names = np.array([c for c, _ in seen]), list(space)
            lines.append(f"## Space `{study}`, {part}: {len(seen)}\n")
            lines.append("| of | fit | alone (first order) | with all others (total) | strongest pairs |")
            lines.append("|---|---|---|---|---|")
            for target in TARGETS:
                fit, found = indices(space, x, np.array([t[target] for _, t in seen]))
                lines.append(line(target, fit, found, names))
                if target == "p1" and episodes:
                    draw(axes[2 * place], axes[2 * place + 1], f"{study}, starting anew", fit, found, names)
            lines.append("")
    figure.tight_layout()
    matplotlib.rcParams["svg.hashsalt"] = "evswarm"
    figure.savefig(arguments.out / "sensitivity.svg", metadata={"Date": None})
    (arguments.out / "sensitivity.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
