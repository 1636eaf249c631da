"""The JSON Schemas and test vectors of this package."""

import json
from importlib.resources import files
from typing import Any, Literal, NotRequired, TypedDict

from ._native import __version__

_PACKAGE = files("uavspec")

__all__ = ["Manifest", "Vector", "Vectors", "bundle", "manifest", "schema", "vectors"]


class Manifest(TypedDict):
    """The names of all schemas, bundles and test vectors."""

    version: str
    """The version of the package."""

    bundles: list[str]
    """The packages with a bundle, such as `px4`."""

    schemas: list[str]
    """The messages and types with a schema, such as `px4/FailsafeFlags`."""

    vectors: list[str]
    """The messages and types with test vectors."""


_OfErrorCode = TypedDict("_OfErrorCode", {"class": NotRequired[str]})


class Vector(_OfErrorCode):
    """A test vector. Test vectors for error codes also have the key `class`."""

    id: str
    """The permanent id of the case in its file. Adding fields to the message doesn't change the id."""

    description: str
    """The description of the case."""

    valid: bool
    """True if the value violates no rule."""

    rule: NotRequired[str]
    """The id of the violated rule."""

    severity: NotRequired[str]
    """The severity of an error code."""

    json: NotRequired[Any]
    """The value as JSON."""

    decoded: NotRequired[Any]
    """The decoded value as JSON. Present only if re-encoding it produces different bytes."""

    uorb: NotRequired[str]
    """The uORB payload, hexadecimal."""

    cdr: NotRequired[str]
    """The CDR payload with its header, hexadecimal."""


class Vectors(TypedDict):
    """The test vectors of a message or type: valid and invalid values."""

    form: Literal[1]
    """The version of the file format."""

    type: str
    """The name of the message or type, such as `px4/FailsafeFlags`."""

    version: NotRequired[int]
    """The `MESSAGE_VERSION` of a PX4 message."""

    hash: NotRequired[int]
    """PX4's hash of the fields."""

    type_hash: NotRequired[str]
    """ROS's hash of the type."""

    schema: str
    """The address of the JSON Schema."""

    cases: list[Vector]


def manifest() -> Manifest:
    """Returns the names of all schemas, bundles and test vectors."""
    bundle = ".bundle.schema.json"
    schemas = (file.name for file in _PACKAGE.joinpath("schemas").iterdir())
    return {
        "version": __version__,
        "bundles": sorted(name.removesuffix(bundle) for name in schemas if name.endswith(bundle)),
        "schemas": _names("schemas", ".schema.json"),
        "vectors": _names("vectors", ".vectors.json"),
    }


def schema(name: str) -> dict[str, Any]:
    """Returns the JSON Schema of a message or type, such as `px4/FailsafeFlags`. It refers to other schemas."""
    found: dict[str, Any] = _find("schemas", name, ".schema.json")
    return found


def bundle(name: str) -> dict[str, Any]:
    """Returns one JSON Schema with all messages and types of a package, such as `px4`. It refers to no other schema."""
    found: dict[str, Any] = _find("bundles", name, ".bundle.schema.json")
    return found


def vectors(name: str) -> Vectors:
    """Returns the test vectors of a message or type, such as `px4/FailsafeFlags`."""
    found: Vectors = _find("vectors", name, ".vectors.json")
    return found


def _names(folder: str, ending: str) -> list[str]:
    """The names of the files in the folders of packages."""
    packages = [found for found in _PACKAGE.joinpath(folder).iterdir() if found.is_dir()]
    paths = ((package.name, file.name) for package in packages for file in package.iterdir())
    return sorted(f"{package}/{name.removesuffix(ending)}" for package, name in paths if name.endswith(ending))


def _find(kind: Literal["bundles", "schemas", "vectors"], name: str, ending: str) -> Any:
    if name not in manifest()[kind]:
        raise LookupError(f"{name!r} is not among the {kind}; manifest()[{kind!r}] lists them")
    folder = "schemas" if kind == "bundles" else kind
    found = _PACKAGE.joinpath(folder, *f"{name}{ending}".split("/"))
    return json.loads(found.read_text(encoding="utf-8"))
