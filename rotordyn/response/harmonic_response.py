"""Steady response of a system to harmonic loads at given speeds: q = [K + iω(C + ΩG) − ω²M]⁻¹ f.

Where a system has a complex form, a load is split into its forward and its backward circle and
each is solved in half of the coordinates. Bearings that are not the same in all directions couple
the circles; what else is not, is solved in all coordinates at once. Many frequencies at one speed
share the modes of the bodies there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.coordinates import Placed, body_rows, interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    at_rate,
    at_whirl_ratio,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.complex_form import ComplexForm, complex_form, lateral_parts
from solidwhirl.rotordyn.response.coupled_circles import (
    circle_loads,
    solve_split,
    split_bodies,
    split_system,
)
from solidwhirl.rotordyn.response.modal_circles import solve_by_modes
from solidwhirl.rotordyn.response.points import PointMatrices, Solved, solve_points

TRANSLATIONS = ("ux", "uy")
TILTS = ("rx", "ry")


def interface_nodes(assembled: Placed) -> tuple[End, ...]:
    """Return all interface nodes of a system, in the order of the bodies and their interfaces."""
    return tuple(
        End(body=name, interface=node.name)
        for name, rotor in assembled.system.rotors.items()
        for node in rotor.element.interfaces
    )


def node_amplitudes(
    assembled: AssembledSystem,
    nodes: Sequence[End],
    components: Sequence[str],
    displacement: ComplexArray,
) -> ComplexArray:
    """Return motions of interface nodes.

    `displacement`: amplitudes of the independent coordinates, shape (p, n). Returns shape (p,
    nodes, components), m and rad; nan where a node lacks the component.
    """
    motion = np.full((displacement.shape[0], len(nodes), len(components)), complex(np.nan))
    for at, node in enumerate(nodes):
        element = assembled.system.rotors[node.body].element
        for place, component in enumerate(components):
            if component in element.components_at(node.interface):
                row = interface_row(assembled, node.body, node.interface, component)
                motion[:, at, place] = displacement @ row
    return motion


def check_lateral(assembled: Placed, node: End, what: str) -> None:
    """Refuse a node that does not exist or lacks ux or uy.

    `what`: begins the message, such as "unbalance 2". Raises AnalysisError: the message names what
    exists.
    """
    rotors = assembled.system.rotors
    if node.body not in rotors:
        raise AnalysisError(f"{what}: there is no body {node.body!r}; there are {list(rotors)}")
    element = rotors[node.body].element
    names = [interface.name for interface in element.interfaces]
    if node.interface not in names:
        raise AnalysisError(
            f"{what}: body {node.body!r} has no interface {node.interface!r}; it has {names}"
        )
    has = element.components_at(node.interface)
    if not set(TRANSLATIONS) <= set(has):
        raise AnalysisError(f"{what}: {node.label} needs ux and uy; it has {list(has)}")


def non_negative(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return speeds or frequencies as an array.

    `name`: of the argument, for the message; `values`: a list of numbers. Returns shape (s,).
    Raises AnalysisError if it is not a list of finite numbers, 0 or more.
    """
    array = np.array(values, dtype=float)
    if array.ndim != 1 or not array.size or not np.isfinite(array).all() or array.min() < 0:
        raise AnalysisError(
            f"{name} needs a list of finite numbers, 0 or more; found {values!r:.200}"
        )
    return array


# Points from which on it takes less time to split a system than to solve all at once.
_WORTH_SPLITTING = 24
# Frequencies at one speed from which on its modes take less time than as many factorisations.
_WORTH_MODES = 24
# Ratios of frequency and speed that differ by less than this fraction are one.
_ONE_RATIO = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class HarmonicResponse(ReadOnlyArrays):
    """Hold the response Re(q e^{iωt}) to the loads Re(f e^{iωt}) at a list of points (Ω, ω).

    `speeds_rad_s`, `frequencies_rad_s`: Ω and ω of the points, shape (p,), rad/s; `displacement`:
    q in the independent coordinates of the system, shape (p, n, r) for r loads per point.
    `relative_residual`: largest |f − D q| / |f| over the loads of each point, in coordinates
    scaled to a unit diagonal, shape (p,); 0 where there is no load.
    """

    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    displacement: ComplexArray
    relative_residual: FloatArray


