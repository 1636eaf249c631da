from os import PathLike

from . import Capture

__version__: str

class Error(Exception):
    """The problem of a capture, of definitions or of a topic."""

class Table:
    """A table, which Arrow libraries take without a copy, such as `pyarrow.table(table)` or `polars.DataFrame(table)`."""

    @property
    def column_names(self) -> list[str]: ...
    def metadata(self, column: str) -> dict[str, str]:
        """The facts about a column: its `description` and perhaps its `unit` and `values`."""

    def __len__(self) -> int: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class Results:
    """The tables of checked captures. The guide of uavspec describes their columns."""

    @property
    def captures(self) -> Table: ...
    @property
    def failures(self) -> Table: ...
    @property
    def topics(self) -> Table: ...
    @property
    def findings(self) -> Table: ...
    @property
    def rules(self) -> Table: ...
    @property
    def timeline(self) -> Table:
        """The changes of flags, error codes and modes. Only after a call with `timeline=True`."""
    @property
    def events(self) -> Table:
        """The events of PX4 with their texts. Only after a call with `timeline=True`."""

class Report(Results):
    """The report of a capture. `str` returns the text that `uavspec check` prints."""

    @property
    def outcome(self) -> str:
        """The outcome, such as "conforms" or "does not conform"."""

    @property
    def text(self) -> str:
        """The outcome as a sentence."""

    def to_json(self) -> str:
        """The report in JSON, like that of `uavspec check --format json`."""

class Timeline:
    """The timeline of a capture. `str` returns the text that `uavspec explain` prints."""

    @property
    def timeline(self) -> Table: ...
    @property
    def events(self) -> Table: ...
    def to_json(self) -> str: ...

def check(
    capture: Capture,
    name: str | None,
    definitions: str | PathLike[str] | None,
    events: str | PathLike[str] | None,
    schemas: list[str | PathLike[str]],
    timeline: bool,
    strict_formats: bool,
    deny_warnings: bool,
) -> Report: ...
def check_files(
    captures: list[Capture | tuple[str, bytes | bytearray | memoryview]],
    definitions: str | PathLike[str] | None,
    events: str | PathLike[str] | None,
    schemas: list[str | PathLike[str]],
    timeline: bool,
    strict_formats: bool,
    deny_warnings: bool,
    jobs: int | None,
) -> Results: ...
def find(inputs: list[str | PathLike[str]]) -> Table: ...
def read(capture: Capture, topic: str, instance: int, definitions: str | PathLike[str] | None) -> Table: ...
def explain(
    capture: Capture,
    definitions: str | PathLike[str] | None,
    events: str | PathLike[str] | None,
) -> Timeline: ...
