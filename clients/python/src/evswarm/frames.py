"""Rows as data frames; pandas and polars are imported when they are asked for."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas
    import polars


def to_pandas(rows: Sequence[dict[str, Any]]) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame.from_records(list(rows))


def to_polars(rows: Sequence[dict[str, Any]]) -> polars.DataFrame:
    import polars

    # Every row counts for the types: a column may be empty in the first runs.
    return polars.from_dicts(list(rows), infer_schema_length=None) if rows else polars.DataFrame()


def parquet_pandas(file: bytes) -> pandas.DataFrame:
    import pandas

    # Whole numbers stay whole where some are missing.
    return pandas.read_parquet(io.BytesIO(file), dtype_backend="numpy_nullable")


def parquet_polars(file: bytes) -> polars.DataFrame:
    import polars

    return polars.read_parquet(io.BytesIO(file))


def csv_pandas(text: str) -> pandas.DataFrame:
    import pandas

    return pandas.read_csv(io.StringIO(text))
