"""Steady motion of a system in the frame that turns with it, and what of it is seen at rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import Bearing, End
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.parametric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, PeriodicSystem, Term
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.whirl import interface_rows_of_all
from solidwhirl.rotordyn.response.harmonic_response import interface_nodes
from solidwhirl.rotordyn.response.orbits import OrbitRecord

# Part of the largest harmonic below which the last ones of an expansion have to be; and how many
# there are on either side of those that are loaded, one number after the other until they are.
_SMALL, _ORDERS = 1e-7, (4, 8, 16, 32)
# What stiffness does to free motions, relative to others; and how far above the speed these are
# held.
_FREE, _FAR_ABOVE = 1e-7, 100.0
# Motions of an interface across the axis, ux, uy, rx, ry, and along and about it, uz and rz.
_ACROSS, _ALONG = (0, 1, 3, 4), (2, 5)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SteadyResponse(OrbitRecord):
    """Hold steady motion at interfaces in fixed axes, by multiples of the speed of the frame.

    `speeds_rad_s`: of the frame, shape (s,). `multiples`: h, rising from 0, shape (h,).
    `translation_m`, `tilt_rad`: complex amplitudes of ux, uy and of rx, ry with the time factor
    e^{ihθ}, shape (s, h, nodes, 2); of h = 0 the constant motion. `bearing_forces`: by bearing,
    that its first side exerts on its second, N and N m, shape (s, h, 6).
    """

    speeds_rad_s: FloatArray
    multiples: IntArray
    nodes: tuple[End, ...]
    translation_m: ComplexArray
    tilt_rad: ComplexArray
    bearing_forces: Mapping[str, ComplexArray]


def steady_motion(periodic: PeriodicSystem, speed_rad_s: float, loads: Harmonics) -> Harmonics:
    """Return q = Σ e^{ihθ} q_h, (n,) each, of a steady motion under loads Σ e^{ihθ} f_h.

    Raises AnalysisError as `driven_motion`.
    """
    columns = {h: load[:, None] for h, load in loads.items()}
    found = driven_motion(periodic, speed_rad_s, np.zeros(1), columns)
    return {h: q[0, :, 0] for h, q in found.items()}


def driven_motion(
    periodic: PeriodicSystem, speed_rad_s: float, frequencies_rad_s: FloatArray, loads: Harmonics
) -> Harmonics:
    """Return q = Σ e^{i(ω + hΩ)t} q_h of motions under loads Σ e^{i(ω + hΩ)t} f_h.

    `frequencies_rad_s`: ω, (f,). `loads`: r of them, (n, r) by harmonic. Returns (f, n, r) by
    harmonic. Harmonics are added until the last ones are small. Raises AnalysisError: they do not
    become so, or an undamped resonance is hit exactly.
    """
    stride, count = periodic.stride, frequencies_rad_s.size
    groups: dict[int, Harmonics] = {}
    for harmonic, load in loads.items():
        groups.setdefault(harmonic % stride if stride else harmonic, {})[harmonic] = load
    out: Harmonics = {}
    for offset, given in groups.items():
        left = np.arange(count)
        for order in _ORDERS:
            some = frequencies_rad_s[left]
            found = _expanded(periodic, speed_rad_s, some, given, (offset, order))
            for h, q in found.items():
                out.setdefault(h, np.zeros((count, *q.shape[1:]), dtype=complex))[left] = q
            left = left[_goes_on(found, stride)]
            if not left.size:
                break
        else:
            raise AnalysisError(
                f"at {_place(speed_rad_s, some[:1])} the multiples of the speed in the steady "
                f"motion do not die out up to {_ORDERS[-1] * stride}; give the bearings damping, "
                "or leave the speed out"
            )
    return out


def _goes_on(found: Harmonics, stride: int) -> BoolArray:
    """Where the last harmonics of any of the motions are not yet small, (f,)."""
    sizes = np.array([np.abs(found[h]).max(axis=1) for h in sorted(found)])
    ends = sizes[[0, 1, -2, -1] if stride == 1 else [0, -1]].max(axis=0)
    large = (ends > _SMALL * sizes.max(axis=0)).any(axis=1)
    return np.asarray(large if stride else np.zeros_like(large))


def _place(speed: float, frequencies: FloatArray) -> str:
    """Speed and frequencies, as messages tell them."""
    said = f"{speed * RPM_PER_RAD_S:.10g} rpm of the asymmetric bodies"
    low, high = (float(end) / (2.0 * np.pi) for end in (frequencies.min(), frequencies.max()))
    if not high:
        return said
    return f"{said} and {low:.6g} Hz" + (f" to {high:.6g} Hz" if high > low else "")


def _expanded(
    periodic: PeriodicSystem,
    speed: float,
    frequencies: FloatArray,
    given: Harmonics,
    span: tuple[int, int],
) -> Harmonics:
    """Motions with the harmonics offset + k · stride, group by group from one end to the other.

    A group has as many harmonics as the matrices reach over, so that it meets its neighbours alone.
    `span`: offset, and the number of harmonics on either side of those that are loaded.
    """
    block = _blocks(periodic, speed, frequencies)
    groups = _groups(periodic, speed, given, span)
    none = np.zeros_like(next(iter(given.values())))
    answers: list[tuple[ComplexArray, ComplexArray]] = []
    for k, own in enumerate(groups):
        matrix = block(own, own)
        load = np.concatenate([given.get(h, none) for h in own])
        load = np.broadcast_to(load, (len(matrix), *load.shape))
        if k:
            lower, (before, moved) = block(own, groups[k - 1]), answers[-1]
            matrix, load = matrix - lower @ before, load - lower @ moved
        upper = block(own, groups[k + 1] if k + 1 < len(groups) else [])
        try:
            both = np.linalg.solve(matrix, np.concatenate((upper, load), axis=2))
        except np.linalg.LinAlgError:
            raise AnalysisError(
                f"{_place(speed, frequencies)} is an undamped resonance, where no steady motion "
                "exists; give the bearings damping, or leave the speed out"
            ) from None
        answers.append((both[..., : upper.shape[2]], both[..., upper.shape[2] :]))
    motion = answers[-1][1]
    found = [motion]
    for beyond, own_motion in reversed(answers[:-1]):
        motion = own_motion - beyond @ motion
        found.insert(0, motion)
    every = np.concatenate(found, axis=1).reshape(
        len(frequencies), -1, periodic.size, none.shape[1]
    )
    return dict(zip((h for g in groups for h in g), every.swapaxes(0, 1), strict=True))


def _groups(
    periodic: PeriodicSystem, speed: float, given: Harmonics, span: tuple[int, int]
) -> list[list[int]]:
    """Harmonics of an expansion, in groups as wide as the matrices reach."""
    (offset, order), stride = span, periodic.stride
    if not stride:
        return [[offset]]
    first = max(abs(h - offset) // stride for h in given)
    reach = max(abs(h) // stride for parts in periodic.at(speed) for h in parts)
    width = max(reach, 1)
    count = 2 * ((first + order) // width) + 1
    start = offset - stride * (count * width // 2)
    return [[start + stride * (width * g + k) for k in range(width)] for g in range(count)]


def _blocks(
    periodic: PeriodicSystem, speed: float, frequencies: FloatArray
) -> Callable[[Sequence[int], Sequence[int]], ComplexArray]:
    """Return what makes the rows and columns of some harmonics, (f, rows · n, columns · n)."""
    n, (velocity, stiffness) = periodic.size, periodic.at(speed)

    def block(rows: Sequence[int], columns: Sequence[int]) -> ComplexArray:
        out = np.zeros((frequencies.size, len(rows), n, len(columns), n), dtype=complex)
        for j, other in enumerate(columns):
            rate = (frequencies + other * speed)[:, None, None]
            for i, h in enumerate(rows):
                out[:, i, :, j] = stiffness.get(h - other, 0.0)
                if h - other in velocity:
                    out[:, i, :, j] += 1j * rate * velocity[h - other]
                if h == other:
                    out[:, i, :, j] -= rate**2 * periodic.mass
        return out.reshape(len(out), len(rows) * n, len(columns) * n)

    return block


def held_where_free(rotating: RotatingSystem, speed_rad_s: float) -> PeriodicSystem:
    """Return the matrices of an engine whose free motions along and about the axis are held.

    A shaft that may turn about its axis or slide along it, where no stiffness acts at rest, has no
    answer to a steady load there; the drive keeps its speed. A stiffness on their mean at the
    interfaces puts their frequencies far above `speed_rad_s`, the highest that is looked at.
    """
    periodic = rotating.periodic
    root = np.sqrt(np.diag(periodic.mass))
    acting = [t.matrix / root for t in periodic.stiffness if t.power == 0]
    for _, motion in periodic.laws:
        acting += [part / root for part in motion.values()]
    seats = interface_rows_of_all(rotating).reshape(-1, 6, periodic.size)
    acting += [seat[list(_ACROSS)] / root for seat in seats]
    rows = np.vstack([m for a in acting for m in (a.real, a.imag)])
    sizes = np.abs(rows).max(axis=1, initial=0.0)
    rows = rows[sizes > 0.0] / sizes[sizes > 0.0, None]
    _, values, vectors = la.svd(rows, full_matrices=True)
    rank = int((values > _FREE * values.max(initial=0.0)).sum())
    if rank == periodic.size:
        return periodic
    free = vectors[rank:].T / root[:, None]
    along = seats[:, list(_ALONG)].reshape(-1, periodic.size)
    mean = la.solve(free.T @ along.T @ along @ free, free.T @ along.T @ along)
    inertia = free.T @ periodic.mass @ free
    held = (_FAR_ABOVE * speed_rad_s) ** 2 * mean.T @ inertia @ mean
    return replace(periodic, stiffness=(*periodic.stiffness, Term(0, 0, held)))


def dynamic_stiffness(
    periodic: PeriodicSystem, speed_rad_s: complex, offset: int, order: int
) -> ComplexArray:
    """Return λ²M + λV + K of Hill's expansion at λ = i · offset · speed."""
    block = hill_block(periodic, order)
    velocity, stiffness = block.at(speed_rad_s)  # type: ignore[arg-type]
    rate = 1j * offset * speed_rad_s
    return np.asarray(rate**2 * block.mass + rate * velocity + stiffness)


