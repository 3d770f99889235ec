"""Measures other simulators and evswarm in turns: CPU time of whole processes, less their set-up.

A round takes each pair of simulator and number of robots once: theirs, then ours. Set-up goes by taking a
tenth of the steps away from all of them. Called by run.sh, which builds what this runs.
"""

import argparse
import dataclasses
import os
import resource
import statistics
import subprocess
import sys
import time

SHORT = 10  # the short run does a tenth of the steps


@dataclasses.dataclass
class Peer:
    name: str
    driver: str
    arguments: list[str]
    robots: list[int]
    robot_steps: int  # of a long run; about two seconds of the slowest
    check_robot_steps: int


PEERS = [
    Peer("roborobo4, pixels of 15 mm", "roborobo4", [], [1, 10, 100, 1000, 10000], 2_000_000, 200_000),
    Peer("roborobo4, pixels of 5 mm", "roborobo4", ["pixel_mm=5"], [1, 10, 100, 1000, 10000], 400_000, 200_000),
    Peer("libfastsim, pixels of 3 mm", "libfastsim", [], [1], 1_000_000, 200_000),
    Peer("libfastsim, pixels of 1.5 mm", "libfastsim", ["pixel_mm=1.5"], [1], 400_000, 200_000),
    Peer("Enki", "enki", [], [1, 10, 100, 1000], 100_000, 200_000),
    Peer("ARGoS, 2 iterations", "argos", [], [1, 10, 100, 1000, 10000], 200_000, 100_000),
    Peer("ARGoS, 10 iterations", "argos", ["iterations=10"], [1, 10, 100, 1000, 10000], 100_000, 100_000),
]
OUR_ROBOT_STEPS = 2_000_000
LEAST_CHECKED = 200  # steps; by then robots have met


def run(command: list[str]) -> tuple[float, str]:
    """Seconds of CPU time, user and system, and what the process printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, done.stdout


def per_robot_step(command, robots: int, robot_steps: int) -> float:
    """Nanoseconds a robot-step: a long run less a short one."""
    many = robot_steps // robots
    few = many // SHORT
    long_s, short_s = run(command(many))[0], run(command(few))[0]
    return (long_s - short_s) / ((many - few) * robots) * 1e9


def load() -> str:
    return f"{os.getloadavg()[0]:.2f}"


def first_line(command: list[str]) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0]
    except (OSError, subprocess.CalledProcessError, IndexError):
        return "unknown"


def processor() -> str:
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        pairs = (line.split(":", 1) for line in file.read().split("\n\n")[0].splitlines() if ":" in line)
        fields = {key.strip(): value.strip() for key, value in pairs}
    named = (fields.get(key, "?") for key in ("model name", "cpu family", "model"))
    return "{}, family {}, model {}".format(*named)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for path in ("bin", "sources", "scratch", "worlds", "ours", "ours-check"):
        parser.add_argument(f"--{path}", required=True)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--only", default="", help="only simulators whose name contains this")
    parser.add_argument("--robots", default="", help="only these numbers of robots, as 1,10")
    parser.add_argument("--check", action="store_true", help="what robots do, and no times")
    options = parser.parse_args()

    chosen = [int(n) for n in options.robots.split(",") if n]
    peers = [peer for peer in PEERS if options.only.lower() in peer.name.lower()]
    pairs = [(peer, n) for peer in peers for n in peer.robots if not chosen or n in chosen]
    if not pairs:
        sys.exit("no simulator of this name, or not with so many robots")

    def world(robots: int) -> str:
        return f"{options.worlds}/world-{robots}.json"

    def theirs(peer: Peer, robots: int, *more: str):
        places = [f"source={options.sources}/{peer.driver}", f"scratch={options.scratch}"]
        return lambda steps: [
            f"{options.bin}/{peer.driver}", world(robots), str(steps), *peer.arguments, *places, *more,
        ]

    def ours(robots: int):
        return lambda steps: [options.ours, "--case", f"kinematic/peers/{robots}", "--steps", str(steps)]

    if options.check:
        check(peers, pairs, theirs, lambda robots, steps: [options.ours_check, world(robots), str(steps)])
        return

    begun, load_before = time.time(), load()
    figures = {(peer.name, n): [] for peer, n in pairs}
    for number in range(1, options.rounds + 1):
        for peer, n in pairs:
            print(f"\rround {number} of {options.rounds}: {peer.name}, {n} robots" + " " * 20, end="", file=sys.stderr)
            figures[peer.name, n].append((
                per_robot_step(theirs(peer, n), n, peer.robot_steps),
                per_robot_step(ours(n), n, OUR_ROBOT_STEPS),
            ))
    print("\r" + " " * 70 + "\r", end="", file=sys.stderr)

    print("| simulator | robots | theirs, ns | ours, ns | theirs / ours [least, most] |")
    print("|---|---|---|---|---|")
    for (name, n), values in figures.items():
        them, us = (statistics.median(column) for column in zip(*values))
        ratios = [theirs_ns / ours_ns for theirs_ns, ours_ns in values]
        print(f"| {name} | {n:,} | {them:,.0f} | {us:,.0f} "
              f"| {statistics.median(ratios):.1f} [{min(ratios):.1f}, {max(ratios):.1f}] |")
    flags = f"{os.environ.get('CXXFLAGS', '')}"
    print(f"\nCPU nanoseconds a robot-step, medians of {options.rounds} rounds, in turns; "
          f"load average {load_before} before, {load()} at the end, this program included "
          f"({time.time() - begun:.0f} s); {first_line([os.environ.get('CXX', 'g++'), '--version'])}, {flags}; "
          f"{first_line(['rustc', '--version'])}; {processor()}")


def check(peers, pairs, theirs, ours_check) -> None:
    """What robots do in each simulator, as a table."""
    print("| simulator | robots | steps | moved a step, mm | steps in contact | mean ray, mm | rays that see | never moved |")
    print("|---|---|---|---|---|---|---|---|")

    def row(name: str, robots: int, steps: int, command: list[str]) -> None:
        last = run(command)[1].strip().splitlines()[-1].split()
        values = dict(zip(last[::2], last[1::2]))
        print(f"| {name} | {robots:,} | {steps:,} | {float(values['moved_mm']):.2f} | {float(values['contact']):.0%} "
              f"| {float(values['ray_mm']):.0f} | {float(values['seen']):.0%} | {values['still']} |", flush=True)

    for robots in sorted({n for _, n in pairs}):
        steps = max(max(peer.check_robot_steps for peer in peers) // robots, LEAST_CHECKED)
        row("evswarm", robots, steps, ours_check(robots, steps))
        for peer, n in pairs:
            if n == robots:
                steps = max(peer.check_robot_steps // n, LEAST_CHECKED)
                row(peer.name, n, steps, theirs(peer, n, "--check")(steps))


if __name__ == "__main__":
    main()
