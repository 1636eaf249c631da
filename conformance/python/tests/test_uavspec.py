"""Tests of the Python package, with captures that the tests make."""

import doctest
import gzip
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import duckdb
import polars
import pyarrow
import pytest
from pyarrow import parquet

import pyulog
import uavspec

TABLES = ("captures", "failures", "topics", "findings", "rules")
TOPIC = "/fmu/out/arming_check_request"


def request(number: int, request_id: int) -> bytes:
    fields = {"timestamp": 1_000_000 * number, "request_id": request_id, "valid_registrations_mask": 1}
    return json.dumps({"op": "publish", "topic": TOPIC, "msg": fields}).encode() + b"\n"


GOOD = b"".join(request(number, number) for number in range(5))
BAD = GOOD + request(5, 300)


def rows(table: uavspec.Table) -> list[dict]:
    return pyarrow.table(table).to_pylist()


def test_examples_of_the_documentation():
    assert doctest.testmod(uavspec).failed == 0
    assert doctest.testmod(uavspec).attempted > 10


def test_examples_of_the_readme(tmp_path: Path):
    readme = (Path(__file__).parents[1] / "README.md").read_text()
    examples = re.findall(r"```python\n([^`]*)```\n\n```text\n([^`]*)```", readme)
    assert len(examples) > 4
    for index, (code, printed) in enumerate(examples):
        path = tmp_path / f"example_{index}.py"
        path.write_text(code)
        assert subprocess.check_output([sys.executable, path], text=True) == printed
    subprocess.run([sys.executable, "-m", "mypy", "--strict", *tmp_path.iterdir()], check=True)


def test_the_package_has_all_types_of_the_definitions():
    generated = Path(__file__).parents[3] / "generated/python"
    package = Path(uavspec.__file__).parent
    for path in generated.rglob("*.py"):
        installed = package / path.relative_to(generated)
        assert installed.exists(), f"link {installed.relative_to(package)} to {path}"
        if path.parent != generated or path.name != "__init__.py":
            assert installed.read_bytes() == path.read_bytes()
    assert uavspec.px4.BatteryStatusBatteryWarning(2).value == 2


def test_paths_and_content_have_the_same_report(tmp_path: Path):
    path = tmp_path / "bad.jsonl"
    path.write_bytes(BAD)
    (tmp_path / "bad.jsonl.gz").write_bytes(gzip.compress(BAD))
    reports = [uavspec.check(path), uavspec.check(str(path)), uavspec.check(str(path) + ".gz")]
    reports += [uavspec.check(kind(BAD), name="x.jsonl") for kind in (bytes, bytearray, memoryview)]
    for report in reports:
        assert report.outcome == "does not conform"
        [finding] = [row for row in rows(report.findings) if row["verdict"] == "fail"]
        assert (finding["rule"], finding["actual"], finding["count"]) == ("PX-JSON-02", "300", 1)
        assert rows(report.captures)[0]["outcome"] == report.outcome
    assert [rows(report.captures)[0]["capture"] for report in reports[2:4]] == [str(path) + ".gz", "x.jsonl"]


def test_reports_are_those_of_the_program(tmp_path: Path):
    path = tmp_path / "bad.jsonl"
    path.write_bytes(BAD)
    report = json.loads(uavspec.check(path).to_json())
    program = os.environ.get("UAVSPEC")
    if program is None:
        pytest.skip("UAVSPEC doesn't name the program")
    printed = subprocess.run([program, "check", "--format", "json", path], capture_output=True, check=False).stdout
    expected = json.loads(printed)
    for other in (report, expected):
        del other["command"]
    assert report == expected
    text = subprocess.run([program, "check", path], capture_output=True, check=False, text=True).stdout
    assert "PX-JSON-02" in text and "PX-JSON-02" in str(uavspec.check(path))


def test_tables_are_those_of_the_program(tmp_path: Path):
    program = os.environ.get("UAVSPEC")
    if program is None:
        pytest.skip("UAVSPEC doesn't name the program")
    (tmp_path / "bad.jsonl").write_bytes(BAD)
    captures = [str(tmp_path / name) for name in ("absent.ulg", "bad.jsonl")]
    tables = tmp_path / "tables"
    subprocess.run([program, "check", "--report", f"parquet={tables}", *captures], capture_output=True, check=False)
    results = uavspec.check_files(captures)
    for name in TABLES:
        assert parquet.read_table(tables / name).equals(pyarrow.table(getattr(results, name))), name


def test_options_change_the_outcome():
    assert uavspec.check(GOOD).outcome == "conforms"
    [release] = {row["release"] for row in rows(uavspec.check(GOOD, definitions="px4@1.16").topics)}
    assert release == "px4@1.16"
    with pytest.raises(uavspec.Error, match="timeline=True"):
        _ = uavspec.check(GOOD).timeline
    assert len(uavspec.check(GOOD, timeline=True).timeline) > 0


