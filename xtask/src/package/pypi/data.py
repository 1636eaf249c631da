"""The JSON Schemas and test vectors that come with this package."""

import json
import sys
from importlib.resources import files
from typing import Any, Literal

if sys.version_info >= (3, 11):
    from typing import NotRequired, TypedDict
else:
    from typing_extensions import NotRequired, TypedDict

__all__ = ["Manifest", "Vector", "Vectors", "bundle", "manifest", "schema", "vectors"]


class Manifest(TypedDict):
    """The names of all that there is."""

    version: str
    """The version of the package."""

    bundles: list[str]
    """The packages that there is a bundle of, such as `px4`."""

    schemas: list[str]
    """The messages and types that there is a schema of, such as `px4/FailsafeFlags`."""

    vectors: list[str]
    """The messages and types that there are test vectors of."""


_OfErrorCode = TypedDict("_OfErrorCode", {"class": NotRequired[str]})


class Vector(_OfErrorCode):
    """A test vector. That of an error code has its `class`, too."""

    id: str
    """Names the case within its file. It stays when fields are added."""

    description: str
    """What is tried, in words."""

    valid: bool
    """Whether no rule is broken."""

    rule: NotRequired[str]
    """The id of the rule that is broken."""

    severity: NotRequired[str]
    """The severity of an error code."""

    json: NotRequired[Any]
    """The value as JSON."""

    decoded: NotRequired[Any]
    """What the bytes decode to, where no writer writes such bytes."""

    uorb: NotRequired[str]
    """The payload of uORB, in hexadecimal."""

    cdr: NotRequired[str]
    """The payload in CDR with its header, in hexadecimal."""


class Vectors(TypedDict):
    """Test vectors of a message or type: values that it has and values that it doesn't have."""

    form: Literal[1]
    """The version of this form."""

    type: str
    """The message or type, after its package."""

    version: NotRequired[int]
    """The message's version, as PX4 counts it."""

    hash: NotRequired[int]
    """PX4's hash of the fields."""

    type_hash: NotRequired[str]
    """ROS's hash of the type."""

    schema: str
    """The address of the JSON Schema."""

    cases: list[Vector]


def manifest() -> Manifest:
    """The names of all schemas, bundles and vectors."""
    found: Manifest = _read("manifest.json")
    return found


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of a message or type, such as `px4/FailsafeFlags`. It refers to others beside it."""
    found: dict[str, Any] = _find("schemas", name, ".schema.json")
    return found


def bundle(name: str) -> dict[str, Any]:
    """The JSON Schemas of a package, such as `px4`, as one that needs no other."""
    found: dict[str, Any] = _find("bundles", name, ".bundle.schema.json")
    return found


def vectors(name: str) -> Vectors:
    """The test vectors of a message or type, such as `px4/FailsafeFlags`."""
    found: Vectors = _find("vectors", name, ".vectors.json")
    return found


def _find(kind: Literal["bundles", "schemas", "vectors"], name: str, ending: str) -> Any:
    if name not in manifest()[kind]:
        raise LookupError(f"{name!r} is not among the {kind}; manifest()[{kind!r}] lists them")
    folder = "schemas" if kind == "bundles" else kind
    return _read(f"{folder}/{name}{ending}")


def _read(path: str) -> Any:
    found = files(__package__).joinpath(*path.split("/"))
    return json.loads(found.read_text(encoding="utf-8"))
