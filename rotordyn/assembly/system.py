"""Assembly of rotors, bearings and gears into the matrices of one system."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly import parts
from solidwhirl.rotordyn.assembly.bearing_laws import (
    SpeedLaw,
    follows_spin,
    law_parts,
    law_pieces,
)
from solidwhirl.rotordyn.assembly.coordinates import (
    Placed,
    Rows,
    joint_motion,
    sensed_motion,
    tooth_motion,
)
from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyLaw, frequency_law
from solidwhirl.rotordyn.assembly.internal_damping import body_damping
from solidwhirl.rotordyn.assembly.joints import independent_coordinates
from solidwhirl.rotordyn.assembly.law_pieces import LawPieces
from solidwhirl.rotordyn.assembly.parts import Bearing, Gear, Rotor, System
from solidwhirl.rotordyn.core.arrays import (
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
    freeze_arrays,
)
from solidwhirl.rotordyn.core.errors import AnalysisError, AssemblyError
from solidwhirl.rotordyn.core.reprs import lines_of
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices, free_body_problems

# A turn of the system is one of its independent coordinates if it misses by less than this.
_SAME_TURN = 1e-9


class SpeedMatrices(NamedTuple):
    """M, C, Ω-scaled G and K of the system at one speed, each (n, n)."""

    mass: FloatArray
    damping: FloatArray
    gyroscopic: FloatArray
    stiffness: FloatArray

    def part(self, at: IntArray) -> SpeedMatrices:
        """Return the matrices of some coordinates, which nothing joins to the others."""
        block = np.ix_(at, at)
        return SpeedMatrices(*(matrix[block] for matrix in self))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LawJoint:
    """Hold a bearing whose coefficients depend on the speed.

    `speed_ratio`: the law is taken at |speed_ratio · Ω|; `stiffness_n_per_m`, `damping_n_s_per_m`:
    the bearing's own coefficients, which the law scales, shape (2, 2); `motion`: relative ux and
    uy of the bearing per independent coordinate, shape (2, n). `pieces`: the coefficients as
    polynomials of |Ω|; None of a law that does not tell them, of whose structure nothing is known
    then. A law that depends on the frequency of the motion is taken at that of the spin, see
    `at_whirl_ratio` and `at_rate`; `motion` has the tilts as well where it joins them.
    A bearing whose law is made of several has a joint for each. `rows`: what `motion` is of ux to
    rz, shape (2, 6); of a magnetic bearing of the magnets alone.
    """

    bearing: str
    law: SpeedLaw
    speed_ratio: float
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    motion: FloatArray
    rows: FloatArray
    pieces: LawPieces | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        freeze_arrays(self, "stiffness_n_per_m", "damping_n_s_per_m", "motion", "rows")
        found = law_pieces(self.law, self.stiffness_n_per_m, self.damping_n_s_per_m)
        over = None if found is None else found.over_reference(self.speed_ratio)
        object.__setattr__(self, "pieces", over)

    @property
    def knots_rad_s(self) -> tuple[float, ...]:
        """Speeds Ω > 0 of the reference shaft at which a table has its knots, rising."""
        return () if self.pieces is None else self.pieces.knots_rad_s

    @property
    def frequency_law(self) -> FrequencyLaw | None:
        """The law if it depends on the frequency, else None."""
        return frequency_law(self.law)

    def with_law(self, law: SpeedLaw) -> LawJoint:
        """Return the joint with another law."""
        return dataclasses.replace(self, law=law)

    def coefficients_along(self, speeds_rad_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping at speeds Ω of shape (s,), (s, 2, 2) each."""
        if self.pieces is not None:
            return self.pieces.along(np.abs(speeds_rad_s))
        known, which = np.unique(speeds_rad_s, return_inverse=True)
        found = np.array([self.coefficients(float(value)) for value in known])[which]
        return found[:, 0], found[:, 1]

    def coefficients(self, speed_rad_s: float) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping (2, 2) at a speed Ω of the reference shaft."""
        if self.pieces is not None:
            return self.pieces.at(abs(speed_rad_s))
        found = self.law.coefficients(
            abs(self.speed_ratio * speed_rad_s), self.stiffness_n_per_m, self.damping_n_s_per_m
        )
        return found.stiffness_n_per_m, found.damping_n_s_per_m


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class AssembledSystem(ReadOnlyArrays):
    """Hold the matrices of a system in n independent coordinates.

    M q'' + (C + Ω G) q' + (K + Ω² K2 + Ω N) q = f in the inertial frame, plus ½ Ω' G q while the
    speed varies, plus the bearings with a speed law. `matrices_at_speed` sums them up.

    `system`: what was assembled; `mass`, `stiffness`, `damping`: M, K (elastic, with constant
    bearings and gears) and C (with the part of the internal damping that acts on q'), shape (n,
    n); `gyroscopic`: Σ n_i G_i with the speed ratios n_i, shape (n, n); `centrifugal_stiffness`:
    K2 = Σ n_i² (Kgeo − S)_i, shape (n, n); `circulatory_stiffness`: N = −Σ n_i C_i L_i of the
    internal damping C_i of the bodies, shape (n, n); `law_joints`: bearings that depend on the
    speed. `spin_generator`: L of a turn of the whole system about the axis, shape (n, n); None
    where a body does not know its own, or where joints are not the same in all directions.
    `transformation`: coordinates of all bodies from the n independent ones, shape (N, n); entries
    0 and 1 but for gears. `body_slices`: rows of `transformation` that belong to each body;
    `speed_limit_rad_s`: largest |Ω| at which no body runs faster than its basis was made for.
    `body_rate`: largest K_ii / M_ii of the bodies without bearings, (rad/s)²; the rounding in K is
    of the order of eps times that.
    """

    system: System
    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    centrifugal_stiffness: FloatArray
    damping: FloatArray
    circulatory_stiffness: FloatArray
    law_joints: tuple[LawJoint, ...] = ()
    spin_generator: FloatArray | None = None
    transformation: FloatArray
    body_slices: Mapping[str, slice]
    speed_limit_rad_s: float
    body_rate: float

    def __repr__(self) -> str:
        kind = "undamped" if self.is_conservative else "damped"
        bodies = parts.body_count(self.system)
        head = f"AssembledSystem of {bodies}: {self.size} coordinates, {kind}"
        return lines_of(head, parts.parts_lines(self.system))

    @property
    def size(self) -> int:
        """Number of independent coordinates n."""
        return int(self.mass.shape[0])

    @property
    def knots_rad_s(self) -> tuple[float, ...]:
        """Speeds Ω > 0 at which a speed law has a knot, rising: every search looks at them."""
        return tuple(sorted({knot for joint in self.law_joints for knot in joint.knots_rad_s}))

    @property
    def frequency_laws(self) -> tuple[FrequencyLaw, ...]:
        """Laws of the bearings whose force depends on the frequency of the motion."""
        laws = (joint.frequency_law for joint in self.law_joints)
        return tuple(law for law in laws if law is not None)

    @property
    def depends_on_frequency(self) -> bool:
        """Whether the force of a bearing depends on the frequency of the motion."""
        return bool(self.frequency_laws)

    @property
    def has_constant_bearings(self) -> bool:
        """Whether no bearing depends on the speed."""
        return not self.law_joints

    @property
    def has_symmetric_joints(self) -> bool:
        """Whether the stiffness of every bearing is symmetric at all speeds, by its data."""
        return _has_symmetric_joints(self)

    @property
    def is_conservative(self) -> bool:
        """Whether there is no damping at any speed and K is symmetric."""
        return _is_conservative(self)


# A system is a record that never changes, and every eigenproblem of it asks.
@lru_cache(maxsize=16)
def _has_symmetric_joints(assembled: AssembledSystem) -> bool:
    own = (bearing.matrices()[0] for bearing in assembled.system.bearings)
    laws = (joint.pieces for joint in assembled.law_joints)
    return all(np.array_equal(k, k.T) for k in own) and all(
        pieces is not None and pieces.has_symmetric_stiffness for pieces in laws
    )


@lru_cache(maxsize=16)
def _is_conservative(assembled: AssembledSystem) -> bool:
    still = not assembled.damping.any() and not assembled.circulatory_stiffness.any()
    undamped = all(j.pieces is not None and j.pieces.is_undamped for j in assembled.law_joints)
    symmetric = np.array_equal(assembled.stiffness, assembled.stiffness.T)
    return still and undamped and symmetric and assembled.has_symmetric_joints


def assemble(
    rotors: Mapping[str, Rotor],
    bearings: tuple[Bearing, ...],
    reference: str | None = None,
    gears: tuple[Gear, ...] = (),
) -> AssembledSystem:
    """Assemble rotors, bearings and gears.

    `reference`: name of the shaft whose speed is Ω; None when Ω is only a parameter. Returns all
    matrices; exact constraints are eliminated. Its bearings are those that act: see
    `Bearing.cross_coupling` for shafts that turn backward. Raises AssemblyError if names,
    components or shapes do not fit; all faults are listed at once.
    """
    asymmetric = [name for name, rotor in rotors.items() if rotor.element.frame == "rotating"]
    if asymmetric:
        raise AssemblyError(
            (
                f"rotors {asymmetric} are asymmetric: in fixed axes their matrices change "
                "with the angle; `asymmetric.assemble_rotating` puts them together",
            )
        )
    system = checked_system(
        System(
            rotors=dict(rotors), bearings=tuple(bearings), reference=reference, gears=tuple(gears)
        )
    )
    rotors, slices = system.rotors, body_slices_of(system)
    transformation = independent_coordinates(system, slices)
    rows = Rows(system, slices, transformation)
    bodies = [free_body_matrices(rotor.element) for rotor in rotors.values()]
    rotating = [body_damping(r, body) for r, body in zip(rotors.values(), bodies, strict=True)]

    def joined(matrices: Sequence[FloatArray], power: int) -> FloatArray:
        ratios = (rotor.speed_ratio**power for rotor in rotors.values())
        blocks = [ratio * matrix for ratio, matrix in zip(ratios, matrices, strict=True)]
        return np.asarray(transformation.T @ la.block_diag(*blocks) @ transformation)

    supports, damping = _joint_matrices(rows)
    gyroscopic = joined([body.gyroscopic for body in bodies], 1)
    centrifugal = [body.centrifugal_stiffness for body in bodies]
    elements = [rotor.element for rotor in rotors.values()]
    return AssembledSystem(
        system=system,
        mass=_symmetric(joined([body.mass for body in bodies], 0)),
        stiffness=_symmetric(joined([body.stiffness for body in bodies], 0)) + supports,
        gyroscopic=0.5 * (gyroscopic - gyroscopic.T),
        centrifugal_stiffness=_symmetric(joined(centrifugal, 2)),
        damping=_symmetric(joined([one.damping for one in rotating], 0)) + damping,
        circulatory_stiffness=joined([one.circulatory for one in rotating], 1),
        law_joints=_law_joints(rows),
        spin_generator=_spin_generator(system, transformation),
        transformation=transformation,
        body_slices=slices,
        speed_limit_rad_s=speed_limit(system),
        body_rate=max(float(np.max(np.diag(e.stiffness) / np.diag(e.mass))) for e in elements),
    )


def checked_system(system: System) -> System:
    """Return the system with the bearings that act, or raise all its faults (AssemblyError)."""
    problems = parts.find_problems(system)
    if not problems:
        system = dataclasses.replace(system, bearings=_with_spin(system))
    for name, rotor in system.rotors.items():
        problems += tuple(f"rotor {name!r}: {text}" for text in free_body_problems(rotor.element))
    if problems:
        raise AssemblyError(problems)
    return system


def matrices_at_speed(assembled: AssembledSystem, speed_rad_s: float) -> SpeedMatrices:
    """Return the matrices of a system at one speed.

    `speed_rad_s`: Ω, rad/s. Returns M, C(Ω), ΩG and K(Ω) + Ω²K2 + ΩN.
    """
    stiffness = assembled.stiffness + speed_rad_s**2 * assembled.centrifugal_stiffness
    if assembled.circulatory_stiffness.any():
        stiffness = stiffness + speed_rad_s * assembled.circulatory_stiffness
    damping = assembled.damping
    for joint in assembled.law_joints:
        k, c = joint.coefficients(speed_rad_s)
        stiffness = stiffness + joint.motion.T @ k @ joint.motion
        damping = damping + joint.motion.T @ c @ joint.motion
    return SpeedMatrices(
        mass=assembled.mass,
        damping=damping,
        gyroscopic=speed_rad_s * assembled.gyroscopic,
        stiffness=stiffness,
    )


def bearing_matrices(
    assembled: AssembledSystem, bearing: Bearing, speed_rad_s: float
) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and damping of a bearing on ux, uy, uz, rx, ry, rz at a speed, (6, 6).

    Of a magnetic bearing as if its sensors were at the magnets; see `bearing_force_rows`.
    """
    joints = [joint for joint in assembled.law_joints if joint.bearing == bearing.name]
    stiffness, damping = bearing.matrices()
    if joints:
        stiffness[:2, :2] = damping[:2, :2] = 0.0
    for joint in joints:
        for matrix, own in zip((stiffness, damping), joint.coefficients(speed_rad_s), strict=True):
            if bearing.sensor is not None:
                own = own[:2, :2] + own[:2, 2:]
            matrix += joint.rows.T @ own @ joint.rows
    return stiffness, damping