def test_other_libraries_take_tables():
    report = uavspec.check(BAD)
    for name in TABLES:
        taken = table = getattr(report, name)
        arrow = pyarrow.table(table)
        assert arrow.column_names == table.column_names and arrow.num_rows == len(table)
        assert polars.DataFrame(table).shape == (len(table), len(table.column_names))
        assert duckdb.sql("SELECT count(*) FROM taken").fetchall() == [(len(table),)]
    assert pyarrow.schema(report.findings).field("time").metadata[b"unit"] == b"s"
    # A table can be taken several times, and outlives its report.
    rules = report.rules
    del report
    assert pyarrow.table(rules) == pyarrow.table(rules)


def test_many_captures_have_the_tables_of_each(tmp_path: Path):
    captures = [(f"{number:03}.jsonl", BAD if number % 3 == 0 else GOOD) for number in range(30)]
    one, many = (uavspec.check_files([*captures, tmp_path / "absent.ulg"], jobs=jobs) for jobs in (1, 8))
    for name in TABLES:
        assert pyarrow.table(getattr(one, name)) == pyarrow.table(getattr(many, name)), name
    assert len(many.captures) == 30
    assert [row["capture"] for row in rows(many.failures)] == [str(tmp_path / "absent.ulg")]
    wanted = {name for name, content in captures if content is BAD}
    assert {row["capture"] for row in rows(many.findings) if row["rule"] == "PX-JSON-02"} == wanted
    singles = [row for name, content in captures for row in rows(uavspec.check(content, name=name).topics)]
    key = lambda row: (row["topic"], row["capture"])
    assert sorted(singles, key=key) == sorted(rows(many.topics), key=key)
    assert len(uavspec.check_files([]).captures) == 0


def test_topics_are_read_with_units():
    table = uavspec.read(GOOD, TOPIC)
    arrow = pyarrow.table(table)
    assert arrow["request_id"].to_pylist() == list(range(5))
    assert arrow["timestamp"].to_pylist() == [1_000_000 * number for number in range(5)]
    assert arrow.schema.field("request_id").type == pyarrow.uint8()
    assert arrow.schema.field("timestamp").type == pyarrow.uint64()
    assert table.metadata("timestamp")["unit"] == "us"
    # The last message can't be read, because its value is out of range.
    assert len(uavspec.read(BAD, TOPIC)) == 5


def test_stories_are_text_json_and_a_table():
    timeline = uavspec.explain(GOOD)
    assert json.loads(timeline.to_json())["lanes"]
    assert str(timeline) and len(timeline.timeline) > 0


def test_events_have_texts(tmp_path: Path):
    event = {"timestamp": 9, "id": 32_794_487, "event_sequence": 1, "arguments": [6] + [0] * 24, "log_levels": 0x66}
    message = json.dumps({"op": "publish", "topic": "/fmu/out/event", "msg": event}).encode()
    [row] = rows(uavspec.explain(message).events)
    assert (row["name"], row["message"]) == ("px4::commander_disarmed_by", "Disarmed: landing")
    assert rows(uavspec.check(message, timeline=True).events)[0]["message"] == row["message"]
    decoded = uavspec.px4_events.decode_event(event["id"], bytes(event["arguments"]))
    assert decoded is not None and (decoded.name, decoded.message()) == (row["name"], row["message"])
    own = {"1": {"name": "kite", "message": "Kite"}}
    own = {"version": 2, "components": {"0": {"namespace": "wind", "event_groups": {"default": {"events": own}}}}}
    (tmp_path / "events.json").write_text(json.dumps(own))
    [row] = rows(uavspec.explain(message.replace(b"32794487", b"1"), events=tmp_path / "events.json").events)
    assert (row["name"], row["event_metadata"]) == ("wind::kite", str(tmp_path / "events.json"))


