"""Tests of the modules for Spark and Ray, with workers in other processes."""

import doctest
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

import duckdb
import pyarrow
import pyspark
import pytest
import ray
from pyarrow import parquet
from pyspark.sql import SparkSession

import uavspec
import uavspec.batches
import uavspec.ray
import uavspec.spark

TABLES = ["captures", "failures", "findings", "rules", "topics"]

# Workers don't have this module, so its functions are sent to them.
for pickle in (pyspark.cloudpickle, ray.cloudpickle):
    pickle.register_pickle_by_value(sys.modules[__name__])


@pytest.fixture(scope="module")
def spark() -> Iterator[SparkSession]:
    """A cluster with two executors."""
    os.environ |= {"SPARK_HOME": os.path.dirname(pyspark.__file__), "PYSPARK_PYTHON": sys.executable}
    settings = {"spark.ui.enabled": "false", "spark.log.level": "OFF", "spark.driver.host": "127.0.0.1"}
    builder = SparkSession.builder.master("local-cluster[2,1,1024]").config(map=settings)
    session = builder.getOrCreate()
    yield session
    session.stop()


@pytest.fixture(scope="module")
def cluster() -> Iterator[None]:
    """A cluster with two workers."""
    ray.init(num_cpus=2, include_dashboard=False, logging_level="ERROR")
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield
    ray.shutdown()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with captures, of which every third violates a rule, and every second contains an event."""
    folder = tmp_path_factory.mktemp("captures")
    event = {"timestamp": 1_000, "id": 32_794_487, "event_sequence": 1, "arguments": [6] + [0] * 24, "log_levels": 102}
    for number in range(150):
        message = {"timestamp": 1_000, "request_id": 300 if number % 3 == 0 else 7, "valid_registrations_mask": 1}
        record = {"type": "px4/ArmingCheckRequest", "message": message}
        records = [record, {"type": "px4/Event", "message": event}] if number % 2 == 0 else [record]
        (folder / f"{number:03}.jsonl").write_text("\n".join(map(json.dumps, records)))
    return folder


def captures(folder: Path) -> pyarrow.Table:
    """The captures in a folder, and one that doesn't exist."""
    found = pyarrow.table(uavspec.find(folder)).select(["capture"])
    return pyarrow.concat_tables([found, pyarrow.table({"capture": [str(folder / "absent.ulg")]})])


def assert_right(results: Path, folder: Path, *, timeline: bool = False) -> None:
    """Asserts that the Parquet files in a folder contain the tables of `check_files`."""
    expected = uavspec.check_files(captures(folder)["capture"].to_pylist(), timeline=timeline)
    for name in TABLES + ["timeline", "events"] * timeline:
        wanted = pyarrow.table(getattr(expected, name))
        found = duckdb.sql(f"SELECT * FROM '{results}/{name}/*.parquet'")
        assert found.fetchall()
        assert duckdb.sql("DESCRIBE found").fetchall() == duckdb.sql("DESCRIBE wanted").fetchall(), name
        for file in (results / name).glob("*.parquet"):
            keys = parquet.read_table(file).select(uavspec.batches.KEYS[name][:2]).to_pylist()
            assert keys == sorted(keys, key=lambda row: tuple(row.values())), file
        for query in ("wanted EXCEPT ALL SELECT * FROM found", "found EXCEPT ALL SELECT * FROM wanted"):
            assert duckdb.sql(f"SELECT * FROM {query}").fetchall() == [], name


def assert_continued(results: Path, folder: Path) -> None:
    """Asserts that the program finds nothing left to check."""
    command = [os.environ["UAVSPEC"], "check", "--resume", results, "--timeline", folder]
    output = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "150 of 150 captures are in the tables already" in output.stderr, output.stderr


def kill(marker: Path, batches: Iterable[pyarrow.RecordBatch]) -> Iterator[pyarrow.RecordBatch]:
    """Kills the executor of this worker, once."""
    if not marker.exists():
        marker.touch()
        daemon = Path(f"/proc/{os.getppid()}/stat").read_text().rsplit(")", 1)[1]
        os.kill(int(daemon.split()[1]), signal.SIGKILL)
    yield from batches