def harmonic_response(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    loads: npt.ArrayLike,
) -> HarmonicResponse:
    """Solve for the steady response to harmonic loads at a list of speeds and frequencies.

    `speeds_rad_s`: Ω of each point, rad/s, shape (p,) or a number for all; `frequencies_rad_s`: ω
    ≥ 0 of each point, rad/s, shape (p,) or a number for all. `loads`: complex amplitudes f in the
    independent coordinates, shape (p, n, r) or (1, n, r), N and N m. A load that turns with +Ω has
    f_y = −i f_x. q is 0 where f is 0, so that a sweep may begin at ω = 0 for a system that can
    drift. Raises AnalysisError if shapes or numbers have no meaning, or a point lies so near to an
    undamped resonance that fewer than three digits are left; the message names speed and
    frequency.

    Bearings whose force depends on the frequency have that of each point. Genta 2005, Dynamics of
    Rotating Systems, sections 3.6 and 4.7. Points with equal speeds should
    follow each other; the matrices are then made once.
    """
    points = _checked(assembled, speeds_rad_s, frequencies_rad_s, loads)
    speeds, frequencies = points[:2]
    if assembled.depends_on_frequency:
        solved = _by_frequency(assembled, points)
    else:
        solved = _solved(assembled, points)
    return HarmonicResponse(
        speeds_rad_s=speeds,
        frequencies_rad_s=frequencies,
        displacement=solved.displacement,
        relative_residual=solved.relative_residual,
    )


def _by_frequency(assembled: AssembledSystem, points: _Points) -> Solved:
    """Solve with bearings as they are at each frequency, or at one multiple of all speeds."""
    speeds, frequencies, force = points
    turning = speeds > 0
    ratios = frequencies[turning] / speeds[turning]
    if (
        turning.any()
        and not frequencies[~turning].any()
        and np.ptp(ratios) <= _ONE_RATIO * ratios[0]
    ):
        return _solved(at_whirl_ratio(assembled, float(ratios[0])), points)
    displacement = np.zeros(force.shape, dtype=complex)
    residual = np.zeros(speeds.size)
    for frequency in np.unique(frequencies):
        at = np.flatnonzero(frequencies == frequency)
        own = _Points(speeds[at], frequencies[at], force[at])
        found = _solved(at_rate(assembled, 1j * float(frequency)), own)
        displacement[at], residual[at] = found.displacement, found.relative_residual
    return Solved(displacement, residual)


def _solved(assembled: AssembledSystem, points: _Points) -> Solved:
    """Solve in the form that the system has."""
    speeds = points.speeds
    middle = float(speeds.mean())
    if speeds.size >= _WORTH_MODES * np.unique(speeds).size:
        bodies = split_bodies(assembled, middle)
        if bodies is not None:
            lateral, left = solve_by_modes(bodies, *points)
            if not left.all():
                return _completed(assembled, bodies.form, points, lateral, left)
    form = complex_form(assembled)
    many = speeds.size >= _WORTH_SPLITTING
    split = split_system(assembled, middle) if form is None and many else None
    if form is not None:
        return _by_circles(form, points)
    if split is not None:
        return _completed(assembled, split.form, points, *solve_split(split, *points))
    return solve_points(_matrices_of(assembled, slice(None)), *points)


def node_response(
    assembled: AssembledSystem,
    nodes: Sequence[End],
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    loads: npt.ArrayLike,
) -> ComplexArray:
    """Return ux and uy of interface nodes under one load per point, shape (p, nodes, 2), m.

    Arguments and errors are those of `harmonic_response`, with loads (p, n, 1) or (1, n, 1).
    """
    found = harmonic_response(assembled, speeds_rad_s, frequencies_rad_s, loads)
    return node_amplitudes(assembled, nodes, TRANSLATIONS, found.displacement[:, :, 0])


