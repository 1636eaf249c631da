"""Checks captures with Ray Data.

    captures = ray.data.from_arrow(pyarrow.table(uavspec.find("s3://flights/2026/")))
    uavspec.ray.write(captures, "s3://results/2026")

The workers open the captures and require this package.
"""

from functools import partial
from typing import Unpack

import pyarrow
from pyarrow.fs import FileSystem, FileType, LocalFileSystem
from pyarrow.parquet import write_table
from ray.data import Dataset

from .batches import KEYS, MAX_CAPTURES, Options, check_batches, schema

__all__ = ["check", "table", "write"]


def check(captures: Dataset, **options: Unpack[Options]) -> Dataset:
    """Checks captures. The result has a column for each table, which `table` turns into rows.

    Args:
        captures: paths or URLs in the column `capture`. If there is a column `content`, `capture` is only its name.
        options: those of `uavspec.check_files`. `jobs` is the number of threads of a task, by default 1.
    """
    options.setdefault("jobs", 1)
    schema(options)
    blocks = captures.repartition(target_num_rows_per_block=MAX_CAPTURES)
    return blocks.map_batches(partial(_check, options=options), batch_size=None, batch_format="pyarrow")


def table(checked: Dataset, name: str) -> Dataset:
    """The rows of a table, such as `findings`, in the result of `check`. Each block is sorted like a file of uavspec."""
    return checked.map_batches(partial(_rows, name=name), batch_size=None, batch_format="pyarrow")


def write(captures: Dataset, folder: str, **options: Unpack[Options]) -> None:
    """Checks captures, and writes a folder with Parquet files for each table. The folder must be new.

    The arguments are those of `check`.
    """
    tables = schema(options)
    filesystem, root = FileSystem.from_uri(folder) if "://" in folder else (LocalFileSystem(), folder)
    for file in filesystem.get_file_info([f"{root}/{name}" for name in tables.names]):
        if file.type != FileType.NotFound:
            raise FileExistsError(f"{file.path} already exists")
    checked = check(captures, **options).materialize()
    for column in tables:
        rows = table(checked, column.name).materialize()
        if rows.count() > 0:
            rows.write_parquet(f"{folder}/{column.name}")
        else:
            # Ray writes no file without rows.
            filesystem.create_dir(f"{root}/{column.name}")
            no_rows = pyarrow.schema(column.type.value_type).empty_table()
            write_table(no_rows, f"{root}/{column.name}/data-0.parquet", filesystem=filesystem)
    # As Spark does. `uavspec check --resume` continues complete tables only.
    filesystem.open_output_stream(f"{root}/captures/_SUCCESS").close()


def _check(batch: pyarrow.Table, options: Options) -> pyarrow.Table:
    return pyarrow.Table.from_batches(check_batches(batch.combine_chunks().to_batches(), options))


def _rows(checked: pyarrow.Table, name: str) -> pyarrow.Table:
    rows = pyarrow.Table.from_struct_array(checked[name].combine_chunks().flatten())
    return rows.sort_by([(key, "ascending") for key in KEYS[name]])
