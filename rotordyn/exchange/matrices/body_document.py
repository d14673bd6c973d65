"""The JSON that stands beside matrices whose format has no room for rows, nodes and units."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.foreign_body import (
    EQUATION,
    LARGEST_NUMBER,
    ROLES,
    ForeignBody,
    file_bytes,
    node_numbers,
    refuse_large,
    rows_of,
)
from solidwhirl.rotordyn.superelement.record import Superelement

FORMAT = "solidwhirl-matrices-1"
_MOST_BYTES = 20_000_000
_MOST_NODES = 100_000
_LARGEST_WHOLE = 10**12
_LONGEST_NAME = 200


def body_document(
    element: Superelement, matrices: Mapping[str, str], speed_rad_s: float | None
) -> dict[str, Any]:
    """Describe the matrices of a superelement.

    `matrices`: name or file of each matrix, by role.
    """
    top = element.maximum_speed_rad_s
    coordinates = []
    for row, coordinate in zip(rows_of(element), element.coordinates, strict=True):
        entry: dict[str, Any] = {"node": row.node if row.component else 0}
        entry["component"] = row.component
        if not row.component:
            entry["frequency_hz"] = coordinate.frequency_hz
        coordinates.append(entry)
    numbers = node_numbers(element)
    return {
        "format": FORMAT,
        "name": element.name,
        "length_unit": "m",
        "mass_unit": "kg",
        "time_unit": "s",
        "frame": "inertial",
        "spin_axis": [0.0, 0.0, 1.0],
        "equation": EQUATION,
        "matrices": {
            role: {"name": name, "multiplies": ROLES[role].multiplies}
            for role, name in matrices.items()
        },
        "speed_rad_s": speed_rad_s,
        "maximum_speed_rad_s": float(top) if np.isfinite(top) else None,
        "nodes": [
            {"id": numbers[n.name], "name": n.name, "position": n.position_m.tolist()}
            for n in element.interfaces
        ],
        "coordinates": coordinates,
        "mass": element.mass_kg,
        "center_of_gravity": element.center_of_gravity_m.tolist(),
        "inertia": element.inertia_kg_m2.tolist(),
    }


def write_document(path: Path, document: Mapping[str, Any]) -> None:
    """Write a document as JSON, lists of numbers on one line."""
    lines = []
    for key, value in document.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n".join(f"  {json.dumps(v, allow_nan=False)}" for v in value)
            lines.append(f" {json.dumps(key)}: [\n{rows}\n ]")
        else:
            lines.append(f" {json.dumps(key)}: {json.dumps(value, allow_nan=False)}")
    with replacing(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


class Document:
    """Read the document of a body, naming file and key in each error."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            content = json.loads(file_bytes(path, _MOST_BYTES))
        except SuperelementError:
            raise
        except (RecursionError, ValueError) as error:
            raise SuperelementError(f"{path}: is not JSON: {error}") from error
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            found = content.get("format") if isinstance(content, dict) else None
            raise SuperelementError(
                f"{path}: format is {str(found)[:60]!r}, allowed is {FORMAT!r}; docs/import.md has "
                "what such a file holds"
            )
        self.content: dict[str, Any] = content
        frame = content.get("frame", "inertial")
        if frame != "inertial":
            raise self.error("frame", f"is {str(frame)[:60]!r}, allowed is 'inertial'")
        if content.get("spin_axis", [0, 0, 1]) != [0, 0, 1]:
            raise self.error("spin_axis", "allowed is [0, 0, 1]")

    def error(self, key: str, said: str) -> SuperelementError:
        """Return an error at a key."""
        return SuperelementError(f"{self.path}: {key}: {said}")

    def matrix_names(self) -> dict[str, str]:
        """Names or files of the matrices by role; unknown roles stay as they are."""
        found = self.content.get("matrices", {})
        if not isinstance(found, dict):
            raise self.error("matrices", "allowed is a table from role to name")
        out = {}
        for role, entry in found.items():
            name = entry.get("name") if isinstance(entry, dict) else entry
            if not isinstance(name, str) or not 0 < len(name) <= _LONGEST_NAME:
                raise self.error(f"matrices.{role[:60]}", f"needs a name, found {str(name)[:60]!r}")
            out[role] = name
        return out

    def body(self, files: tuple[Path, ...], matrices: Mapping[str, FloatArray]) -> ForeignBody:
        """Return the body with its matrices, whose rows must be the coordinates."""
        positions, names = self._nodes()
        nodes, components = self._rows(positions)
        for name, matrix in matrices.items():
            if len(matrix) != len(nodes):
                raise SuperelementError(
                    f"{files[0]}: matrix {name} has {len(matrix)} rows, {self.path.name} has "
                    f"{len(nodes)} coordinates"
                )
        top = self.content.get("maximum_speed_rad_s")
        limit = np.inf if top is None else float(self._numbers("maximum_speed_rad_s", top, ()))
        return ForeignBody(
            files=files,
            matrices=matrices,
            nodes=nodes,
            components=components,
            positions=positions,
            names=names,
            length_unit=self._word("length_unit"),
            mass_unit=self._word("mass_unit"),
            properties=self._properties(),
            maximum_speed_rad_s=limit,
        )

    def _nodes(self) -> tuple[dict[int, FloatArray], dict[int, str]]:
        """Places and names of the nodes by number."""
        found = self._list("nodes", _MOST_NODES)
        positions: dict[int, FloatArray] = {}
        names: dict[int, str] = {}
        for k, entry in enumerate(found):
            place = f"nodes[{k}]"
            if not isinstance(entry, dict):
                raise self.error(place, "needs id and position")
            number = self._whole(f"{place}.id", entry.get("id"), 1)
            if number in positions:
                raise self.error(f"{place}.id", f"{number} occurs more than once")
            positions[number] = self._numbers(f"{place}.position", entry.get("position"), (3,))
            name = entry.get("name")
            if name is not None:
                if not isinstance(name, str) or not name.isprintable() or not name:
                    raise self.error(f"{place}.name", f"found {str(name)[:60]!r}, a text is needed")
                names[number] = name
        return positions, names

    def _rows(self, positions: Mapping[int, FloatArray]) -> tuple[Any, Any]:
        """Nodes and components of the coordinates."""
        found = self._list("coordinates", None)
        refuse_large(self.path, len(found))
        nodes, components = np.zeros((2, len(found)), dtype=np.int64)
        for k, entry in enumerate(found):
            place = f"coordinates[{k}]"
            if not isinstance(entry, dict):
                raise self.error(place, "needs node and component")
            components[k] = self._whole(f"{place}.component", entry.get("component"), 0, 6)
            nodes[k] = self._whole(f"{place}.node", entry.get("node", 0), 0)
            if components[k] and int(nodes[k]) not in positions:
                raise self.error(f"{place}.node", f"{nodes[k]} is not among the nodes")
        return nodes, components

    def _properties(self) -> dict[str, FloatArray]:
        shapes = {"mass": (), "center_of_gravity": (3,), "inertia": (3, 3)}
        given = {key: shape for key, shape in shapes.items() if self.content.get(key) is not None}
        return {k: self._numbers(k, self.content[k], shape) for k, shape in given.items()}

    def _word(self, key: str) -> str | None:
        found = self.content.get(key)
        return None if found is None else str(found)[:_LONGEST_NAME]

    def _list(self, key: str, most: int | None) -> list[Any]:
        found = self.content.get(key)
        if not isinstance(found, list) or not found:
            raise self.error(key, "a list that is not empty is needed")
        if most is not None and len(found) > most:
            raise self.error(key, f"has {len(found)} entries, at most {most} are allowed")
        return found

    def _whole(self, key: str, value: Any, least: int, most: int = _LARGEST_WHOLE) -> int:
        """A whole number in a range."""
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            text = str(value)[:60]
            raise self.error(key, f"is {text}; whole numbers from {least} to {most} are allowed")
        return value

    def _numbers(self, key: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
        """Finite numbers of a shape."""
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            array = np.array([np.nan])
        if (
            isinstance(value, str)
            or array.shape != shape
            or not (np.abs(array) <= LARGEST_NUMBER).all()
        ):
            raise self.error(
                key, f"is {str(value)[:60]}; finite numbers of shape {shape} are allowed"
            )
        return array
