"""What the search varies: every setting that the thesis leaves open, as dimensions of a unit cube.

`printed` keeps the values that the thesis prints (under one reading or another), `free` varies them.
"""

import math

# Readings of what an epsilon is and in which interval sensor values are clustered.
READINGS = {
    "signed": {"cluster_scale": "as-sensed"},
    "unsigned": {"sensor_scale": "unsigned", "cluster_scale": "as-sensed"},
    "unsigned clusters": {"cluster_scale": "unsigned"},
    "unsigned, diameter": {
        "sensor_scale": "unsigned", "cluster_scale": "as-sensed", "epsilon_is": "diameter"},
    "unsigned clusters, diameter": {"cluster_scale": "unsigned", "epsilon_is": "diameter"},
}

# name: choices, or (low, high, "linear" | "log").
OPEN = {
    "slope": (0.7, 6.0, "log"),
    "success_window": [10, 20, 40],
    "ties": ["first", "random", "keep"],
    "action_hold_steps": [1, 2, 3, 4],
    "insufficiency": ["every-action", "state-total"],
    "command_levels": [0, 3, 5],
    "actuator_sample": [64, 1],
    "replay_genomes": [1_000_000, 20],
    "states_from": ["babbling", "phase-1"],
    "babbling_epochs": [1, 5, 20],
    "train_epochs": [200, 500],
    "friction": [0.0, 0.1, 0.2, 0.3, 0.5, 1.0],
    "bounce": [0.0, 0.5],
    "acceleration": [10.0, 10.0, 20.0, 0.0],
    "slip": [0.0, 0.1],
    "response": ["thesis", "webots-2022"],
    "episodes": ["reset", "continue-exploring"],
    "heading": [0.0, math.pi / 4, math.pi / 2],
}

PRINTED = {"reading": list(READINGS)} | OPEN

FREE = {
    "reading": ["signed", "unsigned", "unsigned clusters"],
    "epsilon_sensor": (1.0, 2.6, "linear"),
    "epsilon_actuator": (0.2, 0.8, "linear"),
    "epsilon_sensori_motor": (0.9, 2.4, "linear"),
    "alpha": (0.0, 1.0, "linear"),
    "eta": (0.02, 0.2, "log"),
    "lambda": [30, 60, 120],
} | OPEN

SPACES = {"printed": PRINTED, "free": FREE}

# The row that a search before this one had found, and today's defaults: two points among the others.
BASE = {
    "reading": "signed", "epsilon_sensor": 2.0, "epsilon_actuator": 0.3, "epsilon_sensori_motor": 1.8,
    "alpha": 0.5, "eta": 0.05, "lambda": 60, "slope": 3.0, "success_window": 10, "ties": "keep",
    "action_hold_steps": 2, "insufficiency": "every-action", "command_levels": 0,
    "actuator_sample": 64, "replay_genomes": 1_000_000, "states_from": "babbling",
    "babbling_epochs": 5, "train_epochs": 200, "friction": 0.2, "bounce": 0.0, "acceleration": 10.0,
    "slip": 0.0, "response": "thesis", "episodes": "reset", "heading": math.pi / 4,
}
DEFAULTS = BASE | {
    "epsilon_sensor": 1.5, "epsilon_actuator": 0.6, "alpha": 0.7, "slope": 2.0, "ties": "first",
    "action_hold_steps": 1, "friction": 1.0,
}
# The base row as far as printed values allow: epsilon 1 in [0, 1] is 2 in [-1, 1].
PRINTED_BASE = {name: BASE[name] for name in OPEN} | {"reading": "unsigned clusters"}
SEEDED = {
    "printed": [PRINTED_BASE, PRINTED_BASE | {"friction": 0.0}, PRINTED_BASE | {"slope": 2.0}],
    "free": [BASE, BASE | {"friction": 0.0}, DEFAULTS],
}


def choices(dimension):
    """The choices of a dimension without repeats; None where it is an interval."""
    return list(dict.fromkeys(dimension)) if isinstance(dimension, list) else None


def point(space, cube):
    """The point of a space for coordinates in [0, 1)."""
    found = {}
    for (name, dimension), u in zip(space.items(), cube):
        if isinstance(dimension, list):
            found[name] = dimension[min(int(u * len(dimension)), len(dimension) - 1)]
        else:
            low, high, scale = dimension
            if scale == "log":
                value = math.exp(math.log(low) + u * (math.log(high) - math.log(low)))
            else:
                value = low + u * (high - low)
            found[name] = round(value, 3)
    return found


def spec(settings, method, arena, seed, epochs):
    """The run spec of a point for a method in an arena."""
    p = settings
    controller = {"method": method} | READINGS[p["reading"]]
    half = 0.5 if "unsigned" in p["reading"] else 1.0
    # Printed values stay as they are printed; free ones are told in the scale of [-1, 1].
    controller["epsilon_sensor"] = half * p["epsilon_sensor"] if "epsilon_sensor" in p else 1.0
    for name in ("epsilon_actuator", "epsilon_sensori_motor", "alpha", "eta", "lambda"):
        if name in p:
            controller[name] = p[name]
    for name in ("slope", "success_window", "ties", "action_hold_steps", "insufficiency",
                 "command_levels", "actuator_sample", "replay_genomes", "babbling_epochs"):
        controller[name] = p[name]
    if method == "im":
        controller["states_from"] = p["states_from"]
    if method != "brownian" and (method != "im" or p["states_from"] == "phase-1"):
        controller["train"] = {"arena": "easy", "epochs": p["train_epochs"]}
    return {
        "seed": seed, "arena": arena, "controller": controller, "epochs": epochs,
        "episodes": p["episodes"], "start": {"heading_rad": p["heading"]},
        "robot": {
            "preset": p["response"], "contact_friction": p["friction"], "contact_bounce": p["bounce"],
            "max_wheel_acceleration_rad_s2": p["acceleration"], "wheel_slip": p["slip"],
        },
    }
