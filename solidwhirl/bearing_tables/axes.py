"""Other loads, axes and meanings of a table, as one that a bearing of a scene can have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np

from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.rotordyn.assembly.bearing_laws import mirrored
from solidwhirl.rotordyn.core.arrays import FloatArray

Axis = Literal["speed", "frequency"]
Spin = Literal["x_to_y", "y_to_x"]
_PARTS = ("stiffness_n_per_m", "damping_n_s_per_m", "mass_kg")


def turned(table: CoefficientTable, angle_deg: float) -> CoefficientTable:
    """Return a table in axes of which the maker's are turned by an angle, from x towards y.

    K' = R K Rᵀ with R = [[cos, −sin], [sin, cos]], and so for damping and mass. A maker whose x
    points along our y, with the same sense of the spin, has an angle of 90 degrees.
    """
    quarter, rest = divmod(angle_deg, 90.0)
    if rest == 0.0:  # without the rounding of π
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    turn = np.array([[cos, -sin], [sin, cos]])
    return _changed(table, lambda values: turn @ values @ turn.T + 0.0)


def in_sense_of_spin(table: CoefficientTable, spin: Spin) -> CoefficientTable:
    """Return a table in axes whose x turns towards y with the shaft.

    `spin`: how the shaft turns in the maker's axes. Where it is "y_to_x", y is reversed, so that
    cross terms change sign; nothing is assumed of the bearing.
    """
    return table if spin == "x_to_y" else _changed(table, mirrored)


def at_load(table: CoefficientTable, load_n: float | None) -> CoefficientTable:
    """Return a table at one load, between the loads of the table linear.

    Raises TableFileError: a load beyond the ends of the table, one where the table has no loads,
    or none where it has.
    """
    loads = table.loads_n
    if loads is None:
        if load_n is not None:
            raise TableFileError(table.source, "load_n: the table has no column of loads")
        return table
    span = f"the table has {loads.size} loads from {loads[0]:g} to {loads[-1]:g} N"
    if load_n is None:
        raise TableFileError(
            table.source,
            f"load_n: missing; {span} (load_from takes the loads of a static analysis)",
        )
    if not loads[0] <= load_n <= loads[-1]:
        raise TableFileError(table.source, f"load_n: found {load_n:g}; {span}")
    high = int(np.searchsorted(loads, load_n))
    low = max(high - 1, 0)
    share = 0.0 if high == low else (load_n - loads[low]) / (loads[high] - loads[low])

    def between(values: FloatArray) -> FloatArray:
        return np.asarray(((1.0 - share) * values[low] + share * values[high])[None])

    note = f"at a load of {load_n:g} N; {span}"
    return replace(_changed(table, between, loads_n=None), notes=(*table.notes, note))


def is_over_frequency_alone(table: CoefficientTable) -> bool:
    """Tell whether a table has frequencies and no speeds, and so may mean either."""
    return table.speeds_rad_s is None and table.frequencies_rad_s is not None


def over(table: CoefficientTable, axis: Axis | None) -> CoefficientTable:
    """Return a table over one axis as one over the speed, or over the frequency of the motion.

    Tables that a maker heads with a frequency are mostly synchronous: the frequency is the speed
    of the rotor. So a table over frequency alone is never taken for what it says without `axis`.
    Raises TableFileError: `axis` is missing there, or given for a table that has not one axis of
    speed or frequency.
    """
    speeds, frequencies = table.speeds_rad_s, table.frequencies_rad_s
    if axis is None:
        if is_over_frequency_alone(table):
            raise TableFileError(
                table.source,
                'axis: missing; the table is over frequency alone, which is axis = "speed" where '
                'it is the speed of the rotor, and axis = "frequency" where it is that of the '
                "motion, whatever the speed",
            )
        return table
    if (speeds is None) == (frequencies is None):
        raise TableFileError(table.source, "axis: the table is not over one of speed and frequency")
    if (axis == "speed") == (speeds is not None):
        return table
    only = frequencies if speeds is None else speeds
    return replace(
        _changed(
            table,
            lambda values: values.swapaxes(1, 2),
            speeds_rad_s=only if axis == "speed" else None,
            frequencies_rad_s=only if axis == "frequency" else None,
        ),
        notes=(*table.notes, f"its only axis is taken as {axis}, as was told"),
    )


def _changed(
    table: CoefficientTable, change: Callable[[FloatArray], FloatArray], **axes: FloatArray | None
) -> CoefficientTable:
    """Return a table with all its coefficients changed alike, and with other axes."""
    parts = {name: change(getattr(table, name)) for name in _PARTS}
    return replace(table, **parts, **axes)  # type: ignore[arg-type]