def steady_response(
    rotating: RotatingSystem,
    speeds_rad_s: npt.ArrayLike,
    *,
    constant: Harmonics | None = None,
    centrifugal: FloatArray | None = None,
) -> SteadyResponse:
    """Return the steady motion of all interfaces over the speed of the frame.

    `constant`: loads by harmonic, (n,) each, as of `gravity_force` and `bow_force`. `centrifugal`:
    load at unit speed that turns with the frame, (n,), as of `own_unbalance`.
    """
    speeds = np.atleast_1d(np.asarray(speeds_rad_s, dtype=float))
    periodic = held_where_free(rotating, float(speeds.max(initial=1.0)))
    nodes = interface_nodes(rotating)
    seats = [rotating.seat(node) for node in nodes]
    moved, forces = [], []
    for speed in speeds:
        loads = dict(constant or {})
        if centrifugal is not None:
            loads[0] = loads.get(0, 0.0) + speed**2 * centrifugal
        found = steady_motion(periodic, float(speed), loads)
        moved.append([seen(seat, found) for seat in seats])
        forces.append([_forces(rotating, b, found, float(speed)) for b in rotating.system.bearings])
    top = max((h for at in moved for node in at for h in node), default=0)
    motion = np.array([[_amplitudes(node, top) for node in at] for at in moved])
    force = {
        bearing.name: np.array([_amplitudes(at[k], top) for at in forces])
        for k, bearing in enumerate(rotating.system.bearings)
    }
    motion = motion.transpose(0, 2, 1, 3)
    return SteadyResponse(
        speeds_rad_s=speeds,
        multiples=np.arange(top + 1),
        nodes=nodes,
        translation_m=motion[..., :2],
        tilt_rad=motion[..., 3:5],
        bearing_forces=force,
    )


