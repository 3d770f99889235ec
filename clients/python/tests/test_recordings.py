"""Recordings as others read them: MCAP by its reference library, Parquet by pyarrow, both against
the slices and the CSV that the server gives."""

from __future__ import annotations

import io
import json
import math
from collections import defaultdict
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader

import evswarm

BOXES = {
    "name": "boxes",
    "width_m": 1.0,
    "height_m": 1.0,
    "walls_m": [[0.7, 0.0, 0.7, 0.4]],
    "starts": [
        {"x_m": 0.2, "y_m": 0.5, "heading_rad": 0.0},
        {"x_m": 0.2, "y_m": 0.3, "heading_rad": 0.0},
    ],
    "objects": [
        {
            "kind": "box",
            "x_m": 0.3,
            "y_m": 0.5,
            "heading_rad": 0.1,
            "width_m": 0.08,
            "height_m": 0.08,
            "mass_kg": 0.05,
            "friction": 0.3,
        }
    ],
}
SPECS = {
    "kinematic, trained elsewhere": {
        "arena": "maze",
        "robots": 3,
        "placement": "random",
        "controller": {"method": "im", "babbling_epochs": 2},
        "epochs": 4,
        "steps_per_epoch": 150,
        "record": {"every_steps": 1, "robots": [0, 2]},
    },
    "rapier with an object": {
        "arena": BOXES,
        "engine": "rapier",
        "robots": 2,
        "controller": {"method": "brownian"},
        "epochs": 3,
        "steps_per_epoch": 150,
        "record": {"every_steps": 5},
    },
}


class Recorded:
    """A run's recording in every form."""

    def __init__(self, client: evswarm.Client, spec: dict[str, Any]):
        job = client.submit({"base": spec, "seeds": [1]}).wait(timeout_s=60)
        (run,) = job.runs()
        self.slice = run.recording_slice()
        assert self.slice["next_step"] is None
        assert self.slice["recording"]["state"] == "done"
        self.mcap = run.recording(form="mcap")
        self.parquet = run.recording(form="parquet")
        self.csv = run.recording(form="csv")

    @property
    def moments(self) -> int:
        return len(self.slice["step"])


@pytest.fixture(scope="module", params=SPECS)
def recorded(request: pytest.FixtureRequest, server: str) -> Recorded:
    with evswarm.Client(server) as client:
        return Recorded(client, SPECS[request.param])


def by_topic(mcap: bytes) -> tuple[dict[str, list[dict[str, Any]]], dict[str, Any]]:
    """Messages of each topic in the file's order, and the schemas that they are said to have."""
    messages = defaultdict(list)
    schemas = {}
    last_ns = 0
    for schema, channel, message in make_reader(io.BytesIO(mcap)).iter_messages(
        log_time_order=False
    ):
        assert channel.message_encoding == "json"
        assert schema is not None and schema.encoding == "jsonschema"
        assert message.log_time >= last_ns
        last_ns = message.log_time
        schemas[schema.name] = json.loads(schema.data)
        messages[channel.topic].append(json.loads(message.data))
    return messages, schemas


def heading(pose: dict[str, Any]) -> float:
    turn = pose["orientation"]
    assert turn["x"] == turn["y"] == 0
    return 2 * math.atan2(turn["z"], turn["w"])


def test_the_reference_library_reads_the_poses_of_the_slices(recorded: Recorded) -> None:
    messages, schemas = by_topic(recorded.mcap)
    shown = recorded.slice
    assert {"foxglove.PoseInFrame", "foxglove.SceneUpdate"} <= set(schemas)
    numbers = [robot["robot"] for robot in shown["robots"]]
    topics = {"/scene", "/progress"}
    topics |= {f"/robot/{n}/{kind}" for n in numbers for kind in ("pose", "signals")}
    assert set(messages) == topics
    assert [told["step"] for told in messages["/progress"]] == shown["step"]
    assert [told["epoch_step"] for told in messages["/progress"]] == shown["epoch_step"]
    for robot in shown["robots"]:
        poses = [told["pose"] for told in messages[f"/robot/{robot['robot']}/pose"]]
        assert [pose["position"]["x"] for pose in poses] == robot["x_m"]
        assert [pose["position"]["y"] for pose in poses] == robot["y_m"]
        # Half angles and back: the last bits may differ.
        np.testing.assert_allclose(
            [heading(pose) for pose in poses], robot["heading_rad"], atol=1e-12
        )
        signals = messages[f"/robot/{robot['robot']}/signals"]
        for name in ("left", "right", "sensors"):
            assert [told[name] for told in signals] == robot[name], name
        for name in ("state", "action"):
            # A plot has no gaps: -1 where there is none.
            numbers_or_none = [None if told[name] < 0 else told[name] for told in signals]
            assert numbers_or_none == robot[name], name


def test_the_scene_shows_walls_robots_and_objects_where_they_are(recorded: Recorded) -> None:
    messages, _ = by_topic(recorded.mcap)
    shown = recorded.slice
    entities = [entity for told in messages["/scene"] for entity in told["entities"]]
    walls = [entity for entity in entities if entity.get("lines")]
    assert walls and all(line["points"] for entity in walls for line in entity["lines"])
    # The moments, without those that say what the walls are.
    moments = [
        told["entities"]
        for told in messages["/scene"]
        if not any(entity.get("lines") for entity in told["entities"])
    ]
    assert len(moments) == recorded.moments
    for at in range(0, recorded.moments, 37):
        solids = [
            solid["pose"]["position"]
            for entity in moments[at]
            for solid in [*entity.get("cubes", []), *entity.get("cylinders", [])]
        ]
        places = {(solid["x"], solid["y"]) for solid in solids}
        for thing in [*shown["robots"], *shown["objects"]]:
            assert (thing["x_m"][at], thing["y_m"][at]) in places, at


def test_the_mcap_file_is_summed_up_for_players(recorded: Recorded) -> None:
    summary = make_reader(io.BytesIO(recorded.mcap)).get_summary()
    assert summary is not None and summary.statistics is not None
    messages, _ = by_topic(recorded.mcap)
    assert summary.statistics.message_count == sum(map(len, messages.values()))
    assert {channel.topic for channel in summary.channels.values()} == set(messages)


def test_pyarrow_reads_the_rows_of_the_csv_and_the_slices(recorded: Recorded) -> None:
    table = pq.read_table(io.BytesIO(recorded.parquet))
    frame = table.to_pandas()
    read = pd.read_csv(io.BytesIO(recorded.csv), engine="python")  # reads floats exactly
    assert list(frame.columns) == list(read.columns)
    assert len(frame) == len(read) == recorded.moments * len(recorded.slice["robots"])
    for name in frame.columns:
        left, right = frame[name], read[name]
        assert left.isna().equals(right.isna()), name
        assert (left[left.notna()].to_numpy() == right[right.notna()].to_numpy()).all(), name
    for robot in recorded.slice["robots"]:
        rows = frame[frame["robot"] == robot["robot"]]
        assert rows["step"].tolist() == recorded.slice["step"]
        for name in ("x_m", "y_m", "heading_rad", "left", "right"):
            assert rows[name].tolist() == robot[name], name
        for name in ("state", "action"):
            values = [None if pd.isna(value) else int(value) for value in rows[name]]
            assert values == robot[name], name
        sensors = rows[[f"ps{number}" for number in range(8)]].to_numpy().tolist()
        assert sensors == robot["sensors"]
