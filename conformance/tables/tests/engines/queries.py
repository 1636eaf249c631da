"""Runs the queries of a page of the guide with several engines: queries.py PAGE TABLES

TABLES is the folder of the tables. Prints a line for each query and engine. All engines must return the same rows.
"""

import os
import re
import sys
import tempfile

import datafusion
import duckdb

PAGE, TABLES = sys.argv[1:3]
NAMES = sorted(os.listdir(TABLES))

with open(PAGE, encoding="utf-8") as file:
    text = file.read()
queries = re.findall(r"```sql\n(.*?)```", text, re.DOTALL)
setup, frames = re.findall(r"```python\n(.*?)```", text, re.DOTALL)


def rows(table):
    """The rows of an Arrow table, as comparable text."""
    columns = table.to_pydict()
    return [tuple(map(str, row)) for row in zip(*columns.values())]


# The programs of the guide name the folder `tables`.
os.chdir(tempfile.mkdtemp())
os.symlink(TABLES, "tables")
exec(setup)
context = datafusion.SessionContext()
for name in NAMES:
    context.register_parquet(name, f"{TABLES}/{name}/")
first = None
for number, query in enumerate(queries, 1):
    expected = rows(duckdb.sql(query).arrow().read_all())
    print(f"query {number}: DuckDB, {len(expected)} rows")
    found = rows(context.sql(query).to_arrow_table())
    print(f"query {number}: DataFusion, {len(found)} rows")
    assert found == expected, f"{query}\nDuckDB: {expected}\nDataFusion: {found}"
    assert expected, f"no rows: {query}"
    first = first or expected
variables = {}
exec(frames, variables)
found = rows(variables["result"].to_arrow())
print(f"query 1: Polars, {len(found)} rows")
assert sorted(found) == sorted(first), f"DuckDB: {first}\nPolars: {found}"
