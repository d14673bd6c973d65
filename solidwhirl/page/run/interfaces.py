"""Table of the interfaces: where they are, how large, and what was asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from solidwhirl.page.frame.records import Table


def interfaces_table(bodies: Mapping[str, Any]) -> Iterator[Table]:
    """Give the table of all interfaces of all bodies; nothing where there are none.

    Parameters
    ----------
    bodies
        Of `results.json`.
    """
    rows = [
        (
            f"{name}.{found['name']}",
            _millimetres(found["position_m"]),
            _millimetres(found["mean_position_m"]) if "mean_position_m" in found else None,
            1e6 * found["area_m2"] if "area_m2" in found else None,
            found.get("asked"),
            found.get("cut_facets"),
        )
        for name, body in bodies.items()
        for found in body.get("interfaces", ())
    ]
    if rows:
        yield Table(
            title="Interfaces",
            head=(
                "interface", "node (x, y, z) [mm]", "centre of area [mm]", "area [mm²]",
                "asked for", "facets cut",
            ),
            rows=rows,
            caption="Bearings, gears and disks hold a body at the node. Facets that a box cuts do "
            "not belong to its interface.",
        )  # fmt: skip


def _millimetres(place: list[float]) -> str:
    return ", ".join(f"{1e3 * value:.5g}" for value in place)