def kill_worker(batch: pyarrow.Table, marker: Path) -> pyarrow.Table:
    """Kills this worker, once."""
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return batch


def test_spark_has_the_same_tables(spark: SparkSession, folder: Path, tmp_path: Path):
    results = tmp_path / "results"
    rows = spark.createDataFrame(captures(folder)).repartition(3)
    uavspec.spark.write(rows, results.as_uri(), timeline=True)
    assert_right(results, folder, timeline=True)
    assert_continued(results, folder)
    assert spark.conf.get("spark.sql.parquet.outputTimestampType") == "INT96"
    with pytest.raises(Exception, match="already exists"):
        uavspec.spark.write(rows, results.as_uri())


def test_spark_repeats_the_work_of_a_killed_executor(spark: SparkSession, folder: Path, tmp_path: Path):
    rows = spark.createDataFrame(captures(folder)).repartition(4)
    rows = rows.mapInArrow(partial(kill, tmp_path / "killed"), rows.schema)
    uavspec.spark.write(rows, (tmp_path / "results").as_uri())
    assert (tmp_path / "killed").exists()
    assert_right(tmp_path / "results", folder)


def test_spark_checks_contents(spark: SparkSession, folder: Path):
    files = spark.read.format("binaryFile").load(folder.as_uri())
    checked = uavspec.spark.check(files.withColumnRenamed("path", "capture"), definitions="px4@1.16")
    rows = uavspec.spark.table(checked, "findings").filter("rule = 'PX-JSON-02'").select("capture").distinct()
    assert rows.count() == 50


@pytest.mark.usefixtures("cluster")
def test_ray_has_the_same_tables(folder: Path, tmp_path: Path):
    uavspec.ray.write(ray.data.from_arrow(captures(folder)), str(tmp_path), timeline=True)
    assert_right(tmp_path, folder, timeline=True)
    assert_continued(tmp_path, folder)
    with pytest.raises(FileExistsError, match="already exists"):
        uavspec.ray.write(ray.data.from_arrow(captures(folder)), str(tmp_path))


@pytest.mark.usefixtures("cluster")
def test_ray_repeats_the_work_of_a_killed_worker(folder: Path, tmp_path: Path):
    rows = ray.data.from_arrow(captures(folder)).repartition(3)
    marker = {"marker": tmp_path / "killed"}
    rows = rows.map_batches(kill_worker, batch_format="pyarrow", fn_kwargs=marker)
    uavspec.ray.write(rows, str(tmp_path / "results"))
    assert (tmp_path / "killed").exists()
    assert_right(tmp_path / "results", folder)


def test_examples_of_the_documentation():
    result = doctest.testmod(uavspec.batches)
    assert result.failed == 0 and result.attempted > 2


def test_batches_may_have_contents(folder: Path):
    contents = [path.read_bytes() for path in sorted(folder.iterdir())]
    batch = pyarrow.record_batch({"capture": [f"{number}" for number in range(150)], "content": contents})
    rows = list(uavspec.batches.check_batches([batch, batch.slice(0, 0)], {"timeline": True}))
    assert [row.schema for row in rows] == [uavspec.batches.schema({"timeline": True})] * 3
    found = [capture["capture"] for row in rows for capture in row["captures"][0].as_py()]
    assert found == batch["capture"].to_pylist()


def test_problems_of_batches_are_errors():
    with pytest.raises(uavspec.Error, match="unknown release"):
        uavspec.batches.schema({"definitions": "px4@0.1"})
    for column in ("capture", "content"):
        batch = pyarrow.record_batch({"capture": ["a"], "content": [b"{}"], column: pyarrow.array([None], pyarrow.binary())})
        with pytest.raises(uavspec.Error, match=f"the column `{column}` contains nulls"):
            list(uavspec.batches.check_batches([batch], {}))
