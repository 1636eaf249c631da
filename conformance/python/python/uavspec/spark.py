"""Checks captures on Apache Spark.

    captures = spark.createDataFrame(pyarrow.table(uavspec.find("s3://flights/2026/")))
    uavspec.spark.write(captures.repartition(1000), "s3a://results/2026")

The workers open the captures and require this package. A task checks the captures of a partition one after the other.
"""

from functools import partial
from typing import Unpack

import pyarrow
from pyspark import StorageLevel
from pyspark.sql import DataFrame
from pyspark.sql.functions import inline

from .batches import KEYS, Options, check_batches, schema

__all__ = ["check", "table", "write"]

_TIME_TYPE = "spark.sql.parquet.outputTimestampType"


def check(captures: DataFrame, **options: Unpack[Options]) -> DataFrame:
    """Checks captures. The result has a column for each table, which `table` turns into rows.

    Args:
        captures: paths or URLs in the column `capture`. If there is a column `content`, `capture` is only its name.
        options: those of `uavspec.check_files`. `jobs` is the number of threads of a task, by default 1.
    """
    options.setdefault("jobs", 1)
    columns = ["capture"] + ["content"] * ("content" in captures.columns)
    result = ", ".join(f"{field.name} {_type(field.type)}" for field in schema(options))
    return captures.select(columns).mapInArrow(partial(check_batches, options=options), result)


def table(checked: DataFrame, name: str) -> DataFrame:
    """The rows of a table, such as `findings`, in the result of `check`. Each partition is sorted like a file of uavspec."""
    return checked.select(inline(name)).sortWithinPartitions(KEYS[name])


def write(captures: DataFrame, folder: str, **options: Unpack[Options]) -> None:
    """Checks captures, and writes a folder with Parquet files for each table. The folder must be new.

    The arguments are those of `check`.
    """
    checked = check(captures, **options).persist(StorageLevel.DISK_ONLY)
    configuration = captures.sparkSession.conf
    time_type = str(configuration.get(_TIME_TYPE))
    # By default, Spark writes times in a format that is deprecated in Parquet.
    configuration.set(_TIME_TYPE, "TIMESTAMP_MICROS")
    try:
        for name in checked.columns:
            table(checked, name).write.parquet(f"{folder}/{name}")
    finally:
        configuration.set(_TIME_TYPE, time_type)
        checked.unpersist()


def _type(data_type: pyarrow.DataType) -> str:
    """The name of a type in Spark."""
    if pyarrow.types.is_list(data_type):
        return f"array<{_type(data_type.value_type)}>"
    if pyarrow.types.is_struct(data_type):
        return "struct<" + ", ".join(f"{field.name}: {_type(field.type)}" for field in data_type) + ">"
    if pyarrow.types.is_timestamp(data_type):
        return "timestamp"
    return {"bool": "boolean", "double": "double", "int64": "bigint", "string": "string"}[str(data_type)]
