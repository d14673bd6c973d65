"""How arrays become labelled ones: units by the names that carry them, one look of all datasets."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from solidwhirl.core import plain_data
from solidwhirl.core.key_units import name_of, unit_of
from solidwhirl.core.plain_data import Labelled

# Significant digits of speeds and frequencies along an axis.
_DIGITS = 13
# Axes that count from 1, as pictures and reports do.
_COUNTED = ("branch", "mode", "critical_speed", "peak", "resonance", "reference")

_LONG_NAMES = {
    "speed_rpm": "speed of the reference shaft",
    "whirl": "direction of whirl, or kind of motion",
    "kind": "kind of motion by shares of the kinetic energy",
    "share": "share of the kinetic energy by family of motions",
    "log_decrement": "logarithmic decrement, negative is unstable",
    "frequency_error_estimate": "relative error estimate of the frequency",
    "error_parts": "relative error estimate by its cause",
    "error_part": "cause of the error",
    "exciter": "bodies whose unbalance turns at this frequency",
    "major_m": "major semi-axis of the orbit",
    "minor_m": "minor semi-axis of the orbit",
    "amplification": "amplification of the peak",
    "verdict_15_percent": "verdict on a margin of 15 %",
    "verdict_20_percent": "verdict on a margin of 20 %",
    "margin": "distance from the operating speed over it, negative below",
}


def units_of(name: str) -> str:
    """Return the unit that a name such as "stiffness_n_per_m" carries, "1" where it has none."""
    plain = unit_of(name).replace("·", " ").replace("²", "2").replace("³", "3")
    return plain.replace("°", "degree") or "1"


def long_name_of(name: str) -> str:
    """Return the text for the axis of a picture, without the unit that a name carries."""
    return _LONG_NAMES.get(name) or name_of(name).replace("_", " ")


def labelled(
    variables: Mapping[str, Labelled],
    coordinates: Mapping[str, Labelled] | None = None,
    **attributes: Any,
) -> xr.Dataset:
    """Make a dataset whose variables and coordinates have `units` and `long_name`.

    `variables`, `coordinates`: dimensions and values by name. None among values is nan in numbers
    and "" in texts. Axes such as "branch" and "mode" count from 1 and need no coordinate.
    `attributes`: of the dataset.
    """
    known = dict(coordinates or {})
    for dims, values in variables.values():
        axes = (dims,) if isinstance(dims, str) else dims
        for dim, count in zip(axes, np.shape(values), strict=False):
            if dim in _COUNTED:
                known.setdefault(dim, (dim, np.arange(1, count + 1)))
    return xr.Dataset(
        {name: _variable(name, *_whole(*found, known)) for name, found in variables.items()},
        coords={
            name: _variable(name, dims, _exact(name, dims, values))
            for name, (dims, values) in known.items()
        },
        attrs={key: value for key, value in attributes.items() if value is not None},
    )


def _whole(dims: Sequence[str] | str, values: Any, coordinates: Mapping[str, Labelled]) -> Labelled:
    """Give values without an entry, which do not tell their dimensions, those of the axes."""
    if isinstance(dims, str) or np.size(values) or not all(d in coordinates for d in dims):
        return dims, values
    return dims, np.empty([len(coordinates[d][1]) for d in dims])


def _variable(name: str, dims: Sequence[str] | str, values: Any) -> xr.Variable:
    array = filled(values)
    attributes: dict[Hashable, Any] = {"long_name": long_name_of(name)}
    if array.dtype.kind in "fc" or (array.dtype.kind in "iu" and units_of(name) != "1"):
        attributes["units"] = units_of(name)
    return xr.Variable(dims, array, attributes)


def _exact(name: str, dims: Sequence[str] | str, values: Any) -> Any:
    """Values along an axis without the rounding of their conversion, so that they can be named.

    9000 rpm becomes rad/s and back 9000.000000000002, which `.sel(speed_rpm=9000)` would not find.
    """
    if dims != name or not name.endswith(("_rpm", "_hz")):
        return values
    return np.array([float(f"{value:.{_DIGITS}g}") for value in values])


def filled(values: Any) -> npt.NDArray[Any]:
    """Return values as an array that holds no None: nan stands for it, "" among texts."""
    array = np.asarray(values)
    if array.dtype != object:
        return array
    if any(isinstance(value, str) for value in array.ravel()):
        return np.where(array == None, "", array).astype(str)  # noqa: E711 - element by element
    return array.astype(float)


def tabled(document: Mapping[str, Any], over: Mapping[str, Sequence[str]]) -> xr.Dataset:
    """Return arrays of a document as a dataset, see `plain_data.tabled`."""
    return labelled(*plain_data.tabled(document, over)[:2])


def with_shares(found: xr.Dataset, document: Mapping[str, Any], dims: Sequence[str]) -> xr.Dataset:
    """Return a dataset with the shares of energy of a document, if it has such, over family too."""
    if "shares" not in document:
        return found
    values = np.stack([filled(part).astype(float) for part in document["shares"].values()], axis=-1)
    coordinates: dict[str, Labelled] = {dim: (dim, found[dim].values) for dim in dims}
    coordinates["family"] = ("family", list(document["shares"]))
    return found.merge(labelled({"share": ((*dims, "family"), values)}, coordinates))


def with_errors(found: xr.Dataset, document: Mapping[str, Any], dims: Sequence[str]) -> xr.Dataset:
    """Return a dataset with the error estimates of a document, if it has such.

    `found`: the dataset. `document`: may have `frequency_error_estimate` and `error_parts` by name
    of the part. `dims`: of each of them.
    """
    if "frequency_error_estimate" not in document:
        return found
    total = filled(document["frequency_error_estimate"]).astype(float)
    variables: dict[str, Labelled] = {"frequency_error_estimate": (dims, total)}
    coordinates: dict[str, Labelled] = {dim: (dim, found[dim].values) for dim in dims}
    if parts := document["error_parts"]:
        values = np.stack([filled(part).astype(float) for part in parts.values()])
        variables["error_parts"] = (("error_part", *dims), values)
        coordinates["error_part"] = ("error_part", list(parts))
    return found.merge(labelled(variables, coordinates))
