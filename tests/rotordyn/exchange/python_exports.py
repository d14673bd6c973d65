"""Checks that hold for every export as a Python file, and bodies to export."""

from __future__ import annotations

import ast
import dataclasses
import importlib.util

# Printable, as names must be; ends literals and docstrings, fills placeholders, is not ASCII.
HOSTILE = "ä'\"\"\"; @BODY@ {0} %s \\n import pathlib; pathlib.Path('harm').touch() #="
# Lines of a file that is read before it is used.
LONGEST = 185


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


def check_text(path):
    """Short, commented, ASCII, and without this project."""
    text = path.read_text(encoding="ascii")
    imported = [
        name.split(".")[0]
        for node in ast.walk(ast.parse(text))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    ]
    assert imported and "solidwhirl" not in imported
    assert len(text.splitlines()) < LONGEST
    assert max(map(len, text.splitlines())) <= 100
    functions = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.col_offset == 0
    ]
    assert all(ast.get_docstring(node) or node.name == "main" for node in functions)
