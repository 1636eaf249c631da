"""Adapter for the PyPI package jsonschema, with draft 2020-12."""

import json

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

from protocol import serve


def prepare(documents):
    resources = [(address, Resource.from_contents(json.loads(text))) for address, text in documents.items()]
    registry = Registry().with_resources(resources).crawl()

    def compile_schema(address):
        resolved = registry.resolver().lookup(address).contents
        Draft202012Validator.check_schema(resolved)
        validator = Draft202012Validator({"$ref": address}, registry=registry)

        def check(text):
            error = next(validator.iter_errors(json.loads(text)), None)
            return {"valid": error is None, "message": error and error.message[:300]}

        return check

    return compile_schema


serve("jsonschema", prepare)