def bearing_force_rows(
    assembled: AssembledSystem, bearing: Bearing, speed_rad_s: float
) -> tuple[FloatArray, FloatArray]:
    """Return the force of a bearing's first side on its second per q and per q', (6, n) each."""
    stiffness, damping = bearing_matrices(assembled, bearing, speed_rad_s)
    motion = joint_motion(assembled, bearing)
    rows = stiffness @ motion, damping @ motion
    if bearing.sensor is None:
        return rows
    (joint,) = (joint for joint in assembled.law_joints if joint.bearing == bearing.name)
    for row, matrix in zip(rows, joint.coefficients(speed_rad_s), strict=True):
        row[:2] += matrix[:2, 2:] @ (joint.motion[2:] - joint.motion[:2])
    return rows


# A system is a record that never changes; analyses ask for few ratios, and for one rate per mode.
@lru_cache(maxsize=16)
def at_whirl_ratio(assembled: AssembledSystem, ratio: float) -> AssembledSystem:
    """Return a system for motions whose frequency is a multiple of the speed, |ratio Ω|.

    Exact for steady motions of that frequency: bearings whose force depends on the frequency become
    ones that depend on the speed. The system itself if it has none of them.
    """
    return _frozen(
        assembled,
        lambda joint, law: law.at_whirl_ratio(abs(ratio / joint.speed_ratio)),
    )


