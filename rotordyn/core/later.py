"""Names of a package that are imported when they are first asked for."""

from __future__ import annotations

import ast
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    """A package that imports its names when they are asked for."""

    _places: dict[str, str]

    def __getattr__(self, name: str) -> Any:
        if name not in self._places:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        found = getattr(import_module(self._places[name]), name)
        super().__setattr__(name, found)
        return found

    def __setattr__(self, name: str, value: Any) -> None:
        # `campbell` stays the function, whoever imports the modules of its name below
        if not (name in self._places and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*vars(self), *self._places})


def import_later(package: str) -> None:
    """Let a package import its names when they are asked for.

    The package imports them below `if TYPE_CHECKING:`, which is read here, so that the place of
    each is written down once.
    """
    module = sys.modules[package]
    tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
    below = next(node.body for node in tree.body if isinstance(node, ast.If))
    imports = (node for node in below if isinstance(node, ast.ImportFrom))
    places = {alias.name: str(node.module) for node in imports for alias in node.names}
    vars(module)["_places"] = places
    module.__class__ = _Package
