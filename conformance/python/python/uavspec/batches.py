"""Checks batches of captures, for engines that distribute them.

The modules `uavspec.spark` and `uavspec.ray` use these functions, which require PyArrow. A batch has the column `capture`
with paths or URLs. If it also has the column `content`, `capture` is only the name of the content.

The result has a column for each table, such as `findings`. Each row contains the results of up to 64 captures, and each value
is the list of their rows in that table. An engine thus distributes all tables as one.
"""

from collections.abc import Iterable, Iterator
from os import PathLike
from typing import TypedDict

import pyarrow

from . import Capture, Error, Results, check_files

__all__ = ["KEYS", "Options", "check_batches", "schema"]

MAX_CAPTURES = 64
"""The maximum number of captures in a row of the result. It limits the memory of a worker."""

KEYS = {
    "events": ["name", "capture", "time"],
    "failures": ["capture"],
    "findings": ["rule", "field", "capture"],
    "rules": ["rule", "capture"],
    "timeline": ["name", "capture", "time"],
    "topics": ["topic", "capture"],
    "captures": ["capture"],
}
"""The columns by which each table is sorted. The captures are the last table, so the rows of a listed capture are written."""


class Options(TypedDict, total=False):
    """The options of `check_files`."""

    definitions: str | PathLike[str] | None
    events: str | PathLike[str] | None
    schemas: list[str | PathLike[str]]
    timeline: bool
    strict_formats: bool
    deny_warnings: bool
    jobs: int | None


def check_batches(batches: Iterable[pyarrow.RecordBatch], options: Options) -> Iterator[pyarrow.RecordBatch]:
    """Checks the captures of batches.

    >>> batch = pyarrow.record_batch({"capture": ["a.jsonl"], "content": [b'{"type": "px4/ArmingCheckRequest"}']})
    >>> [result] = check_batches([batch], {})
    >>> [row["kind"] for row in result["captures"][0].as_py()]
    ['json']
    """
    for batch in batches:
        for start in range(0, batch.num_rows, MAX_CAPTURES):
            yield _row(check_files(_captures(batch.slice(start, MAX_CAPTURES)), **options), options)


def schema(options: Options) -> pyarrow.Schema:
    """The schema of the results of `check_batches`. Options that are wrong raise an `Error`."""
    return _row(check_files([], **options), options).schema


def _captures(batch: pyarrow.RecordBatch) -> list[Capture | tuple[str, memoryview]]:
    for column in ("capture", "content"):
        if column in batch.schema.names and batch[column].null_count > 0:
            raise Error(f"the column `{column}` contains nulls")
    names: list[str] = batch["capture"].cast(pyarrow.string()).to_pylist()
    if "content" not in batch.schema.names:
        return list(names)
    contents = (memoryview(content.as_buffer()).cast("B") for content in batch["content"])
    return list(zip(names, contents, strict=True))


def _row(results: Results, options: Options) -> pyarrow.RecordBatch:
    """The tables in one row."""
    columns = {}
    for name in KEYS:
        if name not in ("events", "timeline") or options.get("timeline", False):
            rows = pyarrow.table(getattr(results, name)).to_struct_array().combine_chunks()
            columns[name] = pyarrow.ListArray.from_arrays([0, len(rows)], rows)
    return pyarrow.record_batch(columns)
