"""Response of a system to unbalance, each body at its own spin frequency and in its own sense."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.reactions import joint_forces
from solidwhirl.rotordyn.assembly.system import AssembledSystem, at_whirl_ratio
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.reprs import lines_of, row, speed_range
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.search import critical_speeds
from solidwhirl.rotordyn.critical_speeds.undamped import undamped_places
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.response import harmonic_response as harmonic
from solidwhirl.rotordyn.response import resonance_samples as samples
from solidwhirl.rotordyn.response import unbalance_peaks
from solidwhirl.rotordyn.response.orbits import (
    OrbitRecord,
    amplitude_along,
    elliptic_orbits,
)
from solidwhirl.rotordyn.response.resonance_samples import SMOOTH, Pieces

# Bodies whose |speed ratios| differ by less than this fraction excite at one frequency.
_SAME_RATIO = 1e-12
# Resonances below this part of a range of speeds are those of a body free to drift.
NEAR_REST = 1e-4
# At one of these parts of the first speed a response above that part of it does not begin at 0.
_BESIDE_REST, _BEGINS = (1e-2, 1e-1), 1e-3


@dataclass(frozen=True, kw_only=True)
class Unbalance:
    """Place a mass off the axis of a body.

    `body`, `interface`: where; the interface needs ux and uy. `moment_kg_m`: mass times its
    distance from the axis, kg m. `phase_rad`: angle of the mass from +x towards +y at the time 0,
    rad. With the time it turns by speed_ratio · Ω t. Raises AnalysisError if the moment is
    negative or a number is not finite.
    """

    body: str
    interface: str
    moment_kg_m: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        what = f"unbalance at {self.end.label}"
        if not (np.isfinite(self.moment_kg_m) and self.moment_kg_m >= 0):
            raise AnalysisError(
                f"{what}: moment_kg_m is {self.moment_kg_m}; finite and 0 or more is allowed (turn "
                "phase_rad by π for the other side)"
            )
        if not np.isfinite(self.phase_rad):
            raise AnalysisError(f"{what}: phase_rad is {self.phase_rad}; it must be finite")

    @property
    def end(self) -> End:
        """The interface."""
        return End(body=self.body, interface=self.interface)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ExciterResponse(OrbitRecord):
    """Hold the response to all unbalance that turns at one frequency, over the speed.

    `bodies`: bodies with that unbalance; `frequency_ratio`: |speed ratio| of those bodies:
    frequency over Ω; `speeds_rad_s`, `frequencies_rad_s`: Ω and ω = frequency_ratio · Ω, shape
    (s,); `nodes`: all interface nodes of the system. `translation_m`: complex amplitudes of ux,
    uy, time factor e^{iωt}, shape (s, nodes, 2); nan where a node has no such component.
    `tilt_rad`: those of rx, ry, shape (s, nodes, 2); `bearing_forces`: by name of the bearing:
    complex amplitudes of the force in N and moment in N m that its first side exerts on its
    second, shape (s, 6); `relative_residual`: of the equations at each speed, shape (s,).
    """

    bodies: tuple[str, ...]
    frequency_ratio: float
    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    nodes: tuple[End, ...]
    translation_m: ComplexArray
    tilt_rad: ComplexArray
    bearing_forces: Mapping[str, ComplexArray]
    relative_residual: FloatArray

    def __repr__(self) -> str:
        return (
            f"ExciterResponse to {row(self.bodies)} at {self.frequency_ratio:g} times the speed: "
            f"{len(self.nodes)} nodes, {len(self.bearing_forces)} bearings, "
            f"{speed_range(self.speeds_rad_s)}"
        )

    def at_node(self, body: str, interface: str) -> ComplexArray:
        """Return the amplitudes of ux, uy of one node, shape (s, 2), m.

        The angle of an entry is its phase ahead of cos ωt. Raises AnalysisError if there is no such
        node; the message names what exists.
        """
        wanted = End(body=body, interface=interface)
        if wanted not in self.nodes:
            known = [node.label for node in self.nodes]
            raise AnalysisError(f"there is no node {wanted.label}; there are {known}")
        return self.translation_m[:, self.nodes.index(wanted)]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class UnbalanceResponse(ReadOnlyArrays):
    """Hold the response to unbalance over the speed, apart for each frequency.

    Motions of different frequency have no common phase: the largest distance a node can reach is
    the sum of the major axes.

    `unbalances`: what was placed; `speeds_rad_s`: Ω, shape (s,); `exciters`: by rising frequency
    ratio.
    """

    unbalances: tuple[Unbalance, ...]
    speeds_rad_s: FloatArray
    exciters: tuple[ExciterResponse, ...]

    def __repr__(self) -> str:
        placed = row(f"{u.moment_kg_m:.4g} kg m at {u.end.label}" for u in self.unbalances)
        largest = []
        for exciter in self.exciters:
            major = np.nan_to_num(exciter.major_m())
            if major.size:
                at, node = np.unravel_index(int(major.argmax()), major.shape)
                largest.append(
                    f"{row(exciter.bodies)}: largest orbit {major[at, node]:.4g} m at "
                    f"{exciter.nodes[int(node)].label}, "
                    f"{self.speeds_rad_s[at] * RPM_PER_RAD_S:.6g} rpm"
                )
        head = f"UnbalanceResponse to {placed}: {speed_range(self.speeds_rad_s)}"
        return lines_of(head, largest)


def unbalance_response(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    speeds_rad_s: npt.ArrayLike,
    spin_rad_s: float | None = None,
) -> UnbalanceResponse:
    """Compute the steady response to unbalance over a range of speeds.

    `unbalances`: one or more, on bodies that turn; `speeds_rad_s`: Ω ≥ 0 of the reference shaft,
    rad/s, shape (s,). A body at speed ratio r is excited by u (rΩ)², u the moment, at the
    frequency |r| Ω. The force turns with the body, so one that runs against the reference shaft
    excites backward whirl of the system. `spin_rad_s`: speed of the reference shaft for gyroscopic
    terms, spin stress and bearings, while the force turns at `speeds_rad_s`; None: the same. Raises
    AnalysisError if an unbalance or a speed has no meaning, or a speed lies at an undamped
    resonance.
    """
    speeds = harmonic.non_negative("speeds_rad_s", speeds_rad_s)
    exciters = _grouped(assembled, unbalances)
    return UnbalanceResponse(
        unbalances=tuple(unbalances),
        speeds_rad_s=speeds,
        exciters=tuple(
            _exciter(assembled, group, ratio, speeds, spin_rad_s) for ratio, group in exciters
        ),
    )


def spins_at(speeds_rad_s: FloatArray, spin_rad_s: float | None) -> FloatArray:
    """Return Ω of the reference shaft while a force turns at some speeds: these, or one for all."""
    if spin_rad_s is None:
        return speeds_rad_s
    if not (np.isfinite(spin_rad_s) and spin_rad_s >= 0):
        raise AnalysisError(f"spin_rad_s is {spin_rad_s}; finite and 0 or more is allowed")
    return np.full(speeds_rad_s.shape, float(spin_rad_s))


def resolving_speeds(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    speeds_rad_s: npt.ArrayLike,
    spin_rad_s: float | None = None,
) -> FloatArray:
    """Return speeds at which the response to unbalance shows every resonance, however sharp.

    All arguments are as for `unbalance_response`; the speeds rise.
    Returns the speeds and further ones around resonances between them, rising, rad/s. Peaks then
    have their height to 1e-4; without damping they have none, and only their place shows. Raises
    AnalysisError as `unbalance_response`.
    """
    speeds = harmonic.non_negative("speeds_rad_s", speeds_rad_s)
    nodes, resolved = harmonic.interface_nodes(assembled), speeds
    moving = speeds[speeds > 0]
    ends = np.concatenate((moving[:1], moving[-1:]))
    for ratio, group in _grouped(assembled, unbalances):
        pattern = unbalance_loads(assembled, group)

        def respond(
            points: FloatArray, ratio: float = ratio, pattern: ComplexArray = pattern
        ) -> ComplexArray:
            load = pattern[None, :, None]
            spins = spins_at(points, spin_rad_s)
            motion = harmonic.node_response(assembled, nodes, spins, ratio * points, load)
            return np.nan_to_num(motion).reshape(points.size, -1)

        def respond_beside_ends(
            points: FloatArray, respond: Callable[[FloatArray], ComplexArray] = respond
        ) -> ComplexArray:
            # what is too near to a resonance is judged by the stiffness of the whole range
            return respond(np.concatenate((ends, points)))[ends.size :]

        top = float(speeds.max(initial=0.0))
        pieces = response_pieces(assembled, ratio, top, spin_rad_s)
        if spin_rad_s is None:
            roots = _critical_roots(assembled, ratio, top)
        else:
            roots = modes_at_speed(assembled, spin_rad_s).eigenvalues / ratio
        around = samples.samples_around_modes(speeds, roots)
        more = np.union1d(samples.resolving_samples(speeds, respond, pieces), around)
        more = samples.computable_samples(np.setdiff1d(more, speeds), respond_beside_ends)
        for found in (more, _place_beside_rest(speeds, respond)):
            resolved = samples.with_knots(resolved, found)
    return resolved


def _place_beside_rest(
    speeds: FloatArray, respond: Callable[[FloatArray], ComplexArray]
) -> FloatArray:
    """Return a speed just above rest if the response does not begin at 0 there, else none.

    A free body turns about its centre of gravity from the slowest speed on; with stiffness the
    response rises with Ω².
    """
    moving = speeds[speeds > NEAR_REST * speeds.max(initial=0.0)]
    if not moving.size or speeds[0] > 0:
        return np.empty(0)
    for fraction in _BESIDE_REST:
        # the force of the unbalance is per Ω²
        with suppress(AnalysisError):  # rounding in K holds a free body there: further from rest
            slow, first = np.abs(respond(fraction * moving[0] * np.array([1.0, 1.0 / fraction])))
            begins = fraction**2 * slow.max(initial=0.0) > _BEGINS * first.max(initial=0.0)
            return np.array([fraction * moving[0]]) if begins else np.empty(0)
    return np.empty(0)


def _critical_roots(assembled: AssembledSystem, ratio: float, top: float) -> ComplexArray:
    """λ over the ratio at damped critical speeds: what samples alone may not show as resonance."""
    if top == 0 or assembled.is_conservative:
        return np.empty(0, dtype=complex)
    try:
        found = critical_speeds(assembled, ratio, top)
    except AnalysisError:  # hints only: a free body that whirls at every speed has none
        found = ()
    roots = [c.speed_rad_s * complex(-c.log_decrement / (2.0 * np.pi), 1.0) for c in found]
    roots = [root for root in roots if root.real and root.imag > NEAR_REST * top]
    return np.array(roots, dtype=complex)


def response_pieces(
    assembled: AssembledSystem,
    ratio: float,
    speed_max_rad_s: float,
    spin_rad_s: float | None = None,
) -> Pieces:
    """Return where a response to unbalance is no longer smooth over Ω, and where it may resonate.

    `ratio`: frequency over Ω, not 0; `speed_max_rad_s`: largest Ω looked at; `spin_rad_s`: as for
    `unbalance_response`. Returns knots of the speed laws and critical speeds without damping;
    neither where no bearing depends on the speed, or all is at one spin, as the response is one
    rational function then.
    """
    if assembled.has_constant_bearings or speed_max_rad_s == 0 or spin_rad_s is not None:
        return SMOOTH
    assembled = at_whirl_ratio(assembled, ratio)
    try:
        places = undamped_places(assembled, abs(ratio), speed_max_rad_s)
    except AnalysisError:  # hints only: a free body that whirls at every speed has none
        places = np.empty(0)
    return Pieces(np.array(assembled.knots_rad_s), places)


def _grouped(
    assembled: AssembledSystem, unbalances: Sequence[Unbalance]
) -> list[tuple[float, list[Unbalance]]]:
    """Unbalances that turn at one frequency together, by rising frequency ratio."""
    if not unbalances:
        raise AnalysisError("unbalances is empty; one or more are needed")
    groups: list[list[Unbalance]] = []
    ratios: list[float] = []
    for unbalance in unbalances:
        ratio = frequency_ratio(assembled, unbalance)
        same = [abs(ratio - known) <= _SAME_RATIO * known for known in ratios]
        if any(same):
            groups[same.index(True)].append(unbalance)
        else:
            ratios.append(ratio)
            groups.append([unbalance])
    return [(ratios[i], groups[i]) for i in np.argsort(ratios)]


def frequency_ratio(assembled: AssembledSystem, unbalance: Unbalance) -> float:
    """Return the frequency of an unbalance over the speed Ω.

    Returns |speed ratio| of the body. Raises AnalysisError if the place does not exist or lacks ux
    or uy, or the body does not turn.
    """
    what = f"unbalance at {unbalance.end.label}"
    harmonic.check_lateral(assembled, unbalance.end, what)
    ratio = abs(assembled.system.rotors[unbalance.body].speed_ratio)
    if ratio == 0:
        raise AnalysisError(f"{what}: the body has speed ratio 0 and does not turn")
    return float(ratio)


def turning_load(assembled: AssembledSystem, unbalance: Unbalance) -> ComplexArray:
    """Return the load of an unbalance per square of its frequency.

    Returns f/ω² on the coordinates of its body, shape (n_body,), kg m, for the time factor e^{iωt}
    with ω > 0: turning with +Ω for a positive speed ratio (f_y = −i f_x), else against it.
    """
    rotor = assembled.system.rotors[unbalance.body]
    sense = 1.0 if rotor.speed_ratio > 0 else -1.0
    load = np.zeros(rotor.element.size, dtype=complex)
    force = unbalance.moment_kg_m * np.exp(1j * sense * unbalance.phase_rad)
    load[rotor.element.interface_index(unbalance.interface, "ux")] = force
    load[rotor.element.interface_index(unbalance.interface, "uy")] = -1j * sense * force
    return load


def unbalance_loads(assembled: AssembledSystem, unbalances: Sequence[Unbalance]) -> ComplexArray:
    """Return the load of some unbalances per square of their common frequency.

    `unbalances`: one or more that turn at one frequency. Returns f/ω² on the independent
    coordinates, shape (n,), kg m.
    """
    return harmonic.independent_loads(assembled, _patterns(assembled, unbalances))


def _patterns(
    assembled: AssembledSystem, unbalances: Sequence[Unbalance]
) -> dict[str, ComplexArray]:
    """Loads of unbalances per square of their frequency, by body."""
    patterns: dict[str, ComplexArray] = {}
    for unbalance in unbalances:
        load = turning_load(assembled, unbalance)
        patterns[unbalance.body] = patterns.get(unbalance.body, 0.0) + load
    return patterns


def _exciter(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    ratio: float,
    speeds: FloatArray,
    spin_rad_s: float | None,
) -> ExciterResponse:
    """Return the response to unbalances of one frequency."""
    if spin_rad_s is None:
        assembled = at_whirl_ratio(assembled, ratio)
    elif assembled.depends_on_frequency:
        raise AnalysisError(
            "bearings whose force depends on the frequency are not computed at a spin other than "
            "that of the unbalance"
        )
    patterns = _patterns(assembled, unbalances)
    omega, spins = ratio * speeds, spins_at(speeds, spin_rad_s)
    square = (omega**2)[:, None]
    loads = square * harmonic.independent_loads(assembled, patterns)
    solved = harmonic.harmonic_response(assembled, spins, omega, loads[:, :, None])
    motion = solved.displacement[:, :, 0]
    forces = joint_forces(
        assembled,
        spins,
        motion,
        1j * omega[:, None] * motion,
        -square * motion,
        {body: square * pattern for body, pattern in patterns.items()},
    ).bearings
    for force in forces.values():
        force.setflags(write=False)
    nodes = harmonic.interface_nodes(assembled)
    return ExciterResponse(
        bodies=tuple(patterns),
        frequency_ratio=ratio,
        speeds_rad_s=speeds,
        frequencies_rad_s=omega,
        nodes=nodes,
        translation_m=harmonic.node_amplitudes(assembled, nodes, harmonic.TRANSLATIONS, motion),
        tilt_rad=harmonic.node_amplitudes(assembled, nodes, harmonic.TILTS, motion),
        bearing_forces=forces,
        relative_residual=solved.relative_residual,
    )


def orbit_peaks(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    frequencies_rad_s: npt.ArrayLike,
    major_m: npt.ArrayLike,
    least_m: npt.ArrayLike = 0.0,
    spin_rad_s: float | None = None,
) -> tuple[unbalance_peaks.ResonancePeak, ...]:
    """Find the peaks of an orbit over the frequency, each where the response is highest.

    `unbalances`: all that turn at one frequency; `node`: interface whose orbit it is;
    `frequencies_rad_s`, `major_m`: sampled, rising ω > 0 and major half axes, shape (s,) each;
    `least_m`: peaks up to this height are rounding and left out, shape (s,) or a number;
    `spin_rad_s`: as for `unbalance_response`. Without damping peaks have no height: they stay as
    they were sampled. Raises AnalysisError if the samples do not fit or do not rise.
    """
    omega, major = np.asarray(frequencies_rad_s, dtype=float), np.asarray(major_m, dtype=float)
    least = np.broadcast_to(np.asarray(least_m, dtype=float), omega.shape)
    height = _height(
        assembled,
        unbalances,
        node,
        lambda x, y: float(elliptic_orbits(x, y).major_m),
        spin_rad_s,
    )
    return _refined(assembled, unbalances, omega, major, least, height)


def probe_peaks(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    direction_rad: float,
    frequencies_rad_s: npt.ArrayLike,
    amplitude_m: npt.ArrayLike,
) -> tuple[unbalance_peaks.ResonancePeak, ...]:
    """Find the peaks of what a probe sees over the frequency, as `orbit_peaks`.

    `direction_rad`: in which the probe looks, from +x towards +y; `amplitude_m`: of the motion
    along it, shape (s,).
    """
    omega, seen = np.asarray(frequencies_rad_s, dtype=float), np.asarray(amplitude_m, dtype=float)
    height = _height(
        assembled, unbalances, node, lambda x, y: float(abs(amplitude_along(x, y, direction_rad)))
    )
    return _refined(assembled, unbalances, omega, seen, np.zeros_like(omega), height)


def _height(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    size: Callable[[complex, complex], float],
    spin_rad_s: float | None = None,
) -> Callable[[float], float]:
    """Return the size of the motion of a node as a function of the frequency."""
    ratio = frequency_ratio(assembled, unbalances[0])
    pattern = unbalance_loads(assembled, unbalances)

    def height(at: float) -> float:
        load = (at**2 * pattern)[None, :, None]
        spin = spins_at(np.array([at / ratio]), spin_rad_s)
        x, y = harmonic.node_response(assembled, [node], spin, [at], load)[0, 0]
        return size(x, y)

    return height


def _refined(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    omega: FloatArray,
    sampled: FloatArray,
    least: FloatArray,
    height: Callable[[float], float],
) -> tuple[unbalance_peaks.ResonancePeak, ...]:
    """Return the peaks of samples that are more than rounding, at the summits of the curve."""
    peaks = [
        peak
        for peak in unbalance_peaks.resonance_peaks(omega, sampled)
        if peak.amplitude > np.interp(peak.position_rad_s, omega, least)
    ]
    if assembled.is_conservative or not peaks:
        return tuple(peaks)
    ratio = frequency_ratio(assembled, unbalances[0])
    knots = ratio * np.array(at_whirl_ratio(assembled, ratio).knots_rad_s)
    return unbalance_peaks.refined_peaks(peaks, omega, sampled, height, knots)
