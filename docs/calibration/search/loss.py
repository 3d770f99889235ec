"""How far a point's runs are from the thesis."""

import statistics

# Tables 5.3 and 5.4, easy: mean and standard deviation at p1, p2, p5, p10. (The row of discovery-a
# repeats that of discovery there and is left out.)
PUBLISHED = {
    "discovery": ((3241, 643), (2848, 656), (2336, 592), (1968, 517)),
    "curiosity": ((3442, 667), (3084, 738), (2583, 786), (2212, 723)),
    "curiosity-a": ((3683, 294), (3273, 383), (2621, 466), (2186, 407)),
    "im": ((4156, 395), (3996, 599), (3651, 824), (3229, 868)),
    "ev-iter-d": ((4427, 39), (4382, 59), (4260, 104), (4027, 273)),
    "ev-iter-c": ((4384, 83), (4317, 143), (4152, 300), (3952, 464)),
    "ev-iter-da": ((4401, 56), (4332, 116), (4148, 86), (3938, 177)),
    "ev-iter-ca": ((4269, 160), (4204, 181), (4059, 299), (3862, 496)),
}
LEVELS = ("p1", "p2", "p5", "p10")
STEP_LEVELS = ("d1", "d2", "d5", "d10")
# What the thesis says of every arena.
ORDERS = (
    ("ev-iter-c", "im"), ("ev-iter-d", "im"), ("ev-iter-c", "curiosity"),
    ("im", "curiosity-a"), ("ev-iter-c", "brownian"),
)
# A wrong order everywhere costs as much as being two published standard deviations away.
ORDER_WEIGHT = 2.0
LEAST_STATES = 8
# What a point with too few states is taken for.
REFUSED = 40.0


def mean(rows, level):
    return statistics.fmean(float(row[level]) for row in rows)


def by(rows, key):
    groups = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


def least_states(rows):
    """Fewest states of a method that explores by them; None where there is none."""
    states = [int(row["states"]) for row in rows if int(row["states"]) > 0]
    return min(states, default=None)


def distance(rows, levels=LEVELS):
    """Mean distance to the published means on easy, in published standard deviations."""
    easy = by((row for row in rows if row["arena"] == "easy"), lambda row: row["method"])
    far = [
        abs(mean(group, level) - published) / sd
        for method, group in easy.items() if method in PUBLISHED
        for level, (published, sd) in zip(levels, PUBLISHED[method])
    ]
    return statistics.fmean(far) if far else None


def wrong_orders(rows):
    """Share of the thesis's orders of methods, at p1 and p10, that generated arenas turn round."""
    wrong = []
    generated = by((row for row in rows if row["arena"] != "easy"), lambda row: row["arena"])
    for group in generated.values():
        methods = by(group, lambda row: row["method"])
        for better, worse in ORDERS:
            if better in methods and worse in methods:
                for level in ("p1", "p10"):
                    wrong.append(mean(methods[better], level) <= mean(methods[worse], level))
    return statistics.fmean(wrong) if wrong else 0.0


def loss(rows):
    """The loss of a point's runs: distance on easy, and wrong orders elsewhere; bounded below in the
    number of states."""
    states = least_states(rows)
    if states is not None and states < LEAST_STATES:
        return REFUSED + LEAST_STATES - states
    return distance(rows) + ORDER_WEIGHT * wrong_orders(rows)