def seen(seat: Harmonics, motion: Harmonics) -> Harmonics:
    """Return Σ D_a q_{h−a} by harmonic h: what is seen in fixed axes of a motion q."""
    out: Harmonics = {}
    for a, part in seat.items():
        for b, q in motion.items():
            out[a + b] = out.get(a + b, 0.0) + part @ q
    return out


def _forces(
    rotating: RotatingSystem, bearing: Bearing, motion: Harmonics, speed: float
) -> Harmonics:
    """Force of a bearing's first side on its second by harmonic, (6,) each."""
    spring, drag = bearing.matrices()
    for joint, _ in rotating.periodic.laws:
        if joint.bearing == bearing.name:
            spring[:2, :2], drag[:2, :2] = joint.coefficients(speed)
    relative = seen(rotating.relative(bearing), motion)
    return {h: spring @ u + 1j * h * speed * drag @ u for h, u in relative.items()}


def _amplitudes(parts: Harmonics, top: int) -> ComplexArray:
    """Amplitudes A_h, (top + 1, 6), of Re A_h e^{ihθ}, of parts of h and −h."""
    out = np.zeros((top + 1, 6), dtype=complex)
    for h, part in parts.items():
        if h >= 0:
            out[h] = part if h == 0 else 2.0 * part
    return out


def speeds_with(speeds: npt.ArrayLike, places: Sequence[float]) -> FloatArray:
    """Return speeds with others put among them, rising."""
    given = np.asarray(speeds, dtype=float)
    inside = [p for p in places if given.min() <= p <= given.max()]
    return np.asarray(np.unique(np.concatenate([given, inside])))
