"""Forces between two interfaces that are no linear function of their relative motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.special import roots_legendre

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# Gauss's rule over the half film, exact to 1e-9 up to an eccentricity of 0.95 and to 1e-3 up to the
# one at which the film counts as closed: directions e seen along the velocity, (2, 64), and
# weights of e eᵀ, (64, 4).
_CLOSED = 0.99
_POINT, _WEIGHT = roots_legendre(64)
_AROUND = np.stack((np.cos(0.5 * np.pi * _POINT), np.sin(0.5 * np.pi * _POINT)))
_DYADS = 0.5 * np.pi * (_WEIGHT * _AROUND[:, None] * _AROUND).reshape(4, -1).T


class ForceSamples(NamedTuple):
    """A force at t samples of a motion, and how it changes with them.

    `force_n`: shape (t, 2), which holds the first side back: the first side feels its negative;
    `stiffness_n_per_m`, `damping_n_s_per_m`: its derivatives by displacement and velocity, shape
    (t, 2, 2), first index force.
    """

    force_n: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray


class NonlinearForce(Protocol):
    """A force that depends on the relative displacement and velocity of two interfaces."""

    def at(self, displacement_m: FloatArray, velocity_m_per_s: FloatArray) -> ForceSamples:
        """Return the force at samples (t, 2) along x and y; nan where the motion is impossible."""


@dataclass(frozen=True, kw_only=True)
class CubicSpring:
    """A spring of third order, k r² (x, y) + (kx x³, ky y³).

    `radial_n_per_m3`: k, the same in all directions; `along_n_per_m3`: kx, ky. Negative ones
    soften. Raises AnalysisError if a number is not finite.
    """

    radial_n_per_m3: float = 0.0
    along_n_per_m3: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for key in ("radial_n_per_m3", "along_n_per_m3"):
            if not np.isfinite(getattr(self, key)).all():
                raise AnalysisError(f"{key} is {getattr(self, key)}; it must be finite")

    def at(self, displacement_m: FloatArray, velocity_m_per_s: FloatArray) -> ForceSamples:
        """Return the force at samples (t, 2) along x and y."""
        u, eye, along = displacement_m, np.eye(2), np.array(self.along_n_per_m3)
        each = u * u
        square = each.sum(axis=1)
        force = (self.radial_n_per_m3 * square[:, None] + along * each) * u
        stiffness = self.radial_n_per_m3 * (
            square[:, None, None] * eye + 2.0 * u[:, :, None] * u[:, None, :]
        )
        stiffness = stiffness + (3.0 * along * each)[:, :, None] * eye
        return ForceSamples(force, stiffness, np.zeros_like(stiffness))


@dataclass(frozen=True, kw_only=True)
class Clearance:
    """A round gap that closes against a stiffness: a bearing with play, or a rub.

    Where the distance r of the shaft from the centre of the gap exceeds it, the force is
    k (r − gap) outward, and μ times that across, against the sliding of a surface that turns
    faster than the shaft whirls: both are piecewise linear in r (Ehrich 1966, ASME paper 66-MD-1;
    Muszynska 2005, Rotordynamics).

    `gap_m`: radial; `stiffness_n_per_m`: of the contact; `friction`: μ; `spin_sense`: 1 or −1 as
    the first side turns forward or backward against the second, 0 without; `center_m`: of the gap,
    where the first side stands eccentric in it. Raises AnalysisError if a number is out of range.
    """

    gap_m: float
    stiffness_n_per_m: float
    friction: float = 0.0
    spin_sense: int = 1
    center_m: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        _refuse_negative(self, "gap_m", "stiffness_n_per_m", "friction")
        if not self.stiffness_n_per_m > 0.0:
            raise AnalysisError("stiffness_n_per_m is 0; it must be above 0")
        if self.spin_sense not in (-1, 0, 1) or (self.friction and not self.spin_sense):
            raise AnalysisError(
                f"spin_sense is {self.spin_sense}; it must be 1 or -1 with friction, or 0 without"
            )
        if not np.isfinite(self.center_m).all():
            raise AnalysisError(f"center_m is {self.center_m}; it must be finite")

    def at(self, displacement_m: FloatArray, velocity_m_per_s: FloatArray) -> ForceSamples:
        """Return the force at samples (t, 2) along x and y."""
        u, eye = displacement_m - np.array(self.center_m), np.eye(2)
        radius = np.hypot(u[:, 0], u[:, 1])
        pressed = radius > self.gap_m
        out = u / np.where(pressed, radius, 1.0)[:, None]
        across = self.friction * self.spin_sense * np.array([[0.0, -1.0], [1.0, 0.0]])
        turned = self.stiffness_n_per_m * (eye + across)
        depth = np.where(pressed, radius - self.gap_m, 0.0)
        rise = out[:, :, None] * out[:, None, :]
        share = np.divide(depth, radius, out=np.zeros_like(radius), where=pressed)[:, None, None]
        slope = np.where(pressed[:, None, None], share * (eye - rise) + rise, 0.0)
        return ForceSamples(
            (depth[:, None] * out) @ turned.T, turned @ slope, np.zeros((len(u), 2, 2))
        )


@dataclass(frozen=True, kw_only=True)
class SqueezeFilm:
    """A squeeze film damper with open ends: the short film, without pressure below ambient.

    The pressure over the length is 6 μ h' (z² − L²/4) / h³ with h = c − x cos θ − y sin θ, counted
    where it is positive, half of the circumference: f = C(u, v) v, C = μ R L³ ∫ e eᵀ/h³ dθ over the
    half towards which the journal moves (Vance, Zeidan and Murphy 2010, Machinery Vibration and
    Rotordynamics). No inertia of the film.

    `radius_m`, `length_m`, `clearance_m`: R, L and radial c; `viscosity_pa_s`: μ;
    `centring_n_per_m`: of a spring beside the film. Raises AnalysisError if a number is out of
    range.
    """

    radius_m: float
    length_m: float
    clearance_m: float
    viscosity_pa_s: float
    centring_n_per_m: float = 0.0

    def __post_init__(self) -> None:
        sizes = ("radius_m", "length_m", "clearance_m", "viscosity_pa_s")
        _refuse_negative(self, *sizes, "centring_n_per_m")
        for key in sizes:
            if not getattr(self, key) > 0.0:
                raise AnalysisError(f"{key} is 0; it must be above 0")

    def at(self, displacement_m: FloatArray, velocity_m_per_s: FloatArray) -> ForceSamples:
        """Return the force at samples (t, 2); nan where the film is thinner than 0.01 clearance."""
        u, v = displacement_m, velocity_m_per_s
        angle = np.arctan2(v[:, 1], v[:, 0])
        c, s = np.cos(angle), np.sin(angle)
        axes = np.stack((c, s, -s, c), axis=1).reshape(-1, 2, 2)  # along the velocity, across it
        height = self.clearance_m - (axes @ u[:, :, None])[:, :, 0] @ _AROUND
        height[np.hypot(u[:, 0], u[:, 1]) >= _CLOSED * self.clearance_m] = np.nan
        size = self.viscosity_pa_s * self.radius_m * self.length_m**3
        share = size / (height * height * height)
        faster = 3.0 * np.hypot(v[:, :1], v[:, 1:]) * _AROUND[0] * share / height
        damping, stiffness = (
            axes.transpose(0, 2, 1) @ (each @ _DYADS).reshape(-1, 2, 2) @ axes
            for each in (share, faster)
        )
        force = (damping @ v[:, :, None])[:, :, 0] + self.centring_n_per_m * u
        return ForceSamples(force, stiffness + self.centring_n_per_m * np.eye(2), damping)


def _refuse_negative(record: object, *keys: str) -> None:
    for key in keys:
        value = getattr(record, key)
        if not (np.isfinite(value) and value >= 0.0):
            raise AnalysisError(f"{key} is {value}; it must be finite and not negative")
