"""The client against a real server."""

from __future__ import annotations

import numpy as np
import pytest

import evswarm

SMALL = {
    "arena": "easy",
    "controller": {"method": "brownian"},
    "epochs": 3,
    "steps_per_epoch": 200,
}


def small_job(name: str, count: int = 2) -> dict[str, object]:
    return {"name": name, "base": SMALL, "seeds": {"first": 1, "count": count}}


def test_a_job_is_submitted_waited_for_and_read(client: evswarm.Client) -> None:
    looks: list[float] = []
    job = client.submit(
        {**small_job("sweep"), "matrix": {"controller.method": ["brownian", "im"]}}
    ).wait(timeout_s=60, progress=lambda job: looks.append(job.progress))
    assert job.state == "done" and job.progress == 1.0 and job.counts["total"] == 4
    assert looks[-1] == 1.0

    runs = list(job.runs())
    assert [run.method for run in runs] == ["brownian", "brownian", "im", "im"]
    for run in runs:
        visits = run.visits()
        assert visits.dtype == np.uint32 and visits.shape == (100, 100)
        assert int((visits > 0).sum()) == run.result()["p1"] == run.curve()[-1]["p1"]
        assert run.dwell().sum() >= visits.sum()
        assert run.spec()["seed"] == run.seed
        assert run.coverage_png().startswith(b"\x89PNG")
        assert run.coverage_svg().lstrip().startswith("<svg")


def test_tables_are_the_same_in_pandas_and_polars(client: evswarm.Client) -> None:
    job = client.submit(small_job("tables")).wait(timeout_s=60)
    pandas, polars = job.to_pandas(), job.to_polars()
    assert list(pandas["seed"]) == polars["seed"].to_list() == [1, 2]
    assert list(pandas["p1"]) == polars["p1"].to_list()
    run = next(job.runs())
    assert list(run.curve_pandas()["epoch"]) == run.curve_polars()["epoch"].to_list() == [1, 2, 3]
    assert list(run.metrics_pandas().columns) == run.metrics_polars().columns
    assert len(run.robots_pandas()) == 1
    assert len(job.curves()) == 6
    assert job.summary()


def test_tables_of_a_job_have_the_types_of_their_columns(client: evswarm.Client) -> None:
    import pyarrow.parquet

    matrix = {"controller.method": ["brownian", "im"], "robots": [1, 2]}
    base = {**SMALL, "placement": "grid"}
    job = client.submit(
        {"name": "typed", "base": base, "matrix": matrix, "seeds": {"first": 1, "count": 2}}
    ).wait(timeout_s=60)
    runs = job.to_pandas()
    assert len(runs) == 8 and len(runs.columns) > 60
    assert runs.dtypes["p1"] == "Int64" and runs.dtypes["fractions.p1"] == "Float64"
    assert runs.dtypes["controller.method"] == "string"
    assert runs.groupby(["controller.method", "robots"])["p1"].count().to_list() == [2, 2, 2, 2]
    for run in job.runs():
        row = runs[runs["run"] == run.id].iloc[0]
        for name, value in run.row().items():
            if name in runs.columns:
                assert (row[name] == value) if value is not None else row.isna()[name], name
    polars = job.to_polars()
    assert polars.columns == list(runs.columns)
    assert job.runs_csv().splitlines()[0].split(",") == polars.columns
    # Without a value a column has its type all the same.
    waiting = client.submit_run({**SMALL, "epochs": 1_000_000}).to_polars()
    assert waiting.schema == polars.schema

    curves = job.curves_polars()
    assert len(curves) == len(job.curves()) == 24
    assert len(job.curves_pandas()) == 24
    metrics = job.metrics_polars()
    run = next(job.runs())
    own = run.metrics_polars()
    mine = metrics.filter(metrics["run"] == run.id).select(own.columns)
    assert mine.equals(own)
    assert len(job.metrics_pandas()) == len(metrics)
    schema = pyarrow.parquet.read_schema(__import__("io").BytesIO(job.parquet("metrics")))
    assert str(schema.field("steps").type) == "int64"
    assert str(schema.field("entropy").type) == "double"


def test_a_wrong_spec_tells_every_wrong_field(client: evswarm.Client) -> None:
    with pytest.raises(evswarm.SpecRefused) as refused:
        client.submit_run({"arena": "nowhere", "epochs": 0, "controler": {}})
    assert refused.value.status == 422
    pointers = {error.pointer for error in refused.value.errors}
    assert {"/base/arena", "/base/epochs", "/base/controler"} <= pointers
    assert "/base/epochs" in str(refused.value)


def test_the_same_key_makes_one_job(client: evswarm.Client) -> None:
    first = client.submit(small_job("once"), idempotency_key="once")
    again = client.submit(small_job("once"), idempotency_key="once")
    assert first.id == again.id
    with pytest.raises(evswarm.SpecRefused):
        client.submit(small_job("twice"), idempotency_key="once")


def test_a_job_is_paused_resumed_cancelled_retried_and_deleted(client: evswarm.Client) -> None:
    long = {**SMALL, "epochs": 100_000, "steps_per_epoch": 2_000, "seed": 77}
    job = client.submit_run(long, name="long")
    with pytest.raises(evswarm.WaitTimeout):
        job.wait(timeout_s=0.3)
    run = next(job.runs())
    with pytest.raises(evswarm.Conflict):
        run.result()
    assert job.pause().state == "paused"
    assert job.resume().state in ("queued", "running")
    assert job.cancel().state == "cancelled"
    assert job.wait(timeout_s=10).state == "cancelled"
    assert job.retry().state in ("queued", "running")
    job.delete()
    with pytest.raises(evswarm.NotFound):
        client.job(job.id)
    with pytest.raises(evswarm.NotFound):
        client.run("0" * 64)


def test_jobs_are_listed_newest_first(client: evswarm.Client) -> None:
    made = [client.submit(small_job(f"listed {n}", 1)).id for n in range(3)]
    listed = [job.id for job in client.jobs()]
    assert listed[:3] == made[::-1]


def test_arenas_are_uploaded_used_and_deleted(client: evswarm.Client) -> None:
    arena = {
        "name": "cell",
        "width_m": 0.5,
        "height_m": 0.5,
        "walls_m": [],
        "starts": [{"x_m": 0.2, "y_m": 0.2, "heading_rad": 0.0}],
    }
    client.add_arena(arena)
    assert "cell" in [listed["name"] for listed in client.arenas()]
    with pytest.raises(evswarm.Conflict):
        client.add_arena({**arena, "width_m": 0.6})
    job = client.submit_run({**SMALL, "arena": "cell"}).wait(timeout_s=60)
    with pytest.raises(evswarm.Conflict):
        client.delete_arena("cell")
    job.delete()
    client.delete_arena("cell")


def test_what_can_be_asked_for_is_listed(client: evswarm.Client) -> None:
    assert "im" in [method["name"] for method in client.controllers()["methods"]]
    assert "chapter-5" in [template["name"] for template in client.templates()]
    assert client.is_ready()


def test_no_server_is_a_connection_that_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EVSWARM_SERVER", "http://127.0.0.1:9")
    with evswarm.Client() as client:
        assert client.server == "http://127.0.0.1:9" and not client.is_ready()
        with pytest.raises(evswarm.ConnectionFailed, match=r"127\.0\.0\.1:9"):
            client.job(1)


def test_loopback_is_reached_without_the_proxy_of_the_environment(
    server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY", "HTTPS_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    with evswarm.Client(server) as client:
        assert client.is_ready()