def at_rate(assembled: AssembledSystem, rate: complex) -> AssembledSystem:
    """Return a system whose bearings have the force that they have at one rate s of the motion.

    An eigenvalue of the one at its own rate is one of the other.
    """
    return _frozen(assembled, lambda joint, law: law.at_rate(rate))


def _frozen(
    assembled: AssembledSystem, change: Callable[[LawJoint, FrequencyLaw], SpeedLaw]
) -> AssembledSystem:
    if not assembled.depends_on_frequency:
        return assembled
    joints = tuple(
        joint if joint.frequency_law is None else joint.with_law(change(joint, joint.frequency_law))
        for joint in assembled.law_joints
    )
    return dataclasses.replace(assembled, law_joints=joints)


def _with_spin(system: System) -> tuple[Bearing, ...]:
    """Return the bearings as the shafts turn: films under those that turn backward are mirrored."""
    return tuple(
        bearing.mirrored()
        if bearing.cross_coupling == "with_spin"
        and bearing.has_spin_coupling
        and spin_sign(system, bearing) < 0
        else bearing
        for bearing in system.bearings
    )


def spin_sign(system: System, bearing: Bearing) -> float:
    """Return 1 or −1 as the first side of a bearing that turns does forward or backward, else 0."""
    ratios = (system.rotors[end.body].speed_ratio for end in bearing.ends)
    return float(np.sign(next((ratio for ratio in ratios if ratio != 0), 0.0)))


