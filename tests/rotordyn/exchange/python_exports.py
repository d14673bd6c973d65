"""Checks that hold for every export as a Python file, and bodies to export."""

from __future__ import annotations

import ast
import dataclasses
import importlib.util

import numpy as np

from solidwhirl.rotordyn import Bearing, End, Rotor, assemble

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


def with_hostile_names(element):
    """The body under a hostile name, with its first interface renamed likewise."""
    first = element.interfaces[0].name
    rename = lambda name: HOSTILE if name == first else name  # noqa: E731
    return dataclasses.replace(
        element,
        name=HOSTILE,
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


def on_springs(element, springs, ratio=1.0):
    """System of the body on springs: {interface: number, two numbers or (2, 2) in N/m}."""
    bearings = tuple(
        Bearing(
            name=f"at {name}",
            first=End(body="r", interface=name),
            stiffness_n_per_m=np.asarray(k, float)
            if np.ndim(k) == 2
            else np.diag(np.broadcast_to(k, 2)).astype(float),
        )
        for name, k in springs.items()
    )
    return assemble({"r": Rotor(element=element, speed_ratio=ratio)}, bearings)
