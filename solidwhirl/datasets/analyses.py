"""Analyses of a run as datasets, from what results.json holds of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl.datasets.parts import Labelled, labelled, tabled
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

Document = Mapping[str, Any]

_MARGIN_NUMBERS = (
    "critical_speed_rpm",
    "amplification_factor",
    "operating_speed_rpm",
    "margin",
    "required_api_617",
)
_PEAK_NUMBERS = ("speed_rpm", "frequency_hz", "amplitude_m", "amplification")
_PEAK_ERRORS = ("frequency_error_estimate", "amplitude_error_estimate")
_VERDICTS = ("api_617", "15_percent", "20_percent")
#: Axes of the arrays of results, by kind and name.
GRIDS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "campbell": dict.fromkeys(
        ("frequency_hz", "log_decrement", "whirl", "eigenvalue_per_s"), ("branch", "speed_rpm")
    ),
    "modes": {
        **dict.fromkeys(
            ("frequency_hz", "log_decrement", "damping_ratio", "eigenvalue_per_s"), ("mode",)
        ),
        "shape": ("coordinate", "mode"),
    },
    "critical_speed_map": dict.fromkeys(
        ("critical_speed_rpm", "shaft_speed_rpm", "whirl", "likeness"),
        ("branch", "stiffness_n_per_m"),
    ),
    # at the frequencies of a map, and the highest in the step around each
    "waterfall": dict.fromkeys(("amplitude_m", "highest_m"), ("speed_rpm", "frequency_hz")),
    "stiffness_study": dict.fromkeys(
        ("amplitude_m", "highest_m"), ("stiffness_n_per_m", "frequency_hz")
    ),
    "stability": dict.fromkeys(
        (
            "smallest_log_decrement",
            "frequency_hz",
            "largest_growth_rate_per_s",
            "growing_motions",
        ),
        ("speed_rpm",),
    ),
}


def analysis_dataset(document: Document) -> xr.Dataset:
    """Return one analysis of a run as a dataset.

    Returns
    -------
    Dataset
        Names as in results.json; single numbers and texts are attributes. Kinds without arrays
        have attributes alone.
    """
    found = _KINDS.get(document["kind"], _nothing)(document)
    return found.assign_attrs(_single(document) | found.attrs)


def peaks_dataset(document: Document) -> xr.Dataset | None:
    """Return the resonance peaks of one analysis as a dataset.

    Returns
    -------
    Dataset or None
        place, exciter, speed_rpm, frequency_hz, amplitude_m, amplification over peak, which counts
        from 1, and error estimates where there are such. None of a kind without such peaks.
    """
    if document["kind"] == "unbalance_response":
        by_place = [(", ".join(e["bodies"]), e["peaks"]) for e in document["exciters"]]
    elif document["kind"] == "place_map":
        by_place = [("", document["peaks"])]
    else:
        return None
    rows = [
        {"place": place, "exciter": exciter or place.partition(".")[0], **peak}
        for exciter, peaks in by_place
        for place, found in peaks.items()
        for peak in found
    ]
    errors = [key for key in _PEAK_ERRORS if rows and all(key in row for row in rows)]
    variables: dict[str, Labelled] = {
        key: ("peak", np.array([row[key] for row in rows], dtype=str))
        for key in ("place", "exciter")
    }
    for key in (*_PEAK_NUMBERS, *errors):
        variables[key] = ("peak", np.array([row[key] for row in rows], dtype=float))
    return labelled(variables)


def run_up_record(record: Mapping[str, Any], mount: str) -> xr.Dataset:
    """Return the record over time that a run-up writes beside results.json.

    Parameters
    ----------
    record
        Arrays of the .npz file by name.
    mount
        Bearing whose force is recorded.
    """
    return labelled(
        {
            "mount_force_n": (("axis", "time_s"), record["mount_force_n"]),
            "mount_moment_n_m": (("axis", "time_s"), record["mount_moment_n_m"]),
            "translation_m": (("place", "axis", "time_s"), record["translation_m"]),
        },
        {
            "time_s": ("time_s", record["time_s"]),
            "speed_rpm": ("time_s", record["speed_rad_s"] * RPM_PER_RAD_S),
            "axis": ("axis", ["x", "y", "z"]),
            "place": ("place", np.asarray(record["outputs"], dtype=str)),
        },
        mount=mount,
    )


def _single(document: Document) -> dict[str, Any]:
    """Numbers, texts, and lists of texts."""
    out: dict[str, Any] = {}
    for key, value in document.items():
        texts = isinstance(value, list) and all(isinstance(v, str) for v in value)
        if isinstance(value, str | int | float) or (texts and value):
            out[key] = value
    return out


def _nothing(document: Document) -> xr.Dataset:
    return xr.Dataset()


def _unbalance(document: Document) -> xr.Dataset:
    exciters = document["exciters"]
    places, bearings = list(exciters[0]["places"]), list(exciters[0]["bearing_force_n"])
    at_place = ("exciter", "place", "speed_rpm")
    variables: dict[str, Labelled] = {
        key: (at_place, [[e["places"][place][key] for place in places] for e in exciters])
        for key in exciters[0]["places"][places[0]]
    }
    if bearings:
        forces = [[e["bearing_force_n"][name] for name in bearings] for e in exciters]
        variables["bearing_force_n"] = (("exciter", "bearing", "speed_rpm"), forces)
    return labelled(
        variables,
        {
            "exciter": ("exciter", [", ".join(e["bodies"]) for e in exciters]),
            "place": ("place", places),
            **({"bearing": ("bearing", bearings)} if bearings else {}),
            "speed_rpm": ("speed_rpm", document["speed_rpm"]),
            "frequency_hz": (("exciter", "speed_rpm"), [e["frequency_hz"] for e in exciters]),
        },
    )


def _place_map(document: Document) -> xr.Dataset:
    over = ("place", "speed_rpm")
    return tabled(
        {**document, "place": document["places"]}, {"amplitude_m": over, "frequency_hz": over}
    ).set_coords("frequency_hz")


def _rotating_campbell(document: Document) -> xr.Dataset:
    bodies = document["bodies"]
    over = ("body", "order", "branch", "speed_rpm")
    keys = ("frequency_hz", "share", "mirrored")
    variables: dict[str, Labelled] = {
        key: (over, [body[key] for body in bodies.values()]) for key in keys
    }
    first = next(iter(bodies.values()))
    energy = [body["share_of_kinetic_energy"] for body in bodies.values()]
    variables["share_of_kinetic_energy"] = (("body", "branch", "speed_rpm"), energy)
    return labelled(
        variables,
        {
            "body": ("body", list(bodies)),
            "order": ("order", first["orders"]),
            "speed_rpm": ("speed_rpm", document["speed_rpm"]),
            "speed_ratio": ("body", [body["speed_ratio"] for body in bodies.values()]),
        },
    )


def _mode_shapes(document: Document) -> xr.Dataset:
    speeds = document["speeds"]
    most = max(len(s["frequency_hz"]) for s in speeds)
    bodies = speeds[0]["bodies"]
    places = [f"{body}.{name}" for body, shape in bodies.items() for name in shape["interfaces"]]
    axial = [z for shape in bodies.values() for z in shape["interface_axial_m"]]

    def deflections(speed: Document) -> list[Any]:
        return [row for shape in speed["bodies"].values() for row in shape["interface_deflection"]]

    variables: dict[str, Labelled] = {
        key: (("speed_rpm", "mode"), [_padded(s[key], most) for s in speeds])
        for key in ("frequency_hz", "log_decrement", "whirl")
    }
    variables["branch"] = (
        ("speed_rpm", "mode"),
        [_padded([k or 0 for k in s.get("branch", ())], most) for s in speeds],
    )
    rows = [[_padded(row, most) for row in deflections(s)] for s in speeds]
    variables["deflection"] = (("speed_rpm", "place", "mode"), rows)
    coordinates: dict[str, Labelled] = {
        "speed_rpm": ("speed_rpm", [s["speed_rpm"] for s in speeds]),
        "place": ("place", np.array(places, dtype=str)),
        "axial_m": ("place", np.array(axial, dtype=float)),
    }
    for key, dim in (
        ("kinetic_energy", "body"),
        ("strain_energy_of_bodies", "body"),
        ("strain_energy_of_joints", "joint"),
    ):
        names = list(speeds[0][key])
        shares = [[_padded(s[key][name], most) for name in names] for s in speeds]
        if names:
            variables[f"share_of_{key}"] = (("speed_rpm", dim, "mode"), shares)
            coordinates[dim] = (dim, names)
    return labelled(variables, coordinates)


def _padded(values: list[Any], count: int) -> list[Any]:
    return [*values, *[None] * (count - len(values))]


def _margins(document: Document) -> xr.Dataset:
    rows = document["margins"]
    texts = ("shaft", "whirl", "position", *(f"verdict_{v}" for v in _VERDICTS))
    columns = {key: [row[key] for row in rows] for key in (*_MARGIN_NUMBERS, *texts)}
    return labelled(
        {
            key: ("resonance", np.array(found, str if key in texts else float))
            for key, found in columns.items()
        }
    )


def _stability(document: Document) -> xr.Dataset:
    told = {f"threshold_{key}": value for key, value in (document["threshold"] or {}).items()}
    return _grid(document).assign_attrs({k: v for k, v in told.items() if v is not None})


def _grid(document: Document) -> xr.Dataset:
    return tabled(document, GRIDS[document["kind"]])


def _bearing_laws(document: Document) -> xr.Dataset:
    laws = document["bearings"]
    if not laws:
        return xr.Dataset()
    own = "speed_of_its_rotor_rpm"
    over = ("bearing", "point", "direction")
    return labelled(
        {
            key: (over, [law[key] for law in laws.values()])
            for key in ("stiffness_n_per_m", "damping_n_s_per_m")
        },
        {
            "bearing": ("bearing", list(laws)),
            "direction": ("direction", ["x", "y"]),
            "law": ("bearing", [law["law"] for law in laws.values()]),
            own: (("bearing", "point"), [law[own] for law in laws.values()]),
        },
    )


_KINDS: Mapping[str, Callable[[Document], xr.Dataset]] = {
    "unbalance_response": _unbalance,
    "place_map": _place_map,
    "waterfall": _grid,
    "stiffness_study": _grid,
    "critical_speed_map": _grid,
    "rotating_campbell": _rotating_campbell,
    "mode_shapes": _mode_shapes,
    "separation_margins": _margins,
    "stability": _stability,
    "bearing_laws": _bearing_laws,
}
