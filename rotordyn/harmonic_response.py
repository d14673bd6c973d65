"""Steady response of a system to harmonic loads at given speeds: q = [K + iω(C + ΩG) − ω²M]⁻¹ f.

Where a system has a complex form, a load is split into its forward and its backward circle and
each is solved in half of the coordinates. Bearings that are not the same in all directions couple
the circles; what else is not, is solved in all coordinates at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray, freeze_arrays
from solidwhirl.rotordyn.complex_form import ComplexForm, complex_form
from solidwhirl.rotordyn.coordinates import body_rows
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.harmonic_response_solver import PointMatrices, Solved, solve_points
from solidwhirl.rotordyn.harmonic_response_split import SplitSystem, solve_split, split_system
from solidwhirl.rotordyn.system import AssembledSystem, matrices_at_speed

# Points from which on it takes less time to split a system than to solve all at once.
_WORTH_SPLITTING = 24


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class HarmonicResponse:
    """Hold the response Re(q e^{iωt}) to the loads Re(f e^{iωt}) at a list of points (Ω, ω).

    Attributes
    ----------
    speeds_rad_s, frequencies_rad_s
        Ω and ω of the points, shape (p,), rad/s.
    displacement
        q in the independent coordinates of the system, shape (p, n, r) for r loads per point.
    relative_residual
        Largest |f − D q| / |f| over the loads of each point, in coordinates scaled to a unit
        diagonal, shape (p,); 0 where there is no load.
    """

    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    displacement: ComplexArray
    relative_residual: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(
            self, "speeds_rad_s", "frequencies_rad_s", "displacement", "relative_residual"
        )


def harmonic_response(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    loads: npt.ArrayLike,
) -> HarmonicResponse:
    """Solve for the steady response to harmonic loads at a list of speeds and frequencies.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Ω of each point, rad/s, shape (p,) or a number for all.
    frequencies_rad_s
        ω ≥ 0 of each point, rad/s, shape (p,) or a number for all.
    loads
        Complex amplitudes f in the independent coordinates, shape (p, n, r) or (1, n, r), N and
        N m. A load that turns with +Ω has f_y = −i f_x.

    Returns
    -------
    HarmonicResponse
        With q = 0 where f = 0, so that a sweep may begin at ω = 0 for a system that can drift.

    Raises
    ------
    AnalysisError
        If shapes or numbers have no meaning, or a point lies so near to an undamped resonance
        that fewer than three digits are left; the message names speed and frequency.

    Notes
    -----
    Genta 2005, Dynamics of Rotating Systems, sections 3.6 and 4.7. Points with equal speeds should
    follow each other; the matrices are then made once.
    """
    speeds, frequencies, force = _checked(assembled, speeds_rad_s, frequencies_rad_s, loads)
    form = complex_form(assembled)
    many = speeds.size >= _WORTH_SPLITTING
    split = split_system(assembled, float(speeds.mean())) if form is None and many else None
    if form is not None:
        solved = _by_circles(form, speeds, frequencies, force)
    elif split is not None:
        solved = _by_split(assembled, split, speeds, frequencies, force)
    else:
        solved = solve_points(_all_coordinates(assembled), speeds, frequencies, force)
    return HarmonicResponse(
        speeds_rad_s=speeds,
        frequencies_rad_s=frequencies,
        displacement=solved.displacement,
        relative_residual=solved.relative_residual,
    )


def independent_loads(
    assembled: AssembledSystem, body_loads: Mapping[str, ComplexArray]
) -> ComplexArray:
    """Return loads on the independent coordinates from loads on the coordinates of bodies.

    Parameters
    ----------
    assembled
        The system.
    body_loads
        Forces on the coordinates of each body by name, shape (..., n_body); one or more bodies.

    Returns
    -------
    ndarray
        Tᵀ f, shape (..., n).

    Raises
    ------
    AssemblyError
        If there is no such body.
    AnalysisError
        If no body is named or a load has another number of coordinates than its body.
    """
    if not body_loads:
        raise AnalysisError("body_loads is empty; one or more bodies are needed")
    total: ComplexArray = np.zeros(assembled.size, dtype=complex)
    for body, load in body_loads.items():
        rows = body_rows(assembled, body)
        if load.shape[-1] != rows.shape[0]:
            raise AnalysisError(
                f"body_loads[{body!r}] has shape {load.shape}; the last length must be "
                f"{rows.shape[0]}, the number of its coordinates"
            )
        total = total + load @ rows
    return total


def _checked(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    loads: npt.ArrayLike,
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Return speeds (p,), frequencies (p,) and loads (p, n, r)."""
    speeds = np.atleast_1d(np.asarray(speeds_rad_s, dtype=float))
    frequencies = np.atleast_1d(np.asarray(frequencies_rad_s, dtype=float))
    force = np.asarray(loads, dtype=complex)
    points = max(speeds.size, frequencies.size)
    for name, values in (("speeds_rad_s", speeds), ("frequencies_rad_s", frequencies)):
        if values.shape not in ((1,), (points,)) or not np.isfinite(values).all():
            raise AnalysisError(
                f"{name} needs finite numbers, one or {points}; found shape {values.shape}"
            )
    if (frequencies < 0).any():
        raise AnalysisError(f"frequencies_rad_s holds {frequencies.min()}; 0 or more is allowed")
    if force.ndim != 3 or force.shape[0] not in (1, points) or force.shape[1] != assembled.size:
        raise AnalysisError(
            f"loads has shape {force.shape}; allowed is ({points} or 1, {assembled.size}, loads)"
        )
    if not np.isfinite(force).all():
        raise AnalysisError("loads holds a number that is not finite")
    return (
        np.broadcast_to(speeds, (points,)),
        np.broadcast_to(frequencies, (points,)),
        np.broadcast_to(force, (points, *force.shape[1:])),
    )


