"""Ball bearings: what the balls do to the inner ring at a given motion of it.

Load distribution of ISO/TS 16281 with point contacts of Hertz at both races. At speed the balls are
pressed outward: every ball finds its own place between the grooves, and the contact angles at the
two races differ (Jones 1960; Harris and Kotzalas 2006, Advanced Concepts, chapter 3, without the
gyroscopic moment).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.bearings.elements import (
    ElementForces,
    centrifugal_load_n,
    element_problems,
)
from solidwhirl.rotordyn.bearings.hertz import BEARING_STEEL, Elastic, PointContact, point_contact
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# Newton steps and halvings of one, of which a few are used.
_STEPS, _HALVINGS = 60, 30
# Forces on a ball balance to this fraction of them.
_BALANCED = 1e-12


@dataclass(frozen=True, kw_only=True)
class BallBearing:
    """A ball bearing with a rotating inner ring: angular contact, or deep groove with a clearance.

    `inner_groove`, `outer_groove`: groove radii over the ball diameter, above 0.5;
    `contact_angle_rad`: of an angular contact bearing without load, carrying axial load on the
    inner ring towards +z only; 0 for a deep groove; `radial_clearance_m`: of a deep groove, the
    play across, negative with interference. The first ball lies at +x. Raises AnalysisError, all
    faults at once.
    """

    ball_count: int
    ball_diameter_m: float
    pitch_diameter_m: float
    inner_groove: float = 0.52
    outer_groove: float = 0.53
    contact_angle_rad: float = 0.0
    radial_clearance_m: float = 0.0
    rings: Elastic = BEARING_STEEL
    balls: Elastic = BEARING_STEEL
    inner: PointContact = field(init=False, repr=False)
    outer: PointContact = field(init=False, repr=False)

    def __post_init__(self) -> None:
        problems = _ball_problems(self)
        if problems:
            raise AnalysisError("ball bearing: " + "; ".join(problems))
        for name, groove in (("inner", self.inner_groove), ("outer", self.outer_groove)):
            object.__setattr__(self, name, self._contact(1.0 if name == "inner" else -1.0, groove))

    @property
    def highest_pressure_pa(self) -> float:
        """Contact pressure at the basic static load rating, ISO 76."""
        return 4200e6

    @property
    def carried(self) -> tuple[int, ...]:
        """The motions, of ux, uy and uz, along which a load is carried."""
        return (0, 1, 2)

    @property
    def element_count(self) -> int:
        """Number of balls."""
        return self.ball_count

    @property
    def size_m(self) -> float:
        """Diameter of a ball, m."""
        return self.ball_diameter_m

    @property
    def groove_distance_m(self) -> float:
        """A, distance of the groove centres when the balls just touch, m."""
        return (self.inner_groove + self.outer_groove - 1.0) * self.ball_diameter_m

    @property
    def free_angle_rad(self) -> float:
        """Contact angle where the balls just touch, of a deep groove shifted axially."""
        free = 1.0 - self.radial_clearance_m / (2.0 * self.groove_distance_m)
        return self.contact_angle_rad or float(np.arccos(np.clip(free, -1.0, 1.0)))

    @property
    def stiffness_n_per_m15(self) -> float:
        """C of Q = c δ^(3/2) for both races in series, N/m^1.5."""
        own = (self.inner.stiffness_n_per_m15, self.outer.stiffness_n_per_m15)
        return float(sum(c ** (-2.0 / 3.0) for c in own) ** -1.5)

    def centrifugal_n(self, speed_rad_s: float) -> float:
        """Return the load that presses a ball outward, N.

        The balls go round with ½ Ω (1 − Dw cos α / Dpw) at the free contact angle α.
        """
        mass = self.balls.density_kg_per_m3 * np.pi / 6.0 * self.ball_diameter_m**3
        ratio = self.ball_diameter_m * np.cos(self.free_angle_rad) / self.pitch_diameter_m
        return centrifugal_load_n(mass, self.pitch_diameter_m, float(ratio), speed_rad_s)

    def start(self, force: FloatArray, centrifugal_n: float) -> FloatArray:
        """Return a motion (5,) that loads the bearing rather too much, to begin a search from."""
        z, c, distance = self.ball_count, self.stiffness_n_per_m15, self.groove_distance_m
        motion, radial = np.zeros(5), float(np.hypot(*force[:2]))
        r, a = self._free_centre()
        if radial > 0:
            deep = np.cbrt((5.0 * radial / (z * c)) ** 2)
            deep += np.cbrt((centrifugal_n / self.outer.stiffness_n_per_m15) ** 2)
            motion[:2] = force[:2] / radial * (deep + max(distance - r, 0.0))
        if force[2] != 0:
            sine = 1.0
            for _ in range(3):
                long = distance + np.cbrt((abs(force[2]) / (z * c * sine)) ** 2)
                sine = np.sqrt(max(1.0 - (r / long) ** 2, 1e-3))
            motion[2] = np.sign(force[2]) * sine * long - a
        return motion

    def seen(self, angle: FloatArray) -> FloatArray:
        """Return radial and axial motion of the ring at balls at angles (..., Z)."""
        radius = 0.5 * self.pitch_diameter_m
        radius += (self.inner_groove - 0.5) * self.ball_diameter_m * np.cos(self.free_angle_rad)
        moved = np.zeros((*angle.shape, 2, 5))
        moved[..., 0, 0], moved[..., 0, 1], moved[..., 1, 2] = np.cos(angle), np.sin(angle), 1.0
        moved[..., 1, 3], moved[..., 1, 4] = radius * np.sin(angle), -radius * np.cos(angle)
        return moved

    def contacts(
        self, moved: FloatArray, centrifugal_n: FloatArray, near: FloatArray | None = None
    ) -> ElementForces:
        """Return what the balls do at motions (b, N, 2) of the ring at them."""
        centres = (self._free_centre() + moved).reshape(-1, 2)
        own = np.repeat(centrifugal_n, moved.shape[1])
        start = None if near is None else near.reshape(-1, 2)
        inner, outer, stiffness, angles, place, gap = _balls(self, centres, own, start)
        at = moved.shape[:2]
        return ElementForces(
            force=inner.reshape(moved.shape),
            stiffness=stiffness.reshape(*at, 2, 2),
            inner_load_n=np.hypot(*inner.T).reshape(at),
            outer_load_n=np.hypot(*outer.T).reshape(at),
            inner_angle_rad=angles[0].reshape(at),
            outer_angle_rad=angles[1].reshape(at),
            gap_m=gap.reshape(*at[:1], -1),
            place=place.reshape(moved.shape),
        )

    def pressure_pa(self, inner_load_n: float, outer_load_n: float) -> float:
        """Return the larger of the largest contact pressures at the races under two loads, Pa."""
        return max(self.inner.pressure_pa(inner_load_n), self.outer.pressure_pa(outer_load_n))

    def misplaced(self, found: ElementForces) -> str:
        """Tell why a load is not carried in an equilibrium, empty if it is."""
        loaded = found.inner_load_n > 1e-6 * found.inner_load_n.max()
        if self.contact_angle_rad > 0 and (found.inner_angle_rad[loaded] < 1e-6).any():
            return "a loaded ball leaves its shoulder; more axial load towards +z is needed"
        return ""

    def _free_centre(self) -> FloatArray:
        """Radial and axial place of the inner groove centre from the outer one, no load."""
        if self.contact_angle_rad:
            angle = self.contact_angle_rad
            return self.groove_distance_m * np.array([np.cos(angle), np.sin(angle)])
        return np.array([self.groove_distance_m - 0.5 * self.radial_clearance_m, 0.0])

    def _contact(self, side: float, groove: float) -> PointContact:
        """Contact at the inner (1) or outer (−1) race."""
        ratio = self.ball_diameter_m * np.cos(self.free_angle_rad) / self.pitch_diameter_m
        along, across = 2.0 * side * ratio / (1.0 - side * ratio), 1.0 / groove
        return point_contact(
            (4.0 + along - across) / self.ball_diameter_m,
            float((along + across) / (4.0 + along - across)),
            self.rings.compliance_per_pa + self.balls.compliance_per_pa,
        )


def _ball_problems(bearing: BallBearing) -> list[str]:
    sizes = (bearing.ball_count, bearing.ball_diameter_m, bearing.pitch_diameter_m)
    problems = element_problems("ball", *sizes)
    if not (0.5 < bearing.inner_groove < 1 and 0.5 < bearing.outer_groove < 1):
        problems.append(
            f"groove radii of {bearing.inner_groove:g} and {bearing.outer_groove:g} ball "
            "diameters; allowed is between 0.5 and 1"
        )
    if not 0 <= bearing.contact_angle_rad < 0.5 * np.pi:
        problems.append(f"contact angle {bearing.contact_angle_rad:g} rad; allowed is 0 to π/2")
    if bearing.contact_angle_rad and bearing.radial_clearance_m:
        problems.append("a contact angle and a radial clearance; give one of the two")
    if not bearing.radial_clearance_m < 2.0 * bearing.groove_distance_m:
        problems.append(
            f"radial clearance {bearing.radial_clearance_m:g} m; allowed is below twice the "
            f"distance of the groove centres, {2.0 * bearing.groove_distance_m:.4g} m"
        )
    return problems


class _Balls(NamedTuple):
    """Forces of n balls on the races, stiffness between these, angles, places and gaps."""

    inner: FloatArray
    outer: FloatArray
    stiffness: FloatArray
    angles: tuple[FloatArray, FloatArray]
    place: FloatArray
    gap: FloatArray


def _spring(arm: FloatArray, free: float, c: float) -> tuple[FloatArray, FloatArray]:
    """Force and stiffness of contacts along arms (Z, 2) whose length without load is `free`."""
    length = np.hypot(*arm.T)
    normal = arm / length[:, None]
    root = np.sqrt(np.maximum(length - free, 0.0))
    load = c * root**3
    along = np.einsum("ja,jb->jab", normal, normal)
    stiffness = (1.5 * c * root)[:, None, None] * along
    stiffness = stiffness + (load / length)[:, None, None] * (np.eye(2) - along)
    return load[:, None] * normal, stiffness


def _angle(arm: FloatArray) -> FloatArray:
    return np.asarray(np.arctan2(arm[:, 1], arm[:, 0]))


def _balls(
    bearing: BallBearing,
    centres: FloatArray,
    centrifugal_n: FloatArray,
    near: FloatArray | None,
) -> _Balls:
    """Return the balls between the grooves, whose inner centres lie at (n, 2) from the outer ones.

    At rest both races are in one line. A ball pressed outward is where its three forces balance;
    its energy is convex in its place, so that there is one such place.
    """
    inner, outer = (contact.stiffness_n_per_m15 for contact in (bearing.inner, bearing.outer))
    free = (np.array([bearing.inner_groove, bearing.outer_groove]) - 0.5) * bearing.ball_diameter_m
    thrown = np.zeros_like(centres)
    thrown[:, 0] = free[1] + np.cbrt((centrifugal_n / outer) ** 2)
    length = np.hypot(*centres.T)
    deep = np.maximum(0.5 * (length - free.sum()), thrown[:, 0] - free[1])
    place = centres * ((free[1] + deep) / length)[:, None] if near is None else near
    # where a ball thrown outward does not touch the inner race, that is its place
    # a small load of its own leaves the corner where a ball at rest would come into contact
    gap = np.stack((free[0] - np.hypot(*(centres - thrown).T), free.sum() - length), axis=1)
    is_thrown = gap[:, 0] >= 0
    place = np.where(is_thrown[:, None], thrown, place)
    moving = np.flatnonzero((centrifugal_n > 0) & ~is_thrown)
    if moving.size:
        place[moving] = _settled(
            centres[moving], centrifugal_n[moving], place[moving], (inner, outer), free
        )
    pull_in, stiff_in = _spring(centres - place, free[0], inner)
    pull_out, stiff_out = _spring(place, free[1], outer)
    both = stiff_in + stiff_out + (centrifugal_n == 0)[:, None, None] * np.eye(2)
    stiffness = stiff_in @ np.linalg.solve(both, stiff_out)
    stiffness = 0.5 * (stiffness + stiffness.swapaxes(1, 2))
    angles = _angle(centres - place), _angle(place)
    still = np.flatnonzero(centrifugal_n == 0)
    if still.size:
        c = bearing.stiffness_n_per_m15
        force, own = _spring(centres[still], bearing.groove_distance_m, c)
        pull_in[still], pull_out[still], stiffness[still] = force, force, own
        angles[0][still] = angles[1][still] = _angle(centres[still])
        gap[still, 0] = gap[still, 1]
    return _Balls(pull_in, pull_out, stiffness, angles, place, gap)


def _settled(
    centres: FloatArray,
    centrifugal_n: FloatArray,
    place: FloatArray,
    stiffness: tuple[float, float],
    free: FloatArray,
) -> FloatArray:
    """Return where the forces on balls (n, 2) balance, by Newton's method from a place."""
    own = np.zeros_like(centres)
    own[:, 0] = centrifugal_n

    def state(place: FloatArray, at: IntArray) -> tuple[FloatArray, ...]:
        pull_in, stiff_in = _spring(centres[at] - place, free[0], stiffness[0])
        pull_out, stiff_out = _spring(place, free[1], stiffness[1])
        deep_in, deep_out = (
            np.maximum(np.hypot(*arm.T) - size, 0.0)
            for arm, size in ((centres[at] - place, free[0]), (place, free[1]))
        )
        energy = 0.4 * (stiffness[0] * deep_in**2.5 + stiffness[1] * deep_out**2.5)
        left = pull_out - pull_in - own[at]
        scale = np.hypot(*pull_out.T) + np.hypot(*pull_in.T) + centrifugal_n[at]
        return (
            left, stiff_in + stiff_out, energy - centrifugal_n[at] * place[:, 0],
            np.hypot(*left.T), scale, pull_in.any(axis=1) | pull_out.any(axis=1),
        )  # fmt: skip

    place, at = place.copy(), np.arange(len(centres))
    for _ in range(_STEPS):
        left, most, energy, size, scale, touching = state(place[at], at)
        open_ = size > _BALANCED * scale
        if not open_.any():
            break
        at, left, energy, size = at[open_], left[open_], energy[open_], size[open_]
        soft = ~touching[open_] * centrifugal_n[at] / free[1]
        most = most[open_] + soft[:, None, None] * np.eye(2)
        step = np.linalg.solve(most, -left[..., None])[..., 0]
        share, moved = np.ones(at.size), np.zeros(at.size, dtype=bool)
        trying = np.arange(at.size)
        for _ in range(_HALVINGS):
            trial = place[at[trying]] + share[trying, None] * step[trying]
            after = state(trial, at[trying])
            better = (after[3] < size[trying]) | (after[2] < energy[trying])
            place[at[trying[better]]] = trial[better]
            moved[trying[better]] = True
            trying = trying[~better]
            if not trying.size:
                break
            share[trying] *= 0.5
        at = at[moved]  # of the others what is left is rounding
        if not at.size:
            break
    return place
