"""The JSON that stands beside matrices whose format has no room for rows, nodes and units."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import ForeignError, json_data
from solidwhirl.rotordyn.exchange.matrices import foreign_body as foreign
from solidwhirl.rotordyn.exchange.matrices.body_fields import BodyFields
from solidwhirl.rotordyn.superelement.record import Superelement

FORMAT = "solidwhirl-matrices-1"
_MOST_BYTES = 20_000_000
_LONGEST_NAME = 200


def body_document(
    element: Superelement, matrices: Mapping[str, str], speed_rad_s: float | None
) -> dict[str, Any]:
    """Describe the matrices of a superelement; `matrices`: name or file of each by role."""
    top = element.maximum_speed_rad_s
    coordinates = []
    for row, coordinate in zip(foreign.rows_of(element), element.coordinates, strict=True):
        entry: dict[str, Any] = {"node": row.node if row.component else 0}
        entry["component"] = row.component
        if not row.component:
            entry["frequency_hz"] = coordinate.frequency_hz
        coordinates.append(entry)
    numbers = foreign.node_numbers(element)
    return {
        "format": FORMAT,
        "name": element.name,
        "length_unit": "m",
        "mass_unit": "kg",
        "time_unit": "s",
        "frame": "inertial",
        "spin_axis": [0.0, 0.0, 1.0],
        "equation": foreign.EQUATION,
        "matrices": {
            role: {"name": name, "multiplies": foreign.ROLES[role].multiplies}
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
    replace_text(path, "{\n" + ",\n".join(lines) + "\n}\n")


class Document(BodyFields):
    """Read the document of a body, naming file and key in each error."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        try:
            content = json_data(foreign.file_bytes(path, _MOST_BYTES))
        except ForeignError as error:
            raise SuperelementError(f"{path}: {error}") from error
        found = content.get("format") if isinstance(content, dict) else None
        if found != FORMAT:
            raise SuperelementError(
                f"{path}: format is {str(found)[:60]!r}, allowed is {FORMAT!r}; docs/import.md has "
                "what such a file holds"
            )
        self._content: dict[str, Any] = content
        if content.get("spin_axis", [0, 0, 1]) != [0, 0, 1]:
            raise self.error("spin_axis", "allowed is [0, 0, 1]")

    def label(self, name: str) -> str:
        """Return where a field stands in the document."""
        table, key, _ = _COLUMNS.get(name, (name, "", None))
        return f"{table}{'.' if key else ''}{key}:"

    def raw(self, name: str) -> Any:
        """Return what stands at a key, or a column of one of the two tables."""
        if name not in _COLUMNS:
            return self._content.get(name)
        table, key, default = _COLUMNS[name]
        found = self._content.get(table)
        if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
            raise self.error(table, "a list of tables is needed")
        return [entry.get(key, default) for entry in found]

    def matrix_names(self) -> dict[str, str]:
        """Names or files of the matrices by role; unknown roles stay as they are."""
        found = self._content.get("matrices", {})
        if not isinstance(found, dict):
            raise self.error("matrices", "allowed is a table from role to name")
        out = {}
        for role, entry in found.items():
            name = entry.get("name") if isinstance(entry, dict) else entry
            if not isinstance(name, str) or not 0 < len(name) <= _LONGEST_NAME:
                raise self.error(f"matrices.{role[:60]}", f"needs a name, found {str(name)[:60]!r}")
            out[role] = name
        return out


# Columns of the tables: where they are, and what stands for one that is not given.
_COLUMNS = {
    "dof_node": ("coordinates", "node", 0),
    "dof_component": ("coordinates", "component", None),
    "node_id": ("nodes", "id", None),
    "node_position": ("nodes", "position", None),
    "node_name": ("nodes", "name", ""),
}
