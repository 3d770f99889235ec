#!/usr/bin/env python3
"""Runs chosen settings again with seeds and arenas that no search has seen.

    VENV/bin/python docs/calibration/search/validate.py --evswarm target/release/evswarm --out DIR

DIR gets validation.csv; --table prints it. candidates.json names the settings: today's defaults, and
points of the search with what of them was kept.
"""

import argparse
import json
import pathlib
import statistics

import loss as losses
import space as spaces
from search import RUN_FIELDS, Runner, Table

HERE = pathlib.Path(__file__).resolve().parent


def settings_of(candidates, name):
    """A candidate's settings; it may be another one (`like`) with changes."""
    told = dict(candidates[name])
    return (settings_of(candidates, told.pop("like")) | told) if "like" in told else told


def wanted(plan):
    runs = {}
    for block in plan["runs"]:
        for name in block["candidates"]:
            settings = settings_of(plan["candidates"], name)
            for arena in block["arenas"]:
                for method in block["methods"]:
                    for seed in range(block["first"], block["first"] + block["count"]):
                        where = plan["arenas"][arena]
                        spec = spaces.spec(settings, method, where, seed, plan["epochs"])
                        runs[(name, arena, method, str(seed))] = spec
    return runs


def table(rows):
    """Mean ± standard deviation by candidate and arena."""
    methods = list(dict.fromkeys(row["method"] for row in rows))
    print("| settings | arena | " + " | ".join(f"{m} p1 | p10" for m in methods) + " | states |")
    print("|---|---|" + "---|" * (2 * len(methods) + 1))
    for (name, arena), group in losses.by(rows, lambda row: (row["point"], row["arena"])).items():
        cells = []
        by_method = losses.by(group, lambda row: row["method"])
        for method in methods:
            for level in ("p1", "p10"):
                values = [int(row[level]) for row in by_method.get(method, [])]
                sd = statistics.stdev(values) if len(values) > 1 else 0.0
                cells.append(f"{statistics.mean(values):.0f} ± {sd:.0f} ({len(values)})" if values else "")
        states = sorted(int(row["states"]) for row in group if int(row["states"]) > 0)
        cells.append(f"{states[0]} to {states[-1]}" if states else "")
        print(f"| {name} | {arena} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evswarm", default="target/release/evswarm")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--plan", type=pathlib.Path, default=HERE / "candidates.json")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    found = Table(arguments.out / "validation.csv", RUN_FIELDS)
    if not arguments.table:
        plan = json.loads(arguments.plan.read_text())
        Runner(arguments.evswarm, found, arguments.threads).all(wanted(plan))
    table(found.rows)


if __name__ == "__main__":
    main()
