"""What the tests of all exports as Python files share."""

from __future__ import annotations

import ast
import dataclasses
import importlib.util

# Printable, as names must be; ends literals and docstrings, fills placeholders, is not ASCII.
HOSTILE = "ä'\"\"\"; @BODY@ {0} %s \\n import pathlib; pathlib.Path('harm').touch() #="


def module_of(path):
    """The written file, imported."""
    spec = importlib.util.spec_from_file_location(f"written_{abs(hash(path))}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def with_names(element, new):
    """The body under another name, with its first interface renamed likewise."""
    first = element.interfaces[0].name
    rename = lambda name: new if name == first else name  # noqa: E731
    return dataclasses.replace(
        element,
        name=new,
        interfaces=tuple(
            dataclasses.replace(node, name=rename(node.name)) for node in element.interfaces
        ),
        coordinates=tuple(
            dataclasses.replace(c, interface=rename(c.interface)) for c in element.coordinates
        ),
    )


def code_of(path):
    """What Python makes of the file, without comments."""
    return ast.dump(ast.parse(path.read_text(encoding="ascii")))
