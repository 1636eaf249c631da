"""Adapter for datamodel-code-generator: the generated models for pydantic 2 validate each case."""

import importlib
import json
import shutil
import sys
from pathlib import Path

from datamodel_code_generator import DataModelType, Formatter, InputFileType, generate
from pydantic import TypeAdapter, ValidationError

from protocol import read_jobs, serve

WORK = Path(sys.argv[2]).resolve()


def prepare(documents):
    """Generates one module for each form and package of schemas. Its model has one field for each job."""
    _, jobs = read_jobs()
    groups = {}
    for job in jobs:
        address, _, pointer = job["schema"].partition("#")
        groups.setdefault(address if pointer else address.rpartition("/")[0], []).append(job)
    sys.path.insert(0, str(WORK))
    types = {}
    for number, group in enumerate(groups.values()):
        try:
            found = models(f"models{number}", group, documents)
        except Exception as error:  # the result for all schemas of the group
            found = dict.fromkeys((job["schema"] for job in group), error)
        types.update(found)

    def compile_schema(address):
        found = types[address]
        if isinstance(found, Exception):
            raise found
        adapter = TypeAdapter(found)

        def check(text):
            try:
                adapter.validate_json(text)
            except ValidationError as error:
                return {"valid": False, "message": str(error.errors()[0]["msg"])[:300]}
            return {"valid": True}

        return check

    return compile_schema


def models(name, jobs, documents):
    """Generates the type of each schema."""
    folder = WORK / f"{name}-schemas"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.rmtree(WORK / name, ignore_errors=True)
    (WORK / f"{name}.py").unlink(missing_ok=True)
    folder.mkdir(parents=True)
    address, _, pointer = jobs[0]["schema"].partition("#")
    if pointer:
        root = {"$defs": json.loads(documents[address])["$defs"]}
        references = [f"#{job['schema'].partition('#')[2]}" for job in jobs]
    else:
        root = {}
        references = [job["schema"].rpartition("/")[2] for job in jobs]
        for other, text in documents.items():
            if other.rpartition("/")[0] == address.rpartition("/")[0]:
                (folder / other.rpartition("/")[2]).write_text(text, encoding="utf-8")
    names = [f"job{job['job']}" for job in jobs]
    properties = {name: {"$ref": reference} for name, reference in zip(names, references)}
    root |= {"title": "Jobs", "type": "object", "properties": properties, "required": names}
    wrapper = folder / "jobs.json"
    wrapper.write_text(json.dumps(root), encoding="utf-8")
    generate(
        wrapper,
        input_file_type=InputFileType.JsonSchema,
        output=WORK / name,
        output_model_type=DataModelType.PydanticV2BaseModel,
        formatters=[Formatter.BUILTIN],
    )
    if (WORK / name).is_file():
        (WORK / name).rename(WORK / f"{name}.py")
    found = importlib.import_module(name).Jobs
    found.model_rebuild()
    return {job["schema"]: found.model_fields[f"job{job['job']}"].annotation for job in jobs}


serve("datamodel-code-generator", prepare)
