#!/usr/bin/env python3
"""Searches all open settings at once for those under which chapter 5 comes out as printed.

    python3 -m venv VENV && VENV/bin/pip install -r docs/calibration/search/requirements.txt
    VENV/bin/python docs/calibration/search/search.py --evswarm target/release/evswarm --out DIR

DIR gets points.csv and runs.csv, a row as soon as it is known. Killed and started again it goes on,
and finds the same: a point depends on the losses of complete batches alone, in their order.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import optuna
from scipy.stats import qmc

import loss as losses
import space as spaces

HERE = pathlib.Path(__file__).resolve().parent
POINT_FIELDS = ["point", "study", "origin", "settings"]
RUN_FIELDS = ["point", "arena", "method", "seed", *losses.LEVELS, *losses.STEP_LEVELS, "reachable",
              "states", "actions", "mean_coverage", "cpu_s", "wall_s"]


class Table:
    """Rows of a CSV file that grows."""

    def __init__(self, path, fields):
        self.path, self.fields, self.rows, self.lock = path, fields, [], threading.Lock()
        if path.exists():
            with path.open(newline="") as file:
                # A row that a kill cut short is run again.
                self.rows = [row for row in csv.DictReader(file) if None not in row.values()]
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, fields, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)

    def add(self, row):
        row = {name: str(row[name]) for name in self.fields}
        with self.lock, self.path.open("a", newline="") as file:
            csv.DictWriter(file, self.fields, lineterminator="\n").writerow(row)
            self.rows.append(row)


class Runner:
    """Runs specs, each by a process of its own, and keeps what they found."""

    def __init__(self, evswarm, table, threads):
        self.evswarm, self.table = evswarm, table
        self.pool = ThreadPoolExecutor(threads)
        self.known = {self.key(row): row for row in table.rows}

    @staticmethod
    def key(row):
        return (row["point"], row["arena"], row["method"], str(row["seed"]))

    def run(self, key, spec):
        begun = time.monotonic()
        scratch = pathlib.Path(tempfile.mkdtemp(prefix="search-"))
        try:
            (scratch / "spec.json").write_text(json.dumps(spec))
            command = [self.evswarm, "run", scratch / "spec.json", "--out", scratch / "out"]
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            said = process.stderr.read()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode != 0:
                raise RuntimeError(f"{key}: {said.decode()}")
            result = json.loads((scratch / "out" / "result.json").read_text())
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
        row = dict(zip(("point", "arena", "method", "seed"), key))
        row |= {level: result[level] for level in losses.LEVELS}
        row |= {f"d{level[1:]}": result["dwell"][level] for level in losses.LEVELS}
        row |= {
            "reachable": result["reachable"],
            "states": result["clusters"]["sensor"], "actions": result["clusters"]["actuator"],
            "mean_coverage": round(result["metrics"]["mean_coverage"], 4),
            "cpu_s": round(usage.ru_utime + usage.ru_stime, 3),
            "wall_s": round(time.monotonic() - begun, 3),
        }
        self.table.add(row)

    def all(self, wanted):
        """Runs what is wanted, {key: spec}, and is not known yet."""
        missing = [(key, spec) for key, spec in wanted.items() if key not in self.known]
        for future in [self.pool.submit(self.run, key, spec) for key, spec in missing]:
            future.result()
        self.known = {self.key(row): row for row in self.table.rows}


class Search:
    def __init__(self, plan, runner, points):
        self.plan, self.runner, self.points = plan, runner, points

    def of(self, study):
        return [row for row in self.points.rows if row["study"] == study]

    def wanted(self, points, rungs):
        """The runs of points in some rungs."""
        wanted = {}
        for rung in self.plan["rungs"][rungs]:
            for block in rung["runs"]:
                for row in points:
                    for arena in block["arenas"]:
                        for method in block["methods"]:
                            for seed in block["seeds"]:
                                settings = json.loads(row["settings"])
                                where = self.plan["arenas"][arena]
                                epochs = self.plan["epochs"]
                                spec = spaces.spec(settings, method, where, seed, epochs)
                                wanted[(row["point"], arena, method, str(seed))] = spec
        return wanted

    def loss(self, row, rung):
        """The loss of a point by the runs of the rungs up to this one."""
        wanted = self.wanted([row], slice(0, rung + 1))
        return losses.loss([self.runner.known[key] for key in wanted])

    def add(self, study, origin, settings):
        number = len(self.of(study))
        self.points.add({"point": f"{study}-{number:03}", "study": study, "origin": origin,
                         "settings": json.dumps(settings)})

    def design(self, study):
        """Points seeded and by Sobol."""
        design, space = self.plan["design"], spaces.SPACES[study]
        cube = qmc.Sobol(len(space), scramble=True, rng=design["seed"]).random(design["sobol"])
        points = [("seeded", settings) for settings in spaces.SEEDED[study]]
        points += [("sobol", spaces.point(space, row)) for row in cube]
        for origin, settings in points[len(self.of(study)):]:
            self.add(study, origin, settings)

    def batch(self, study, number):
        """Points by TPE over the losses of the first rung so far."""
        design, space = self.plan["design"], spaces.SPACES[study]
        before = len(spaces.SEEDED[study]) + design["sobol"] + number * design["batch"]
        rows = self.of(study)
        told = optuna.create_study(sampler=optuna.samplers.TPESampler(
            seed=design["seed"] + number, multivariate=True, constant_liar=True, n_startup_trials=1))
        distributions = {}
        for name, dimension in space.items():
            choices = spaces.choices(dimension)
            distributions[name] = (
                optuna.distributions.CategoricalDistribution(choices) if choices else
                optuna.distributions.FloatDistribution(
                    dimension[0], dimension[1], log=dimension[2] == "log"))
        for row in rows[:before]:
            settings = json.loads(row["settings"])
            outside = any(
                settings[name] not in choices if (choices := spaces.choices(dimension))
                else not dimension[0] <= settings[name] <= dimension[1]
                for name, dimension in space.items())
            if not outside:
                told.add_trial(optuna.trial.create_trial(
                    params={name: settings[name] for name in space},
                    distributions=distributions, value=self.loss(row, 0)))
        for place in range(design["batch"]):
            trial = told.ask(distributions)
            settings = {name: round(value, 3) if isinstance(space[name], tuple) else value
                        for name, value in trial.params.items()}
            if before + place >= len(rows):
                self.add(study, f"tpe {number}", settings)

    def ranked(self, study, rung, rows):
        return sorted(rows, key=lambda row: (self.loss(row, rung), row["point"]))

    def go(self, study):
        """A study from its design to its last rung."""
        first = slice(0, 1)
        self.design(study)
        self.runner.all(self.wanted(self.of(study), first))
        for number in range(self.plan["design"]["batches"]):
            self.batch(study, number)
            self.runner.all(self.wanted(self.of(study), first))
        rows = self.of(study)
        self.say(study, 0, rows)
        for rung, told in enumerate(self.plan["rungs"][1:], start=1):
            rows = self.ranked(study, rung - 1, rows)[:told["keep"]]
            self.runner.all(self.wanted(rows, slice(rung, rung + 1)))
            self.say(study, rung, rows)

    def say(self, study, rung, rows):
        best = self.ranked(study, rung, rows)[:5]
        runs = self.runner.table.rows
        cpu = sum(float(row["cpu_s"]) for row in runs)
        print(f"{time.strftime('%H:%M:%S')} {study}, rung {rung}, {len(rows)} points; in all "
              f"{len(runs)} runs, {cpu:.0f} s of CPU", flush=True)
        for row in best:
            print(f"  {self.loss(row, rung):6.2f} {row['point']} {row['settings']}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evswarm", default="target/release/evswarm")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--plan", type=pathlib.Path, default=HERE / "plan.json")
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    arguments.out.mkdir(parents=True, exist_ok=True)
    runner = Runner(arguments.evswarm, Table(arguments.out / "runs.csv", RUN_FIELDS), arguments.threads)
    points = Table(arguments.out / "points.csv", POINT_FIELDS)
    search = Search(json.loads(arguments.plan.read_text()), runner, points)
    for study in spaces.SPACES:
        search.go(study)


if __name__ == "__main__":
    main()
