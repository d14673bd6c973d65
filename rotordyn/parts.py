"""What an engine is made of: rotors with their speed ratios, and the bearings between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.bearing_laws import (
    SpeedLaw,
    is_turned_by_spin,
    mirrored,
    mirrored_law,
)
from solidwhirl.rotordyn.reprs import bearing_text, rotor_text, system_text
from solidwhirl.rotordyn.superelement import Superelement

CrossCoupling = Literal["with_spin", "as_given", "mirrored"]
_COUPLED = (
    "stiffness_n_per_m",
    "damping_n_s_per_m",
    "tilt_stiffness_n_m_per_rad",
    "tilt_damping_n_m_s_per_rad",
)


def _zero_matrix() -> FloatArray:
    return np.zeros((2, 2))


@dataclass(frozen=True, kw_only=True)
class End:
    """Name one side of a bearing: an interface of a body."""

    body: str
    interface: str

    @property
    def label(self) -> str:
        """Text such as "inner.front"."""
        return f"{self.body}.{self.interface}"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Bearing:
    """Join an interface to another one or to the ground.

    The force on `first` is −k (u_first − u_second) − c (u̇_first − u̇_second), in fixed components.

    Attributes
    ----------
    name
        Unique within the system.
    first
        One side.
    second
        The other side; None is the ground.
    stiffness_n_per_m, damping_n_s_per_m
        On (ux, uy), shape (2, 2). Need not be symmetric (cross-coupled seals and oil films).
    tilt_stiffness_n_m_per_rad, tilt_damping_n_m_s_per_rad
        On (rx, ry), shape (2, 2).
    axial_stiffness_n_per_m, axial_damping_n_s_per_m
        On uz.
    torsion_stiffness_n_m_per_rad, torsion_damping_n_m_s_per_rad
        On rz.
    rigid
        Components, "ux" to "rz", joined exactly: the coordinates are eliminated, no large spring
        is used. A component is either rigid or has stiffness and damping, not both.
    speed_law
        How the coefficients on (ux, uy) change with the spin speed of the body of `first`; None
        keeps them constant.
    cross_coupling
        "with_spin": unequal cross terms (xy ≠ yx) come from the rotation and are given for a shaft
        that turns forward, so that `assemble` changes the sign of all cross terms of the bearing
        where it turns backward, and writes "mirrored" here. "as_given": they are taken as they
        are. Equal cross terms (xy = yx in stiffness and damping, at all speeds) are those of an
        elastic support with inclined axes, and stay.
    """

    name: str
    first: End
    second: End | None = None
    stiffness_n_per_m: FloatArray = field(default_factory=_zero_matrix)
    damping_n_s_per_m: FloatArray = field(default_factory=_zero_matrix)
    tilt_stiffness_n_m_per_rad: FloatArray = field(default_factory=_zero_matrix)
    tilt_damping_n_m_s_per_rad: FloatArray = field(default_factory=_zero_matrix)
    axial_stiffness_n_per_m: float = 0.0
    axial_damping_n_s_per_m: float = 0.0
    torsion_stiffness_n_m_per_rad: float = 0.0
    torsion_damping_n_m_s_per_rad: float = 0.0
    rigid: tuple[str, ...] = ()
    speed_law: SpeedLaw | None = None
    cross_coupling: CrossCoupling = "with_spin"

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "stiffness_n_per_m",
            "damping_n_s_per_m",
            "tilt_stiffness_n_m_per_rad",
            "tilt_damping_n_m_s_per_rad",
        )

    def __repr__(self) -> str:
        return bearing_text(self)

    @property
    def ends(self) -> tuple[End, ...]:
        """The sides that are not the ground."""
        return (self.first,) if self.second is None else (self.first, self.second)

    @property
    def has_spin_coupling(self) -> bool:
        """Whether cross terms are unequal at some speed, as rotation makes them."""
        own = (getattr(self, name) for name in _COUPLED)
        constant = any(not np.array_equal(matrix, matrix.T) for matrix in own)
        return constant or (self.speed_law is not None and is_turned_by_spin(self.speed_law))

    def mirrored(self) -> Bearing:
        """Return the bearing under a shaft that turns the other way: all cross terms change sign.

        Returns
        -------
        Bearing
            With the `cross_coupling` "mirrored".
        """
        return replace(
            self,
            stiffness_n_per_m=mirrored(self.stiffness_n_per_m),
            damping_n_s_per_m=mirrored(self.damping_n_s_per_m),
            tilt_stiffness_n_m_per_rad=mirrored(self.tilt_stiffness_n_m_per_rad),
            tilt_damping_n_m_s_per_rad=mirrored(self.tilt_damping_n_m_s_per_rad),
            speed_law=None if self.speed_law is None else mirrored_law(self.speed_law),
            cross_coupling="mirrored",
        )

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping on (ux, uy, uz, rx, ry, rz), a speed law left aside.

        Returns
        -------
        stiffness, damping : ndarray
            Shape (6, 6); N/m and N s/m, N m/rad and N m s/rad.
        """
        stiffness, damping = np.zeros((6, 6)), np.zeros((6, 6))
        stiffness[:2, :2], damping[:2, :2] = self.stiffness_n_per_m, self.damping_n_s_per_m
        stiffness[3:5, 3:5] = self.tilt_stiffness_n_m_per_rad
        damping[3:5, 3:5] = self.tilt_damping_n_m_s_per_rad
        stiffness[2, 2], damping[2, 2] = self.axial_stiffness_n_per_m, self.axial_damping_n_s_per_m
        stiffness[5, 5] = self.torsion_stiffness_n_m_per_rad
        damping[5, 5] = self.torsion_damping_n_m_s_per_rad
        return stiffness, damping


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Couple the torsion of two bodies by a gear.

    Kinematically rz of `second` is ratio · rz of `first`; torques follow from the virtual work.

    Attributes
    ----------
    name
        Unique within the system.
    first, second
        The two gear seats; both need rz, and ux, uy where the mesh has a line of action.
    ratio
        Speed of `second` over that of `first`, negative for an external pair of spur gears. It
        must be that of the bodies' speed ratios.
    mesh_stiffness_n_per_m
        Along the line of action; None is a rigid mesh, which is eliminated exactly.
    mesh_damping_n_s_per_m
        Along the line of action.
    base_radius_first_m
        Base circle of the first wheel; needed with a mesh stiffness or a line of action.
    line_of_action_rad
        Angle of the line of action across the axis, from +x towards +y, taken in the sense in
        which a positive turn of `first` moves its contact point. None couples torsion alone, as
        in a planetary gear whose planets balance each other.

    Notes
    -----
    The relative motion of the teeth is δ = n·(u1 − u2) + r1 rz1 − (r1 / ratio) rz2, n = (cos,
    sin) of the line of action (Rao, Shiau and Chang 1998; r2 = −r1/ratio for an external pair).
    """

    name: str
    first: End
    second: End
    ratio: float
    mesh_stiffness_n_per_m: float | None = None
    mesh_damping_n_s_per_m: float = 0.0
    base_radius_first_m: float | None = None
    line_of_action_rad: float | None = None

    @property
    def ends(self) -> tuple[End, End]:
        """Both gear seats."""
        return (self.first, self.second)

    def tooth_motion(self) -> tuple[FloatArray, FloatArray]:
        """Return the relative motion of the teeth per motion of the two seats.

        Returns
        -------
        first, second : ndarray
            Shape (6,): factors of ux to rz at the seats.
        """
        radius = 1.0 if self.base_radius_first_m is None else self.base_radius_first_m
        first, second = np.zeros(6), np.zeros(6)
        first[5], second[5] = radius, -radius / self.ratio
        if self.line_of_action_rad is not None:
            direction = np.array([np.cos(self.line_of_action_rad), np.sin(self.line_of_action_rad)])
            first[:2], second[:2] = direction, -direction
        return first, second


@dataclass(frozen=True, kw_only=True)
class InternalDamping:
    """Give a body's material viscous damping, which turns with it.

    C = stiffness_coefficient_s · K + Σ 2 modal_ratio ω (Mφ)(Mφ)ᵀ over the body's free modes at
    rest; the force is C (q' − Ω L q), whose second part drives forward whirl above a threshold
    speed (Genta 2005, Dynamics of Rotating Systems, section 2.5).

    Attributes
    ----------
    stiffness_coefficient_s
        β of C = β K, s.
    modal_ratio
        Fraction of critical damping of each elastic free mode.
    """

    stiffness_coefficient_s: float = 0.0
    modal_ratio: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Rotor:
    """Place a superelement in a system.

    Attributes
    ----------
    element
        The body.
    speed_ratio
        Its spin speed is speed_ratio · Ω: 1 for the reference shaft, negative for a
        counter-rotating one, 0 for a casing.
    internal_damping
        Of the body's material; None without.
    """

    element: Superelement
    speed_ratio: float
    internal_damping: InternalDamping | None = None

    def __repr__(self) -> str:
        return rotor_text(self)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class System:
    """Collect the rotors and bearings of an engine.

    Attributes
    ----------
    rotors
        By name.
    bearings
        Between interfaces and the ground.
    reference
        Name of the shaft whose speed is Ω (its ratio must be 1); None when Ω is only a parameter.
    gears
        Between bodies.
    """

    rotors: Mapping[str, Rotor]
    bearings: tuple[Bearing, ...]
    reference: str | None = None
    gears: tuple[Gear, ...] = ()

    def __repr__(self) -> str:
        return system_text(self)
