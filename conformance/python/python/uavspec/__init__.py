"""Checks, reads and explains logs, bags and recorded sessions of drones.

>>> import uavspec
>>> message = b'{"timestamp": 9, "request_id": 300, "valid_registrations_mask": 1}'
>>> request = b'{"type": "px4/ArmingCheckRequest", "message": %s}' % message
>>> report = uavspec.check(request)
>>> report.outcome
'does not conform'

Tables implement the Arrow PyCapsule interface, so PyArrow, Polars, DuckDB and pandas take them without a copy:

>>> import pyarrow
>>> findings = pyarrow.table(report.findings)
>>> findings["rule"].to_pylist()
['PX-JSON-02']

All functions release Python's lock while they work, so threads run in parallel. Each problem is an `Error`, except for
arguments of the wrong type, which are a `TypeError`.

The modules `px4`, `px4_events`, `flockwave` and `labels` contain the types of the definitions, and `data` their JSON Schemas and test vectors.
"""

from collections.abc import Iterable
from os import PathLike
from typing import TypeAlias, TypeVar

from . import _native, flockwave, px4, px4_events
from ._native import Error, Report, Results, Timeline, Table, __version__

__all__ = [
    "Capture",
    "Error",
    "Report",
    "Results",
    "Timeline",
    "Table",
    "__version__",
    "check",
    "check_files",
    "explain",
    "find",
    "flockwave",
    "px4",
    "px4_events",
    "read",
]

Capture: TypeAlias = str | PathLike[str] | bytes | bytearray | memoryview
"""A capture: the path of a file or of a bag's folder, the URL of an object, or the content of a file."""

_MAX_INSTANCE = 255
"""The highest instance of a topic. A log stores it in a byte."""

_T = TypeVar("_T")


def check(
    capture: Capture,
    *,
    name: str | None = None,
    definitions: str | PathLike[str] | None = None,
    events: str | PathLike[str] | None = None,
    schemas: Iterable[str | PathLike[str]] = (),
    timeline: bool = False,
    strict_formats: bool = False,
    deny_warnings: bool = False,
) -> Report:
    """Checks a capture, like `uavspec check`.

    Args:
        capture: the path, the URL or the content. Content may be compressed with gzip or zstd.
        name: the name of the content in reports and tables.
        definitions: a release such as "px4@1.16", or the path of definitions. By default, uavspec chooses the release that
            matches the capture best.
        events: the path of event metadata, for events in captures without it.
        schemas: folders with JSON Schemas for other Flockwave types.
        timeline: whether the report has the tables `timeline` and `events`.
        strict_formats: whether formats that differ from the definitions are violations.
        deny_warnings: whether violations of rules of level SHOULD fail the check.

    Raises:
        Error: the capture can't be opened, or the definitions can't be read. Content that can't be read is not an error:
            the report says so.

    >>> check(b'{"type": "px4/ArmingCheckRequest", "message": {"request_id": "7"}}', name="request.jsonl").outcome
    'does not conform'
    """
    folders = _several(schemas, "schemas")
    return _native.check(capture, name, definitions, events, folders, timeline, strict_formats, deny_warnings)


def check_files(
    captures: Iterable[Capture | tuple[str, bytes | bytearray | memoryview]],
    *,
    definitions: str | PathLike[str] | None = None,
    events: str | PathLike[str] | None = None,
    schemas: Iterable[str | PathLike[str]] = (),
    timeline: bool = False,
    strict_formats: bool = False,
    deny_warnings: bool = False,
    jobs: int | None = None,
) -> Results:
    """Checks several captures in parallel. The rows of the tables don't depend on the number of threads.

    The table `failures` contains the captures that can't be opened. The other arguments are those of `check`.

    Args:
        captures: paths, URLs, or pairs of a name and the content.
        jobs: the number of threads. By default, there is one for each processor.

    Raises:
        Error: the definitions can't be read, or `jobs` is less than 1.

    >>> request = b'{"type": "px4/ArmingCheckRequest", "message": {"request_id": 7}}'
    >>> results = check_files([("a.jsonl", request), ("b.jsonl", request), "absent.ulg"])
    >>> len(results.captures), len(results.failures)
    (2, 1)
    """
    options = (definitions, events, _several(schemas, "schemas"), timeline, strict_formats, deny_warnings)
    all_captures = _several(captures, "captures")
    if jobs is not None:
        if jobs < 1:
            raise Error(f"jobs: expected at least 1, found {jobs}")
        # More threads would have nothing to do.
        jobs = min(jobs, max(1, len(all_captures)))
    return _native.check_files(all_captures, *options, jobs)


def find(*inputs: str | PathLike[str]) -> Table:
    """Finds the captures that files, folders, patterns and URLs denote, with the columns `capture`, `size` and `etag`.

    Raises:
        Error: a folder or link can't be read, or an input yields no captures. A missing file is not an error here: `check`
            reports it.

    >>> find("flight.ulg").column_names
    ['capture', 'size', 'etag']
    """
    return _native.find(list(inputs))


def read(
    capture: Capture,
    topic: str,
    *,
    instance: int = 0,
    definitions: str | PathLike[str] | None = None,
) -> Table:
    """Reads the messages of a topic, with a row for each message and a column for each field.

    The table is in memory. The definition of the topic must be known. `Table.metadata` returns the unit and the meaning of
    a field, and the values of an enum in JSON.

    Args:
        topic: the name in the capture, such as "vehicle_status" in a PX4 log or "/fmu/out/vehicle_status_v1" in a bag.
        instance: the instance of the topic in a PX4 log, from 0 to 255.

    Raises:
        Error: the capture doesn't contain the topic, or the topic has no definition.

    >>> message = b'{"timestamp": 9, "request_id": 7, "valid_registrations_mask": 1}'
    >>> request = b'{"type": "px4/ArmingCheckRequest", "message": %s}' % message
    >>> table = read(request, "px4/ArmingCheckRequest")
    >>> len(table), table.metadata("timestamp")["unit"]
    (1, 'us')
    """
    if not 0 <= instance <= _MAX_INSTANCE:
        raise Error(f"instance: expected 0 to {_MAX_INSTANCE}, found {instance}")
    return _native.read(capture, topic, instance, definitions)


def explain(
    capture: Capture,
    *,
    definitions: str | PathLike[str] | None = None,
    events: str | PathLike[str] | None = None,
) -> Timeline:
    """Explains what a vehicle did and why, like `uavspec explain`. `str` returns the text.

    Raises:
        Error: the capture can't be read.
    """
    return _native.explain(capture, definitions, events)


def _several(values: Iterable[_T], name: str) -> list[_T]:
    """A list of the values of an argument. A single path or content is also iterable, but its parts are characters or numbers."""
    if isinstance(values, str | bytes | bytearray | memoryview | PathLike):
        raise TypeError(f"{name}: expected a list, found a single value")
    return list(values)
