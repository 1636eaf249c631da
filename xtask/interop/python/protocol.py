"""Shared code of the Python adapters. They read jobs, and write one JSON line for each schema and case.

See xtask/interop/README.md.
"""

import json
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

Check = Callable[[str], dict]
"""Checks the text of a case."""

Compile = Callable[[str], Check]
"""Compiles the schema with this URL, or raises an error."""


def serve(name: str, prepare: Callable[[dict[str, str]], Compile]) -> None:
    """Runs all jobs in the file given on the command line.

    `name` is the tested package, whose version is written. `prepare` receives the texts of all documents by URL.
    """
    documents, jobs = read_jobs()
    write({"version": version(name)})
    compile_schema = prepare(documents)
    for job in jobs:
        run(job, compile_schema)


def read_jobs() -> tuple[dict[str, str], list[dict]]:
    """Reads the texts of all documents by URL, and all jobs."""
    with open(sys.argv[1], encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    documents = {
        line["document"]: Path(line["path"]).read_text(encoding="utf-8") for line in lines if "document" in line
    }
    return documents, [line for line in lines if "schema" in line]


def run(job: dict, compile_schema: Compile) -> None:
    """Writes the results of one schema and its cases."""
    try:
        check = compile_schema(job["schema"])
    except Exception as error:  # an error is a result
        write({"job": job["job"], "error": brief(error)})
        return
    write({"job": job["job"]})
    for index, text in enumerate(job["cases"]):
        try:
            verdict = check(text)
        except Exception as error:
            verdict = {"error": brief(error)}
        write({"job": job["job"], "case": index, **verdict})


def brief(error: Exception) -> str:
    """Formats an error as a short text."""
    return f"{type(error).__name__}: {error}"[:300]


def write(line: dict) -> None:
    """Flushes the line, so that verdicts before a crash are preserved."""
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()
