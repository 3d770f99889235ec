#!/usr/bin/env python3
"""Runs the candidates of candidates.json as jobs of a server of its own and prints their table.

    python3 docs/calibration/calibrate.py --evswarm target/release/evswarm --data DIR [--threads 1]

Needs Python 3.9 and nothing else. Runs that DIR has already are not run again. results.csv gets a
row a run; the table is made from it alone, so that `--table` prints it without running anything.
"""

import argparse
import copy
import csv
import json
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import time
import urllib.error
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
LEVELS = ("p1", "p2", "p5", "p10")


def merged(base, more):
    out = copy.deepcopy(base)
    for key, value in more.items():
        out[key] = merged(out[key], value) if isinstance(out.get(key), dict) and isinstance(value, dict) else value
    return out


def put(spec, path, value):
    *parents, last = path.split(".")
    for name in parents:
        spec = spec.setdefault(name, {})
    spec[last] = value


def jobs(plan, only):
    """(candidate, job) for every candidate: one job a method, over the arenas and the seeds."""
    for candidate in plan["candidates"]:
        if only and candidate["name"] not in only:
            continue
        for method in candidate["methods"]:
            base = merged(plan["base"], plan["methods"][method])
            base["epochs"] = plan["epochs"]
            for path, value in candidate["changes"].items():
                put(base, path, value)
            matrix = {"arena": candidate.get("arenas", plan["arenas"])}
            yield candidate["name"], {
                "name": f"{candidate['name']}: {method}",
                "base": base,
                "matrix": matrix,
                "seeds": candidate.get("seeds", plan["seeds"]),
            }


class Server:
    def __init__(self, evswarm, data, threads, port):
        self.url = f"http://127.0.0.1:{port}"
        command = [evswarm, "serve", "--data", data, "--listen", f"127.0.0.1:{port}", "--threads", str(threads)]
        log = open(os.path.join(data, "server.log"), "ab")
        self.process = subprocess.Popen(command, stdout=log, stderr=log)
        for _ in range(200):
            try:
                self.ask("/v1/jobs")
                return
            except OSError:
                if self.process.poll() is not None:
                    sys.exit("the server does not start; see server.log")
                time.sleep(0.1)
        sys.exit("the server does not answer")

    def ask(self, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {"content-type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            sys.exit(f"{path}: {error.code} {error.read().decode()}")

    def runs(self, job):
        cursor = ""
        while True:
            page = self.ask(f"/v1/jobs/{job}/runs?limit=200{cursor}")
            yield from page["items"]
            if not page["next"]:
                return
            cursor = f"&cursor={page['next']}"

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()


def rows_of(candidate, runs):
    for run in runs:
        if run["state"] != "done":
            sys.exit(f"{candidate}: run {run['id']} is {run['state']}: {run['error']}")
        result = run["result"]
        yield {
            "candidate": candidate,
            "arena": run["arena"],
            "method": run["method"],
            "seed": run["seed"],
            **{level: result[level] for level in LEVELS},
            "reachable": result["reachable"],
            "states": result["clusters"]["sensor"],
            "actions": result["clusters"]["actuator"],
        }


def table(rows):
    """Mean (standard deviation) over the seeds, one line a candidate and arena."""
    groups = {}
    for row in rows:
        key = (row["candidate"], row["arena"])
        groups.setdefault(key, {}).setdefault(row["method"], []).append(row)
    methods = ["im", "ev-iter-c", "curiosity"]
    print("| setting | arena | " + " | ".join(f"{m} p1 | p10" for m in methods) + " | ev-iter-c states, actions |")
    print("|---|---|" + "---|" * (2 * len(methods) + 1))
    for (candidate, arena), of_method in groups.items():
        cells = []
        for method in methods:
            for level in ("p1", "p10"):
                values = [int(row[level]) for row in of_method.get(method, [])]
                sd = statistics.stdev(values) if len(values) > 1 else 0.0
                cells.append(f"{statistics.mean(values):.0f} ± {sd:.0f}" if values else "")
        shown = of_method.get("ev-iter-c", [])
        mean = lambda name: statistics.mean(float(row[name]) for row in shown)
        cells.append(f"{mean('states'):.0f}, {mean('actions'):.0f}" if shown else "")
        print(f"| {candidate} | {arena} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evswarm", default="target/release/evswarm")
    parser.add_argument("--data", help="directory of the server's database and of the runs")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--port", type=int, default=8099)
    parser.add_argument("--candidates", default=str(HERE / "candidates.json"))
    parser.add_argument("--results", default=str(HERE / "results.csv"))
    parser.add_argument("--only", action="append", help="name of a candidate; may be repeated")
    parser.add_argument("--table", action="store_true", help="print the table of results.csv and stop")
    arguments = parser.parse_args()
    results = pathlib.Path(arguments.results)
    if not arguments.table:
        if not arguments.data:
            parser.error("--data is needed")
        os.makedirs(arguments.data, exist_ok=True)
        plan = json.loads(pathlib.Path(arguments.candidates).read_text())
        server = Server(arguments.evswarm, arguments.data, arguments.threads, arguments.port)
        try:
            kept = []
            if arguments.only and results.exists():
                with results.open(newline="") as file:
                    kept = [row for row in csv.DictReader(file) if row["candidate"] not in arguments.only]
            found = []
            for name, spec in jobs(plan, arguments.only):
                job = server.ask("/v1/jobs", spec)["id"]
                while server.ask(f"/v1/jobs/{job}")["state"] in ("queued", "running"):
                    time.sleep(1.0)
                found.extend(rows_of(name, server.runs(job)))
                with results.open("w", newline="") as file:
                    writer = csv.DictWriter(file, fieldnames=list(found[0]), lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(kept + found)
        finally:
            server.stop()
    with results.open(newline="") as file:
        table(list(csv.DictReader(file)))


if __name__ == "__main__":
    main()
