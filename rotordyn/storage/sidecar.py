"""What a superelement file holds, as a document that people read and programs need not."""

from __future__ import annotations

from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement.families import free_frequencies_by_family
from solidwhirl.rotordyn.superelement.record import Coordinate, Superelement

# Free frequencies of each family that are listed.
_MOST_FREE = 10


def superelement_document(element: Superelement) -> dict[str, Any]:
    """Describe a superelement without its matrices, ready for `json.dumps`; units in the keys."""
    top = element.maximum_speed_rad_s
    free = free_frequencies_by_family(element)
    return {
        "name": element.name,
        "level": element.level,
        "harmonics": list(element.harmonics),
        "cyclic_sectors": element.cyclic_sectors,
        "unit_system": "SI",
        "frame": element.frame,
        "spin_axis": [0.0, 0.0, 1.0],
        "equation": "M q'' + W G q' + (K0 + W^2 (Kgeo + Kspin) + W' Keul) q = f, W in rad/s",
        "coordinates": [_coordinate(k, c) for k, c in enumerate(element.coordinates)],
        "interfaces": [
            {
                "name": node.name,
                "position_m": node.position_m.tolist(),
                "coupling": node.coupling,
            }
            for node in element.interfaces
        ],
        "mass_kg": element.mass_kg,
        "center_of_gravity_m": element.center_of_gravity_m.tolist(),
        "inertia_about_center_of_gravity_kg_m2": element.inertia_kg_m2.tolist(),
        "rigid_motions": [
            name
            for name, there in zip(
                ("ux", "uy", "uz", "rx", "ry", "rz"), element.rigid_body_present, strict=True
            )
            if there
        ],
        "free_lateral_frequency_hz": element.free_frequencies_hz.tolist(),
        **{
            f"free_{family}_frequency_hz": free[family][:_MOST_FREE].tolist()
            for family in ("torsional", "axial", "disk")
        },
        "fixed_interface_frequency_hz": element.fixed_interface_frequencies_hz.tolist(),
        "fixed_interface_frequency_error_estimate": element.frequency_error_estimate.tolist(),
        "estimated_error_parts": [form.part for form in element.error_forms],
        "maximum_speed_rpm": float(top * RPM_PER_RAD_S) if np.isfinite(top) else None,
        "unknowns_before_reduction": element.full_dofs,
        "coordinates_are_tied": element.constraint is not None,
        "provenance": dict(element.provenance),
    }


def _coordinate(number: int, coordinate: Coordinate) -> dict[str, Any]:
    """Row and column of the matrices, and what they mean."""
    found: dict[str, Any] = {"row": number, "kind": coordinate.kind}
    if coordinate.kind == "interface":
        return found | {"interface": coordinate.interface, "component": coordinate.component}
    return found | {"fixed_interface_frequency_hz": coordinate.frequency_hz}
