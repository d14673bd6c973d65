"""Names of a package that are imported when they are first asked for."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def imported_later(package: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package that imports its names when they are asked for.

    The package imports them below `if TYPE_CHECKING:`, which is read here, so that each place is
    written down once; `__all__` lists them.
    """
    module = sys.modules[package]

    @cache
    def places() -> dict[str, str]:
        tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
        below = next(node.body for node in tree.body if isinstance(node, ast.If))
        imports = (node for node in below if isinstance(node, ast.ImportFrom))
        return {alias.name: str(node.module) for node in imports for alias in node.names}

    def get(name: str) -> Any:
        if name not in module.__all__:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        found = getattr(import_module(places()[name]), name)
        setattr(module, name, found)
        return found

    return get
