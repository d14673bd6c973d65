"""What an engine is made of: rotors with their speed ratios, and the bearings between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.superelement import Superelement


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

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "stiffness_n_per_m",
            "damping_n_s_per_m",
            "tilt_stiffness_n_m_per_rad",
            "tilt_damping_n_m_s_per_rad",
        )

    @property
    def ends(self) -> tuple[End, ...]:
        """The sides that are not the ground."""
        return (self.first,) if self.second is None else (self.first, self.second)

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping on (ux, uy, uz, rx, ry, rz).

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
    """

    element: Superelement
    speed_ratio: float


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
    """

    rotors: Mapping[str, Rotor]
    bearings: tuple[Bearing, ...]
    reference: str | None = None
