"""Adapter for jsonschema-rs, the Python bindings of the Rust crate jsonschema."""

import json

import jsonschema_rs

from protocol import serve


def prepare(documents):
    registry = jsonschema_rs.Registry([(address, json.loads(text)) for address, text in documents.items()])

    def compile_schema(address):
        validator = jsonschema_rs.Draft202012Validator({"$ref": address}, registry=registry)

        def check(text):
            error = next(validator.iter_errors(json.loads(text)), None)
            return {"valid": error is None, "message": error and error.message[:300]}

        return check

    return compile_schema


serve("jsonschema-rs", prepare)