def _symmetric(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (matrix + matrix.T))


def speed_limit(system: System) -> float:
    """Return the largest |Ω| at which no body runs faster than its basis was made for."""
    limits = [
        rotor.element.maximum_speed_rad_s / abs(rotor.speed_ratio)
        for rotor in system.rotors.values()
        if rotor.speed_ratio != 0
    ]
    return min(limits, default=np.inf)


def body_slices_of(system: System) -> dict[str, slice]:
    """Return the rows of each body among the coordinates of all."""
    sizes = [rotor.element.size for rotor in system.rotors.values()]
    ends = np.cumsum(sizes).tolist()
    starts = [end - size for end, size in zip(ends, sizes, strict=True)]
    return dict(zip(system.rotors, map(slice, starts, ends), strict=True))


def _joint_matrices(rows: Rows) -> tuple[FloatArray, FloatArray]:
    """Return the constant stiffness and damping of bearings and gears."""
    n = rows.transformation.shape[1]
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    for bearing in rows.system.bearings:
        relative, (k, c) = joint_motion(rows, bearing), bearing.matrices()
        if bearing.speed_law is not None:
            k[:2, :2] = c[:2, :2] = 0.0
        stiffness += _seen_by(relative, k)
        damping += _seen_by(relative, c)
    for gear in rows.system.gears:
        teeth = tooth_motion(rows, gear)
        if gear.mesh_stiffness_n_per_m is not None:
            stiffness += gear.mesh_stiffness_n_per_m * np.outer(teeth, teeth)
            damping += gear.mesh_damping_n_s_per_m * np.outer(teeth, teeth)
    return stiffness, damping