def _all_coordinates(assembled: AssembledSystem) -> PointMatrices:
    def at_speed(speed_rad_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = matrices_at_speed(assembled, speed_rad_s)
        return found.mass, found.damping + found.gyroscopic, found.stiffness

    return at_speed


def _remaining_coordinates(form: ComplexForm) -> PointMatrices:
    """Return the matrices of the coordinates that a turn does not move."""
    inside = np.ix_(form.rest, form.rest)

    def at_speed(speed_rad_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = matrices_at_speed(form.assembled, speed_rad_s)
        velocity = found.damping[inside] + found.gyroscopic[inside]
        return found.mass[inside], velocity, found.stiffness[inside]

    return at_speed


def _by_circles(
    form: ComplexForm, speeds: FloatArray, frequencies: FloatArray, force: ComplexArray
) -> Solved:
    """Solve the forward and the backward circle of the loads in z = p + i s.

    f_p + i f_s = a e^{iωt} + b e^{−iωt} with a = (f̂_p + i f̂_s)/2, b = (f̂_p* + i f̂_s*)/2.
    """
    by_coordinate = force.swapaxes(0, 1)
    along = 0.5 * form.to_complex(by_coordinate).swapaxes(0, 1)
    against = 0.5 * form.to_complex(by_coordinate.conj()).swapaxes(0, 1)
    forward = solve_points(form.at_speed, speeds, frequencies, along)
    backward = solve_points(form.at_speed, speeds, -frequencies, against)
    circles = (part.displacement.swapaxes(0, 1) for part in (forward, backward))
    displacement = np.ascontiguousarray(form.whirl_shapes(*circles).swapaxes(0, 1))
    residual = np.maximum(forward.relative_residual, backward.relative_residual)
    return _with_rest(form, speeds, frequencies, force, Solved(displacement, residual))


def _by_split(
    assembled: AssembledSystem,
    split: SplitSystem,
    speeds: FloatArray,
    frequencies: FloatArray,
    force: ComplexArray,
) -> Solved:
    """Solve in circles that the bearings couple; by the full equations where that is poor."""
    found = solve_split(split, speeds, frequencies, force)
    lateral = Solved(found.displacement, found.relative_residual)
    solved = _with_rest(split.form, speeds, frequencies, force, lateral)
    left = found.unsolved
    if left.any():
        whole = solve_points(
            _all_coordinates(assembled), speeds[left], frequencies[left], force[left]
        )
        solved.displacement[left] = whole.displacement
        solved.relative_residual[left] = whole.relative_residual
    return solved


def _with_rest(
    form: ComplexForm,
    speeds: FloatArray,
    frequencies: FloatArray,
    force: ComplexArray,
    lateral: Solved,
) -> Solved:
    """Add the response of the coordinates that a turn does not move, where they are loaded."""
    rest = force[:, form.rest]
    if not rest.any():
        return lateral
    others = solve_points(_remaining_coordinates(form), speeds, frequencies, rest)
    lateral.displacement[:, form.rest] = others.displacement
    residual = np.maximum(lateral.relative_residual, others.relative_residual)
    return Solved(lateral.displacement, residual)
