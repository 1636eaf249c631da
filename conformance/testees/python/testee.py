#!/usr/bin/env python3
"""A testee for `uavspec test`; uses the standard library only.

    uavspec test -- python3 conformance/testees/python/testee.py
"""

import base64
import json
import sys

from codec import TYPES, Rejected, alignment, check, decode, encode, layout

EXACT = 2**53


def to_wire(value):
    """Tags integers that other JSON parsers would round."""
    if isinstance(value, dict):
        return {name: to_wire(item) for name, item in value.items()}
    if isinstance(value, list):
        return [to_wire(item) for item in value]
    if type(value) is int and abs(value) > EXACT:
        return {"$u64" if value > 0 else "$i64": str(value)}
    return value


def from_wire(value):
    if isinstance(value, list):
        return [from_wire(item) for item in value]
    if isinstance(value, dict):
        for tag, read in (("$u64", int), ("$i64", int), ("$f", float)):
            if list(value) == [tag]:
                return read(value[tag])
        return {name: from_wire(item) for name, item in value.items()}
    return value


def text(data):
    return base64.b64encode(data).decode()


def answer(request):
    try:
        message, form, op = TYPES.get(request["type"]), request.get("format"), request["op"]
        if message is None or op not in OPS or form not in FORMATS[op]:
            return {"unsupported": True}
        if op == "validate":
            check(message, from_wire(request["value"]), is_strict=True)
            return {"ok": None}
        if op == "layout":
            places, end = layout(message, form)
            return {"ok": {"size": end + -end % alignment(message), "size_no_padding": end, "offsets": places}}
        if op == "encode":
            return {"ok": text(encode(message, form, from_wire(request["value"])))}
        value = decode(message, form, base64.b64decode(request["bytes"]))
        return {"ok": to_wire(value) if op == "decode" else text(encode(message, form, value))}
    except Rejected as reason:
        return {"rejected": str(reason)}
    except Exception as error:  # noqa: BLE001 - no failure may end the process
        return {"error": repr(error)}


OPS = ["decode", "encode", "roundtrip", "validate", "layout"]
BINARY = ("uorb", "cdr")
FORMATS = {"decode": BINARY, "encode": BINARY, "roundtrip": BINARY, "validate": (None,), "layout": ("uorb",)}
HELLO = {"op": "hello", "protocol": 1, "name": "python", "version": "1", "ops": OPS, "types": list(TYPES)}

# Lines are read as bytes, so that invalid UTF-8 doesn't end the program.
for line in sys.stdin.buffer:
    try:
        request = json.loads(line)
        reply = HELLO if request.get("op") == "hello" else {"id": request["id"], **answer(request)}
    except (ValueError, AttributeError, KeyError, RecursionError):
        continue  # A line that is not a request has no id to respond to.
    # Without flushing, responses would remain in the buffer.
    print(json.dumps(reply), flush=True)