def _seen_by(relative: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return the coefficients of a joint in the independent coordinates, symmetric if they are."""
    product = relative.T @ matrix @ relative
    return _symmetric(product) if np.array_equal(matrix, matrix.T) else np.asarray(product)


def _law_joints(rows: Rows) -> tuple[LawJoint, ...]:
    found: list[LawJoint] = []
    for bearing in rows.system.bearings:
        if bearing.sensor is not None:
            found.append(_sensed_joint(rows, bearing))
        elif bearing.speed_law is not None:
            ratio = law_speed_ratio(rows.system, bearing)
            found += law_joints(bearing, ratio, joint_motion(rows, bearing))
    return tuple(found)


def _sensed_joint(rows: Rows, bearing: Bearing) -> LawJoint:
    """Return a magnetic bearing on the motion of its magnets and of its sensors."""
    motion = np.vstack((joint_motion(rows, bearing)[:2], sensed_motion(rows, bearing)[:2]))
    return LawJoint(
        bearing=bearing.name,
        law=bearing.speed_law.sensed_apart(),  # type: ignore[union-attr]
        speed_ratio=1.0,
        stiffness_n_per_m=bearing.stiffness_n_per_m,
        damping_n_s_per_m=bearing.damping_n_s_per_m,
        motion=motion,
        rows=np.eye(2, 6),
    )


def law_joints(bearing: Bearing, speed_ratio: float, motion: FloatArray) -> list[LawJoint]:
    """Return a bearing with a speed law, on what its law is made of.

    `motion`: ux to rz of the first side relative to the second per coordinate, (6, n).
    """
    assert bearing.speed_law is not None
    return [
        LawJoint(
            bearing=bearing.name,
            law=law,
            speed_ratio=speed_ratio,
            stiffness_n_per_m=bearing.stiffness_n_per_m,
            damping_n_s_per_m=bearing.damping_n_s_per_m,
            motion=rows @ motion,
            rows=rows,
        )
        for rows, law in law_parts(bearing.speed_law)
    ]


def law_speed_ratio(system: System, bearing: Bearing) -> float:
    """Return the speed that a bearing's law takes over that of the reference shaft.

    It is the spin of the first side; of a law without spin any, so that of the reference shaft.
    """
    if bearing.speed_law is not None and not follows_spin(bearing.speed_law):
        return 1.0
    return float(system.rotors[bearing.first.body].speed_ratio)


def _spin_generator(system: System, transformation: FloatArray) -> FloatArray | None:
    """Return L with T L = L_bodies T, None if a turn leaves the independent coordinates."""
    generators = [rotor.element.spin_generator for rotor in system.rotors.values()]
    known = [g for g in generators if g is not None]
    if len(known) < len(generators):
        return None
    turned = la.block_diag(*known) @ transformation
    generator, *_ = la.lstsq(transformation, turned)
    if np.abs(transformation @ generator - turned).max() > _SAME_TURN:
        return None
    # entries are whole numbers but for rounding; gears do not touch those of lateral motion
    whole = np.round(generator)
    return np.asarray(whole if np.abs(generator - whole).max() < _SAME_TURN else generator)


# Step of the central difference of a law without known pieces, relative to the speed and at least,
# rad/s.
_STEP = 1e-5
_SMALLEST_STEP = 1e-3

Side = Literal["below", "above", "both"]


class SpeedDerivative(NamedTuple):
    """Derivatives of C + ΩG and of K with respect to Ω, each (n, n)."""

    velocity: FloatArray
    stiffness: FloatArray

    def at_rate(self, rate: complex) -> ComplexArray:
        """Return ∂D/∂Ω at a fixed s."""
        return np.asarray(self.stiffness + rate * self.velocity)


def speed_derivative(
    assembled: AssembledSystem, speed_rad_s: float, side: Side = "both"
) -> SpeedDerivative:
    """Return the derivatives of the matrices of a system with respect to the speed.

    `side`: at a corner of a table the slope below or above the speed, or the mean of both. Returns
    G and 2 Ω K2 + N, plus the slopes of bearings with a speed law; of a law without known pieces by
    central differences.
    """
    stiffness = 2.0 * speed_rad_s * assembled.centrifugal_stiffness
    stiffness = stiffness + assembled.circulatory_stiffness
    velocity = assembled.gyroscopic
    for joint in assembled.law_joints:
        slopes = law_slopes(joint, speed_rad_s, side)
        stiffness = stiffness + joint.motion.T @ slopes[0] @ joint.motion
        velocity = velocity + joint.motion.T @ slopes[1] @ joint.motion
    return SpeedDerivative(velocity=np.asarray(velocity), stiffness=np.asarray(stiffness))


def law_slopes(joint: LawJoint, speed: float, side: Side) -> tuple[FloatArray, FloatArray]:
    """Return dk/dΩ and dc/dΩ of a bearing with a speed law, (2, 2) each."""
    if joint.pieces is None:
        step = max(_STEP * abs(speed), _SMALLEST_STEP)
        ends = [joint.coefficients(speed + sign * step) for sign in (-1.0, 1.0)]
        below = above = [(b - a) / (2.0 * step) for a, b in zip(*ends, strict=True)]
    else:
        below, above = ([*slopes] for slopes in joint.pieces.slopes(abs(speed)))
        # a law goes by |Ω|
        if speed < 0:
            below, above = [-part for part in above], [-part for part in below]
        elif speed == 0:
            below = [-part for part in above]
    weights = {"below": (1.0, 0.0), "above": (0.0, 1.0), "both": (0.5, 0.5)}[side]
    stiffness, damping = (
        weights[0] * a + weights[1] * b for a, b in zip(below, above, strict=True)
    )
    return stiffness, damping


def gravity_load(assembled: Placed, gravity_m_per_s2: npt.ArrayLike) -> FloatArray:
    """Return the weight of all bodies.

    `gravity_m_per_s2`: acceleration along x, y, z, shape (3,). The result is on the stacked
    coordinates, shape (N,), N and N m. Raises AnalysisError if the shape is wrong, a number is not
    finite, or no body can move in a direction in which gravity pulls.
    """
    return np.asarray(weights(assembled, gravity_m_per_s2) @ np.asarray(gravity_m_per_s2))


def weights(assembled: Placed, gravity_m_per_s2: npt.ArrayLike) -> FloatArray:
    """Return the weight of all bodies per gravity along x, y and z, (N, 3); see `gravity_load`."""
    gravity = np.asarray(gravity_m_per_s2, dtype=float)
    if gravity.shape != (3,) or not np.isfinite(gravity).all():
        raise AnalysisError(
            f"gravity_m_per_s2 is {gravity.tolist()}; three finite numbers are needed"
        )
    load = np.zeros((assembled.transformation.shape[0], 3))
    felt = np.zeros(3, dtype=bool)
    for name, rotor in assembled.system.rotors.items():
        motion = rotor.element.rigid_body_modes[:, :3]
        felt |= motion.any(axis=0)
        load[assembled.body_slices[name]] = rotor.element.mass @ motion
    lost = (gravity != 0) & ~felt
    if lost.any():
        axis = "xyz"[int(np.argmax(lost))]
        raise AnalysisError(
            f"gravity_m_per_s2 is {gravity.tolist()}, but no body can move along {axis}"
        )
    return load


def with_bearing_stiffness(
    assembled: AssembledSystem, names: Sequence[str], stiffness_n_per_m: float
) -> AssembledSystem:
    """Assemble a system again with another lateral stiffness of some bearings.

    `names`: bearings that get the stiffness, one or more. `assembled`: the system; it stays as it
    is. `stiffness_n_per_m`: k of the new stiffness k·I on (ux, uy), N/m; 0 or more. All else is
    that of `assembled`: rotors, gears, the other bearings, and the damping, tilt, axial and
    torsional stiffness of the named ones. A bearing with a speed law keeps it; k is what the law
    scales. The independent coordinates may be others, since joined ones are chosen by stiffness:
    compare motions of interfaces, not coordinates. Raises AnalysisError if a name is unknown, none
    is given, a named bearing joins ux or uy rigidly, or the stiffness is negative or not finite.
    """
    value = float(stiffness_n_per_m)
    if not (np.isfinite(value) and value >= 0):
        raise AnalysisError(f"stiffness_n_per_m is {value}; finite and 0 or more is allowed")
    system = assembled.system
    known = [bearing.name for bearing in system.bearings]
    unknown = [name for name in names if name not in known]
    if isinstance(names, str) or not names or unknown:
        raise AnalysisError(
            f"names is {names!r}; a sequence of one or more of the bearings {known} is allowed"
        )
    bearings = []
    for bearing in system.bearings:
        if bearing.name not in names:
            bearings.append(bearing)
            continue
        if {"ux", "uy"} & set(bearing.rigid):
            raise AnalysisError(
                f"bearing {bearing.name!r} joins {list(bearing.rigid)} rigidly and has no lateral "
                "stiffness to replace; name bearings with flexible ux and uy"
            )
        bearings.append(dataclasses.replace(bearing, stiffness_n_per_m=value * np.eye(2)))
    return assemble(system.rotors, tuple(bearings), system.reference, system.gears)
