"""Requests about what there is: without, nearly all would be about jobs and runs that are not."""

import json
import os
import random
import urllib.request

import schemathesis

URL = os.environ["EVSWARM_URL"]


def ids(path):
    with urllib.request.urlopen(f"{URL}{path}", timeout=10) as answer:
        return [item["id"] for item in json.load(answer)["items"]]


JOBS = ids("/v1/jobs")
RUNS = ids("/v1/runs")
ARENAS = ["easy", "maze", "nowhere"]
RECORDINGS = ["live", "0", "1"]
CODES = ["damaged", "internal", "nothing"]


@schemathesis.hook
def map_path_parameters(context, path_parameters):
    """Three times of four the id of something that there is, at least at first."""
    if not path_parameters or context.operation is None:
        return path_parameters
    path = context.operation.path
    # By what was generated, so that a seed gives the same requests.
    draw = random.Random(repr(sorted(path_parameters.items())))
    if draw.random() < 0.25:
        return path_parameters
    known = dict(path_parameters)
    if "id" in known:
        known["id"] = draw.choice(JOBS if path.startswith("/v1/jobs") else RUNS)
    if "name" in known:
        known["name"] = draw.choice(RECORDINGS if "/recordings/" in path else ARENAS)
    if "code" in known:
        known["code"] = draw.choice(CODES)
    return known