def test_problems_are_errors(tmp_path: Path):
    for call, problem in [
        (lambda: uavspec.check(tmp_path / "absent.ulg"), "absent.ulg: "),
        (lambda: uavspec.check(tmp_path), "directory"),
        (lambda: uavspec.find(tmp_path), "no captures in this folder"),
        (lambda: uavspec.find(tmp_path / "*.ulg"), "no file matches this pattern"),
        (lambda: uavspec.check("a\0b"), "NUL byte"),
        (lambda: uavspec.check("https://host.invalid:x/a.ulg"), "not a URL"),
        (lambda: uavspec.check(GOOD, definitions="px4@0.1"), "unknown release `px4@0.1`"),
        (lambda: uavspec.check(GOOD, definitions=tmp_path / "absent"), "absent"),
        (lambda: uavspec.check(GOOD, schemas=[tmp_path / "absent"]), "absent"),
        (lambda: uavspec.read(GOOD, "/fmu/out/arming_check_requests"), f"did you mean `{TOPIC}`"),
        (lambda: uavspec.read(b"", TOPIC), "bytes: "),
        (lambda: uavspec.explain(b"nothing"), "bytes: "),
        (lambda: uavspec.check(GOOD).findings.metadata("absent"), "absent"),
        (lambda: uavspec.read(GOOD, TOPIC, instance=256), "instance: expected 0 to 255, found 256"),
        (lambda: uavspec.read(GOOD, TOPIC, instance=-1), "instance: expected 0 to 255, found -1"),
        (lambda: uavspec.check_files([GOOD], jobs=0), "jobs: expected at least 1, found 0"),
        (lambda: uavspec.check_files([GOOD], jobs=-1), "jobs: expected at least 1, found -1"),
    ]:
        with pytest.raises(uavspec.Error, match=problem):
            call()
    [failure] = rows(uavspec.check_files(["https://user:secret@host.invalid:x/a.ulg?signature=secret"]).failures)
    assert "host.invalid" in failure["capture"] and "secret" not in str(failure)
    for wrong in (None, 7, ["a.ulg"]):
        with pytest.raises(TypeError):
            uavspec.check(wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="a name is allowed only for bytes"):
        uavspec.check("a.ulg", name="b.ulg")
    for single in ("flight.ulg", b"content", bytearray(b"content"), memoryview(b"content"), tmp_path):
        with pytest.raises(TypeError, match="captures: expected a list, found a single value"):
            uavspec.check_files(single)  # type: ignore[arg-type]
    for single in ("schemas", tmp_path):
        with pytest.raises(TypeError, match="schemas: expected a list, found a single value"):
            uavspec.check(GOOD, schemas=single)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match="schemas: expected a list, found a single value"):
            uavspec.check_files([GOOD], schemas=single)  # type: ignore[arg-type]
    assert len(uavspec.check_files([GOOD], jobs=2**80).captures) == 1


@pytest.mark.parametrize("content", [b"", b"\0", b"ULog", b"ULog\x01\x12\x35\x01" + bytes(8), os.urandom(4096), b"{" * 70_000])
def test_unreadable_content_is_reported(content: bytes):
    report = uavspec.check(content)
    assert report.outcome in ("incomplete", "not checked")
    assert len(report.captures) == 1 and json.loads(report.to_json())["subjects"]


def test_threads_run_in_parallel():
    expected = pyarrow.table(uavspec.check(BAD).findings)
    results: list[bool] = []

    def work() -> None:
        results.extend(pyarrow.table(uavspec.check(BAD).findings) == expected for _ in range(10))

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True] * 80


def test_an_interrupt_ends_a_call(tmp_path: Path):
    pipe = tmp_path / "pipe.jsonl"
    os.mkfifo(pipe)
    program = f"import uavspec\nprint('started', flush=True)\nuavspec.check({str(pipe)!r})"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.readline()
        # The pipe opens when the check reads it.
        with open(pipe, "wb"):
            process.send_signal(2)
            assert b"KeyboardInterrupt" in process.stderr.read()
        process.wait()


def corpus() -> Path:
    """The folder with captures that others made."""
    default = Path(__file__).parents[4] / "shared/corpus"
    folder = Path(os.environ.get("UAVSPEC_CORPUS", default)) / "ulog"
    if not folder.exists() and os.environ.get("UAVSPEC_REQUIRE_CORPUS", "0") == "0":
        pytest.skip("there is no corpus")
    return folder


def columns(array: pyarrow.Array, name: str) -> dict[str, list]:
    """The columns of a field, as pyulog names them."""
    if pyarrow.types.is_struct(array.type):
        parts = [columns(array.field(index), f"{name}.{field.name}") for index, field in enumerate(array.type)]
        return {key: values for part in parts for key, values in part.items()}
    if pyarrow.types.is_fixed_size_list(array.type):
        size, values = array.type.list_size, array.flatten()
        parts = [columns(values.take(pyarrow.array(range(index, len(values), size))), f"{name}[{index}]") for index in range(size)]
        return {key: values for part in parts for key, values in part.items()}
    return {name: array.to_pylist()}


def test_values_agree_with_pyulog():
    compared = 0
    for path in sorted(corpus().glob("*.ulg")):
        try:
            log = pyulog.ULog(str(path))
        except Exception:  # noqa: BLE001
            continue
        for dataset in log.data_list:
            try:
                table = uavspec.read(path, dataset.name, instance=dataset.multi_id)
            except uavspec.Error as error:
                assert "has no definition" in str(error), f"{path}: {error}"
                continue
            arrow = pyarrow.table(table).combine_chunks()
            found = {}
            for name in table.column_names[1:]:
                found |= columns(arrow[name].combine_chunks(), name)
            for name, expected in dataset.data.items():
                if name not in found:
                    continue  # A text: pyulog has a column for each of its characters.
                values = [repr(float(value)) for value in expected.tolist()]
                assert [repr(float(value)) for value in found[name]] == values, f"{path}: {dataset.name}.{name}"
                compared += len(values)
    assert compared > 100_000
