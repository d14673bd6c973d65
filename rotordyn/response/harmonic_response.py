"""Steady response of a system to harmonic loads at given speeds: q = [K + iω(C + ΩG) − ω²M]⁻¹ f.

Where a system has a complex form, a load is split into its forward and its backward circle and
each is solved in half of the coordinates. Bearings that are not the same in all directions couple
the circles; what else is not, is solved in all coordinates at once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import (
    Placed,
    body_rows,
    interface_row,
    joint_motion,
)
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    LawJoint,
    at_rate,
    at_whirl_ratio,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    Matrix,
    ReadOnlyArrays,
)
from solidwhirl.rotordyn.core.errors import AnalysisError, NoSteadyResponseError
from solidwhirl.rotordyn.modes.complex_form import (
    ComplexForm,
    complex_form,
    lateral_parts,
    matrix_form,
)

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


MatrixTriple: TypeAlias = tuple[Matrix, Matrix, Matrix]
# Mass, velocity and stiffness matrix at a speed Ω.
PointMatrices: TypeAlias = Callable[[float], MatrixTriple]

# Bytes of the dynamic stiffness matrices solved together.
CHUNK_BYTES = 1 << 20
# |D| |q| / |f| above which fewer than three digits of q are left.
_SINGULAR = 1e-3 / np.finfo(float).eps


class Solved(NamedTuple):
    """q, shape (p, n, r), and the largest |f − D q| / |f| of each point, shape (p,)."""

    displacement: ComplexArray
    relative_residual: FloatArray


def solve_points(
    matrices: PointMatrices, speeds: FloatArray, frequencies: FloatArray, loads: ComplexArray
) -> Solved:
    """Solve for the response at each point; a point without load is not solved.

    `loads`: f, shape (p, n, r). `matrices`: M, V and K at a speed, each (n, n), real or complex, M
    Hermitian. `speeds`, `frequencies`: Ω and ω of the points, shape (p,), rad/s; ω of either sign.
    Residuals are in coordinates scaled by powers of two to a diagonal near 1. Raises
    NoSteadyResponseError if a point is singular to working accuracy; the message names it.
    """
    displacement = np.zeros(loads.shape, dtype=complex)
    residual = np.zeros(speeds.size)
    for points, stack, scale in _stacks(matrices, speeds, frequencies, loads, _fill):
        where = (speeds[points], frequencies[points])
        solution, residual[points] = _solve_stack(stack, loads[points] * scale, *where)
        displacement[points] = solution * scale
    return Solved(displacement, residual)


def _stacks(
    matrices: PointMatrices,
    speeds: FloatArray,
    frequencies: FloatArray,
    loads: ComplexArray,
    fill: Callable[[ComplexArray, MatrixTriple, float], None],
) -> Iterator[tuple[IntArray, ComplexArray, FloatArray]]:
    """Yield points that are loaded, their scaled dynamic stiffness, and the scale (n, 1)."""
    loaded = np.flatnonzero(loads.any(axis=tuple(range(1, loads.ndim))))
    if not loaded.size:
        return
    scaled = ScaledMatrices(matrices, float(speeds[loaded[0]]), float(np.abs(frequencies).max()))
    shape = (*loads.shape[1:-1], loads.shape[-2])
    chunk = max(1, CHUNK_BYTES // (16 * int(np.prod(shape))))
    dynamic = np.empty((min(chunk, loaded.size), *shape), dtype=complex)
    for start in range(0, loaded.size, chunk):
        points = loaded[start : start + chunk]
        stack = dynamic[: points.size]
        for place, point in zip(stack, points, strict=True):
            fill(place, scaled.at(float(speeds[point])), float(frequencies[point]))
        yield points, stack, scaled.scale[:, None]


class ScaledMatrices:
    """Keep the scaled matrices of the last speed, as points of equal speed follow each other.

    Scales are powers of two near 1/√(K + ω²M), so that scaling rounds nothing.
    """

    def __init__(self, matrices: PointMatrices, speed: float, highest: float) -> None:
        mass, _, stiffness = matrices(speed)
        size = np.abs(np.diag(stiffness)) + highest**2 * np.diag(mass).real
        _, exponent = np.frexp(np.where(size > 0, size, 1.0))
        self.scale: FloatArray = np.ldexp(1.0, -(exponent // 2))
        self._outer = np.multiply.outer(self.scale, self.scale)
        self._matrices = matrices
        self._mass = mass * self._outer
        self._speed: float | None = None
        self._found: MatrixTriple | None = None

    def at(self, speed: float) -> MatrixTriple:
        """Return M, V and K at a speed, scaled from both sides."""
        if self._found is None or speed != self._speed:
            _, velocity, stiffness = self._matrices(speed)
            self._speed = speed
            self._found = (self._mass, velocity * self._outer, stiffness * self._outer)
        return self._found


def _fill(place: ComplexArray, triple: MatrixTriple, omega: float) -> None:
    """Write K + iωV − ω²M to a place."""
    mass, velocity, stiffness = triple
    inertia = mass * -(omega**2)
    if all(np.isrealobj(matrix) for matrix in triple):
        np.add(inertia, stiffness, out=place.real)
        np.multiply(velocity, omega, out=place.imag)
        return
    np.multiply(velocity, 1j * omega, out=place)
    place += stiffness
    place += inertia


def _solve_stack(
    stack: ComplexArray, loads: ComplexArray, speeds: FloatArray, frequencies: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Solve a stack of systems and measure each solution."""
    try:
        solution = np.linalg.solve(stack, loads)
    except np.linalg.LinAlgError:
        at = next(k for k, dynamic in enumerate(stack) if not _has_inverse(dynamic))
        raise _singular(speeds, frequencies, at) from None
    error = loads - stack @ solution
    residual, growth = _measured(stack, loads, solution, error)
    bad = ~(growth <= _SINGULAR)
    if bad.any():
        raise _singular(speeds, frequencies, int(bad.argmax()))
    return solution, residual


