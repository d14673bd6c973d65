"""What a file says of a body beside its matrices: rows, nodes, units; checked for all formats."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.foreign_body import (
    LARGEST_NUMBER,
    ForeignBody,
    refuse_large,
)
from solidwhirl.rotordyn.superelement.validation import finite_array

_MOST_NODES = 100_000
_LARGEST_WHOLE = 10**12
_LONGEST_NAME = 200


class BodyFields:
    """Fields of a file by their names in the .npz format, each checked when it is asked for."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def raw(self, name: str) -> Any:
        """Return an array, a list, a number or a text as the file has it; None if it has none."""
        raise NotImplementedError

    def label(self, name: str) -> str:
        """Return how a message calls a field."""
        raise NotImplementedError

    def error(self, name: str, said: str) -> SuperelementError:
        """Return an error that names file and field."""
        return SuperelementError(f"{self.path}: {self.label(name)} {said}")

    def needed(self, name: str) -> Any:
        """Return a field that a file must have."""
        found = self.raw(name)
        if found is None:
            raise self.error(name, "is missing")
        return found

    def numbers(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        """Return finite numbers of a shape, None for any length."""
        value = self.needed(name)
        try:
            kind = np.asarray(value).dtype.kind
        except ValueError:  # lists of different lengths
            kind = "O"
        if kind not in "fiu":
            raise self.error(name, f"is {str(value)[:60]}; numbers are needed")
        array = finite_array(str(self.path), self.label(name), value, shape)
        if np.abs(array).max(initial=0.0) > LARGEST_NUMBER:
            raise self.error(name, f"has numbers beyond {LARGEST_NUMBER:g}")
        return array

    def wholes(
        self, name: str, least: int, most: int = _LARGEST_WHOLE, count: int | None = None
    ) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Return a list of whole numbers in a range, of a length if `count` is given."""
        value = self.needed(name)
        values = value.tolist() if isinstance(value, np.ndarray) else value
        if not isinstance(values, list) or (count is not None and len(values) != count):
            what = "any length" if count is None else f"the length {count}"
            raise self.error(name, f"is no list of {what}")
        for k, number in enumerate(values):
            # neither True nor 1.0
            if type(number) is not int or not least <= number <= most:
                raise self.error(
                    name,
                    f"has {str(number)[:60]} at [{k}]; whole numbers from {least} to {most} are "
                    "allowed",
                )
        return np.array(values, dtype=np.int64)

    def text(self, name: str) -> str | None:
        """Return a short text, None if there is none."""
        found = self.raw(name)
        return None if found is None else str(found)[:_LONGEST_NAME]


def body_of(
    fields: BodyFields, files: tuple[Path, ...], matrices: Mapping[str, FloatArray]
) -> ForeignBody:
    """Return the body of matrices whose rows are the coordinates of a file, or refuse it."""
    if fields.text("frame") not in (None, "inertial"):
        raise fields.error("frame", f"is {str(fields.text('frame'))[:60]!r}, allowed is 'inertial'")
    refuse_large(fields.path, np.shape(fields.needed("dof_node"))[0])
    nodes = fields.wholes("dof_node", 0)
    components = fields.wholes("dof_component", 0, 6, nodes.size)
    ids = fields.wholes("node_id", 1).tolist()
    if len(ids) > _MOST_NODES or len(set(ids)) < len(ids):
        raise fields.error("node_id", f"needs at most {_MOST_NODES} numbers, all different")
    places = fields.numbers("node_position", (len(ids), 3))
    unknown = set(nodes[components > 0].tolist()) - set(ids)
    if unknown:
        raise fields.error("dof_node", f"has {min(unknown)}, which is no node")
    for name, matrix in matrices.items():
        if len(matrix) != nodes.size:
            raise SuperelementError(
                f"{files[0]}: matrix {name} has {len(matrix)} rows, {fields.path.name} has "
                f"{nodes.size} coordinates"
            )
    points, modes = np.zeros((0, 3)), None
    if fields.raw("recovery_position") is not None:
        points = fields.numbers("recovery_position", (None, 3))
        modes = fields.numbers("recovery_modes", (len(points), 3, nodes.size))
    shapes = {"mass": (), "center_of_gravity": (3,), "inertia": (3, 3)}
    return ForeignBody(
        files=files,
        matrices=matrices,
        nodes=nodes,
        components=components,
        positions=dict(zip(ids, places, strict=True)),
        names=_names(fields, ids),
        length_unit=fields.text("length_unit"),
        mass_unit=fields.text("mass_unit"),
        properties={
            k: fields.numbers(k, s) for k, s in shapes.items() if fields.raw(k) is not None
        },
        maximum_speed_rad_s=_maximum_speed(fields),
        points=points,
        point_modes=modes,
    )


def _names(fields: BodyFields, ids: list[int]) -> dict[int, str]:
    found = fields.raw("node_name")
    names = np.asarray([""] * len(ids) if found is None else found).tolist()
    if not isinstance(names, list) or len(names) != len(ids):
        raise fields.error("node_name", f"needs {len(ids)} texts")
    for name in names:
        plain = isinstance(name, str) and (name.isprintable() or not name)
        if not plain or len(name) > _LONGEST_NAME:
            raise fields.error("node_name", f"has {str(name)[:60]!r}, which is no name")
    return {number: name for number, name in zip(ids, names, strict=True) if name}


def _maximum_speed(fields: BodyFields) -> float:
    found = fields.raw("maximum_speed_rad_s")
    if found is None:
        return float("inf")
    array = np.asarray(found)
    value = float(array) if array.shape == () and array.dtype.kind in "fiu" else float("nan")
    if not value >= 0:
        raise fields.error("maximum_speed_rad_s", f"is {str(found)[:60]}; 0 or more")
    return value
