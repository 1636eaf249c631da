"""Imports every module below the current folder, and resolves every name in the types that it declares."""

import importlib
import pathlib
import typing

for path in sorted(pathlib.Path(".").rglob("*.py")):
    parts = [part for part in path.with_suffix("").parts if part != "__init__"]
    module = importlib.import_module(".".join(parts))
    for name in getattr(module, "__all__", []):
        found = getattr(module, name)
        if typing.is_typeddict(found):
            hints = typing.get_type_hints(found, include_extras=True)
            optional = {key for key, hint in hints.items() if typing.get_origin(hint) is typing.NotRequired}
            assert optional == found.__optional_keys__, (name, optional)
            print(module.__name__, name)