def _measured(
    stack: ComplexArray, loads: ComplexArray, solution: ComplexArray, error: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Return the largest |f − D q| / |f| and |D| |q| / |f| of each point, (p,)."""
    flat = stack.view(float).reshape(stack.shape[0], -1)
    size = np.sqrt(np.einsum("pi,pi->p", flat, flat))[:, None]
    columns = (a.reshape(a.shape[0], -1, a.shape[-1]) for a in (loads, solution, error))
    force, motion, left = (np.sqrt((a.real**2 + a.imag**2).sum(axis=1)) for a in columns)
    force = np.where(force > 0, force, np.inf)
    return (left / force).max(axis=1), (size * motion / force).max(axis=1)


def _has_inverse(matrix: ComplexArray) -> bool:
    try:
        np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def _singular(speeds: FloatArray, frequencies: FloatArray, at: int) -> NoSteadyResponseError:
    speed, omega = float(speeds[at]), abs(float(frequencies[at]))
    return NoSteadyResponseError(
        f"at speed {speed:.10g} rad/s and frequency {omega:.10g} rad/s "
        f"({omega / (2.0 * np.pi):.8g} Hz) the system is at an undamped resonance, or free to "
        "drift, and has no steady response; add damping or leave this point out"
    )


# A point is left to the full equations above this |f − D q| / |f| or this |D| |q| / |f|.
_POOR = 1e-10
_LARGE = 1e9
# A coupling of more rows than this fraction of the half coordinates saves no time.
_MOST_ROWS = 0.5


class _Part(NamedTuple):
    """What one bearing adds: relative motion (2, n), k and c beside the isotropic mean, its law."""

    motion: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    law: LawJoint | None


class SplitSystem(NamedTuple):
    """A system that is the same in all directions, and what bearings add on the motions U q (r,).

    `turned` is V = U_p − i U_s, so that U q = V z₊ + V* w for the circles z₊ and w = z₋*.
    """

    form: ComplexForm
    turned: ComplexArray
    stiffness: FloatArray
    damping: FloatArray
    laws: tuple[tuple[slice, LawJoint], ...]

    def coupling(self, speed_rad_s: float) -> tuple[FloatArray, FloatArray]:
        """Return k and c on U q, each (r, r)."""
        if not self.laws:
            return self.stiffness, self.damping
        stiffness, damping = self.stiffness.copy(), self.damping.copy()
        for rows, law in self.laws:
            more = law.coefficients(speed_rad_s)
            stiffness[rows, rows] += more[0]
            damping[rows, rows] += more[1]
        return stiffness, damping


def split_system(assembled: AssembledSystem, speed_rad_s: float) -> SplitSystem | None:
    """Split a system into one that is the same in all directions and a coupling by bearings.

    `speed_rad_s`: Ω at which bearings with a speed law give the isotropic part its share. Returns
    none where the bodies do not know how they turn, joints hold x other than y, or the coupling has
    too many rows to save time.
    """
    if assembled.spin_generator is None or any(len(j.motion) > 2 for j in assembled.law_joints):
        return None
    parts = tuple(_parts(assembled, speed_rad_s))
    if not parts or 2 * len(parts) > 0.5 * _MOST_ROWS * assembled.size:
        return None
    stiffness, damping = np.array(assembled.stiffness), np.array(assembled.damping)
    for part in parts:
        stiffness -= part.motion.T @ part.stiffness @ part.motion
        damping -= part.motion.T @ part.damping @ part.motion
    form = matrix_form(
        dataclasses.replace(assembled, stiffness=stiffness, damping=damping, law_joints=())
    )
    rows = np.concatenate([part.motion for part in parts])
    if form is None or rows[:, form.rest].any():
        return None
    turned = rows[:, form.first] - 1j * form.second_sign * rows[:, form.second]
    places = [slice(2 * at, 2 * at + 2) for at in range(len(parts))]
    return SplitSystem(
        form=form,
        turned=turned,
        stiffness=la.block_diag(*[part.stiffness for part in parts]),
        damping=la.block_diag(*[part.damping for part in parts]),
        laws=tuple((rows, part.law) for rows, part in zip(places, parts, strict=True) if part.law),
    )


def _parts(assembled: AssembledSystem, speed: float) -> Iterator[_Part]:
    """Yield what bearings have beside k̄ I and c̄ I; with a law, less those at a speed."""
    laws = {joint.bearing: joint for joint in assembled.law_joints}
    for bearing in assembled.system.bearings:
        motion, (k, c) = joint_motion(assembled, bearing), bearing.matrices()
        for plane in (slice(0, 2), slice(3, 5)):
            law = laws.get(bearing.name) if plane.start == 0 else None
            if law is None:
                own = (k[plane, plane], c[plane, plane])
                stiffness, damping = (matrix - _mean(matrix) for matrix in own)
            else:
                stiffness, damping = (-_mean(matrix) for matrix in law.coefficients(speed))
            if law is not None or stiffness.any() or damping.any():
                yield _Part(motion[plane], stiffness, damping, law)


def _mean(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.trace(matrix) * np.eye(2))


def solve_split(
    split: SplitSystem, speeds: FloatArray, frequencies: FloatArray, force: ComplexArray
) -> tuple[Solved, BoolArray]:
    """Solve for the lateral response at each point, and say which were left unsolved (p,).

    `speeds`, `frequencies`: Ω and ω ≥ 0 of the points, shape (p,), rad/s. `force`: loads on all
    coordinates, shape (p, n, r); those that a turn does not move are left out. One without load is
    not solved; points near a resonance of the isotropic part or of the system are left unsolved.
    """
    form = split.form
    by_coordinate = force.swapaxes(0, 1)
    loads = np.stack((form.to_complex(by_coordinate), form.to_complex(by_coordinate.conj()).conj()))
    loads = 0.5 * loads.transpose(2, 0, 1, 3)
    circles = np.zeros(loads.shape, dtype=complex)
    residual, unsolved = np.zeros(speeds.size), np.zeros(speeds.size, dtype=bool)
    every = (form.at_speed, speeds, frequencies, loads)
    for points, stack, scale in _stacks(*every, _fill_both):
        coupling = _couplings(split, speeds[points], frequencies[points])
        turned = split.turned * scale[:, 0]
        solved, residual[points], unsolved[points] = _solve_chunk(
            stack, coupling, turned, loads[points] * scale
        )
        circles[points] = solved * scale
    forward, mirrored = circles.transpose(1, 2, 0, 3)
    displacement = form.whirl_shapes(forward, mirrored.conj()).swapaxes(0, 1)
    return Solved(np.ascontiguousarray(displacement), residual), unsolved


def _couplings(split: SplitSystem, speeds: FloatArray, frequencies: FloatArray) -> ComplexArray:
    """Return k + iωc of the coupling at some points, shape (c, r, r)."""
    known, which = np.unique(speeds, return_inverse=True)
    found = np.array([split.coupling(float(speed)) for speed in known])[which]
    return np.asarray(found[:, 0] + 1j * frequencies[:, None, None] * found[:, 1])


def _fill_both(place: ComplexArray, triple: MatrixTriple, omega: float) -> None:
    """Write D(ω) of the forward circle and D(−ω)* of the mirrored backward one."""
    mass, velocity, stiffness = triple
    _fill(place[0], triple, omega)
    _fill(place[1], (mass.conj(), velocity.conj(), stiffness.conj()), omega)


def _solve_chunk(
    stack: ComplexArray, coupling: ComplexArray, turned: ComplexArray, loads: ComplexArray
) -> tuple[ComplexArray, FloatArray, BoolArray]:
    """Return the circles (c, 2, m, r), their residuals, and what is better solved otherwise."""
    sides = np.stack((turned, turned.conj()))
    # Load of a unit force on U q in either circle.
    unit = 0.5 * sides.conj().swapaxes(1, 2)
    right = np.concatenate((loads, np.broadcast_to(unit, (*loads.shape[:2], *unit.shape[1:]))), 3)
    try:
        solution = np.linalg.solve(stack, right)
        alone, per_unit = solution[..., : loads.shape[3]], solution[..., loads.shape[3] :]
        small = np.eye(coupling.shape[1]) + coupling @ (sides @ per_unit).sum(axis=1)
        pull = np.linalg.solve(small, coupling @ (sides @ alone).sum(axis=1))
    except np.linalg.LinAlgError:
        count = loads.shape[0]
        return np.zeros_like(loads), np.zeros(count), np.ones(count, dtype=bool)
    circles = alone - per_unit @ pull[:, None]
    pulled = coupling @ (sides @ circles).sum(axis=1)
    error = loads - stack @ circles - unit @ pulled[:, None]
    residual, growth = _measured(stack, loads, circles, error)
    return circles, residual, ~((residual <= _POOR) & (growth <= _LARGE))


# Points from which on it takes less time to split a system than to solve all at once.
_WORTH_SPLITTING = 24
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
    form = complex_form(assembled)
    many = speeds.size >= _WORTH_SPLITTING
    split = split_system(assembled, float(speeds.mean())) if form is None and many else None
    if form is not None:
        return _by_circles(form, points)
    if split is not None:
        return _by_split(assembled, split, points)
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
    by_coordinate = force.swapaxes(0, 1)
    along = 0.5 * form.to_complex(by_coordinate).swapaxes(0, 1)
    against = 0.5 * form.to_complex(by_coordinate.conj()).swapaxes(0, 1)
    forward = solve_points(form.at_speed, speeds, frequencies, along)
    backward = solve_points(form.at_speed, speeds, -frequencies, against)
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


def _by_split(assembled: AssembledSystem, split: SplitSystem, points: _Points) -> Solved:
    """Solve in circles that the bearings couple; by the full equations where that is poor."""
    lateral, left = solve_split(split, *points)
    solved = _with_rest(split.form, points, lateral)
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
