"""Zones and changes of vibration of ISO 20816-3 and grades of ISO 21940-11, beside the clauses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from solidwhirl.analyses.api617.records import Machine
from solidwhirl.core.blocks import numbers
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.standards.iso_balance import (
    grade_of_unbalance_mm_per_s,
    in_two_planes,
    permissible_unbalance_kg_m,
)
from solidwhirl.rotordyn.standards.iso_vibration import (
    significant_change_m,
    vibration_zone,
    zone_borders_m,
)


def iso_document(
    bearing_cases: Mapping[str, Mapping[str, Any]],
    journals_m: Sequence[float],
    bodies: Sequence[Superelement],
    machine: Machine,
    grade_mm_per_s: float,
) -> dict[str, Any]:
    """Return zone and change of the vibration, and what a grade of balance permits.

    `bearing_cases`: documents of the sets of laws by name, that of the scene first; `journals_m`:
    places along the axis; `bodies`: of the shaft.
    """
    cases = [case for found in bearing_cases.values() for case in found["cases"].values()]
    largest = max((case["largest_m"] for case in cases), default=0.0)
    mass = sum(e.mass_kg for e in bodies)
    middle = sum(e.mass_kg * float(e.center_of_gravity_m[2]) for e in bodies) / mass
    whole = permissible_unbalance_kg_m(mass, grade_mm_per_s, machine.high_rpm)
    first, last = journals_m[0], journals_m[-1]
    planes = in_two_planes(whole, middle - first, last - middle) if first < middle < last else None
    placed = max((u["moment_kg_m"] for c in cases for u in c["unbalances"]), default=0.0)
    limit = significant_change_m(machine.high_rpm)
    change = max(_changes(bearing_cases, machine), key=lambda c: float(c["change_m"]), default=None)
    return {
        "zone_borders_m": list(zone_borders_m(machine.high_rpm)),
        "largest_m": largest,
        "zone": vibration_zone(largest, machine.high_rpm),
        "significant_change_m": limit,
        "largest_change": change,
        "change_is_significant": None if change is None else bool(change["change_m"] > limit),
        "mass_kg": mass,
        "grade_mm_per_s": grade_mm_per_s,
        "permissible_kg_m": whole,
        "in_planes_kg_m": None if planes is None else list(planes),
        "largest_placed_kg_m": placed,
        "grade_of_placed_mm_per_s": grade_of_unbalance_mm_per_s(placed, mass, machine.high_rpm),
    }


def _changes(
    bearing_cases: Mapping[str, Mapping[str, Any]], machine: Machine
) -> Iterator[dict[str, Any]]:
    """Yield how far each probe's vector moves between the laws of the scene and other ones.

    Of unbalances that both have, at their common operating speeds.
    """
    own, *others = bearing_cases.items()
    for (name, other), case in product(others, own[1]["cases"]):
        first, second = (found["cases"].get(case) for found in (own[1], other))
        if second is None or first["unbalances"] != second["unbalances"]:
            continue
        rpm, at, there = np.intersect1d(
            first["speed_rpm"], second["speed_rpm"], return_indices=True
        )
        inside = (rpm >= machine.low_rpm) & (rpm <= machine.high_rpm)
        for probe in first["probes"]:
            before, after = (
                _vectors(found["probes"][probe])[rows]
                for found, rows in ((first, at), (second, there))
            )
            sizes = np.abs(after - before)[inside]
            top = int(sizes.argmax())
            yield {
                "bearings": name,
                "unbalance": case,
                "probe": probe,
                "speed_rpm": float(rpm[inside][top]),
                "change_m": float(sizes[top]),
            }


def _vectors(probe: Mapping[str, Any]) -> ComplexArray:
    return np.asarray(
        numbers(probe["peak_to_peak_m"]) * np.exp(1j * np.radians(numbers(probe["phase_deg"])))
    )
