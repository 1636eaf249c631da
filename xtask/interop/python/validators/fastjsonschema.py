"""Adapter for fastjsonschema, which supports drafts up to 7."""

import json

import fastjsonschema

from protocol import serve


def prepare(documents):
    schemas = {address: json.loads(text) for address, text in documents.items()}

    def compile_schema(address):
        validate = fastjsonschema.compile({"$ref": address}, handlers={"https": schemas.__getitem__})

        def check(text):
            try:
                validate(json.loads(text))
            except fastjsonschema.JsonSchemaValueException as error:
                return {"valid": False, "message": error.message[:300]}
            return {"valid": True}

        return check

    return compile_schema


serve("fastjsonschema", prepare)
