"""What all adapters of Python share: they read the jobs, and write a line of JSON for each schema and each case.

xtask/interop/README.md describes both.
"""

import json
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

Judge = Callable[[str], dict]
"""Judges the text of a case."""

Compile = Callable[[str], Judge]
"""Compiles the schema of an address, or raises an error."""


def serve(name: str, prepare: Callable[[dict[str, str]], Compile]) -> None:
    """Runs all jobs of the file that the command line names.

    `name` is the package that does the work, whose version is written. `prepare` takes the texts of all documents by
    their address.
    """
    documents, jobs = read_jobs()
    write({"version": version(name)})
    compile_schema = prepare(documents)
    for job in jobs:
        run(job, compile_schema)


def read_jobs() -> tuple[dict[str, str], list[dict]]:
    """The texts of all documents by their address, and all jobs."""
    with open(sys.argv[1], encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    documents = {
        line["document"]: Path(line["path"]).read_text(encoding="utf-8") for line in lines if "document" in line
    }
    return documents, [line for line in lines if "schema" in line]


def run(job: dict, compile_schema: Compile) -> None:
    """Writes what comes of one schema and its cases."""
    try:
        judge = compile_schema(job["schema"])
    except Exception as error:  # whatever a tool raises is its result
        write({"job": job["job"], "error": brief(error)})
        return
    write({"job": job["job"]})
    for index, text in enumerate(job["cases"]):
        try:
            verdict = judge(text)
        except Exception as error:
            verdict = {"error": brief(error)}
        write({"job": job["job"], "case": index, **verdict})


def brief(error: Exception) -> str:
    """An error as a short text."""
    return f"{type(error).__name__}: {error}"[:300]


def write(line: dict) -> None:
    """Writes at once, so that what was judged before a crash is known."""
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()