def independent_loads(
    assembled: AssembledSystem, body_loads: Mapping[str, ComplexArray]
) -> ComplexArray:
    """Return loads on the independent coordinates from loads on the coordinates of bodies.

    `body_loads`: forces on the coordinates of each body by name, shape (..., n_body); one or more
    bodies. Returns Tᵀ f, shape (..., n). Raises AssemblyError if there is no such body. Raises
    AnalysisError if no body is named or a load has another number of coordinates than its body.
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


class _Points(NamedTuple):
    """Speeds (p,), frequencies (p,) and loads (p, n, r)."""

    speeds: FloatArray
    frequencies: FloatArray
    force: ComplexArray


def _checked(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    loads: npt.ArrayLike,
) -> _Points:
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
    whole = np.broadcast_to(force, (points, *force.shape[1:]))
    return _Points(
        np.broadcast_to(speeds, (points,)), np.broadcast_to(frequencies, (points,)), whole
    )


def _matrices_of(assembled: AssembledSystem, rows: IntArray | slice) -> PointMatrices:
    """Return the matrices of some coordinates."""
    inside = rows if isinstance(rows, slice) else np.ix_(rows, rows)

    def at_speed(speed_rad_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = matrices_at_speed(assembled, speed_rad_s)
        velocity = found.damping[inside] + found.gyroscopic[inside]
        return found.mass[inside], velocity, found.stiffness[inside]

    return at_speed


def _by_circles(form: ComplexForm, points: _Points) -> Solved:
    """Solve the forward and the backward circle of the loads in z = p + i s.

    f_p + i f_s = a e^{iωt} + b e^{−iωt} with a = (f̂_p + i f̂_s)/2, b = (f̂_p* + i f̂_s*)/2.
    """
    speeds, frequencies, force = points
    form = _loaded(form, force)
    along, mirrored = circle_loads(form, force).swapaxes(0, 1)
    forward = solve_points(form.at_speed, speeds, frequencies, along)
    backward = solve_points(form.at_speed, speeds, -frequencies, mirrored.conj())
    circles = (part.displacement.swapaxes(0, 1) for part in (forward, backward))
    displacement = np.ascontiguousarray(form.whirl_shapes(*circles).swapaxes(0, 1))
    residual = np.maximum(forward.relative_residual, backward.relative_residual)
    return _with_rest(form, points, Solved(displacement, residual))


def _loaded(form: ComplexForm, force: ComplexArray) -> ComplexForm:
    """Return the form of what moves under loads (p, n, r): all that is joined to a loaded place."""
    some = force.any(axis=(0, 2))
    loaded = some[form.first] | some[form.second]
    groups = [at for at in lateral_parts(form) if loaded[at].any()]
    moved = np.sort(np.concatenate(groups)) if groups else np.arange(0)
    return form if moved.size in (0, form.size) else form.part(moved)


def _completed(
    assembled: AssembledSystem,
    form: ComplexForm,
    points: _Points,
    lateral: Solved,
    left: BoolArray,
) -> Solved:
    """Add what circles do not hold: other motions, and by the full equations the points left."""
    solved = _with_rest(form, points, lateral)
    if left.any():
        speeds, frequencies, force = points
        every = _matrices_of(assembled, slice(None))
        whole = solve_points(every, speeds[left], frequencies[left], force[left])
        solved.displacement[left] = whole.displacement
        solved.relative_residual[left] = whole.relative_residual
    return solved


def _with_rest(form: ComplexForm, points: _Points, lateral: Solved) -> Solved:
    """Add the response of the coordinates that a turn does not move, where they are loaded."""
    rest = points.force[:, form.rest]
    if not rest.any():
        return lateral
    others = solve_points(_matrices_of(form.assembled, form.rest), *points[:2], rest)
    lateral.displacement[:, form.rest] = others.displacement
    residual = np.maximum(lateral.relative_residual, others.relative_residual)
    return Solved(lateral.displacement, residual)
