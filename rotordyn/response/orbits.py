"""Ellipses that points run through in steady vibration, from complex amplitudes along x and y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays, StringArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# An orbit whose minor axis is below this fraction of the major one is a line.
_LINE = 1e-3
# One whose axes differ by less than this fraction is a circle.
_CIRCLE = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EllipticOrbits(ReadOnlyArrays):
    """Hold orbits of any number of points; all arrays have the shape of the amplitudes.

    `major_m`, `minor_m`: semi-axes, m; neither is negative. `major_m` is the largest distance from
    the centre. `inclination_rad`: angle of the major axis from +x towards +y, −π/2 to π/2; nan for
    a circle (axes equal to 1e-9) and a point. `direction`: "forward" turns from +x towards +y, as
    the reference shaft does, "backward" the other way; "line" has a minor axis below 1/1000 of the
    major one.
    """

    major_m: FloatArray
    minor_m: FloatArray
    inclination_rad: FloatArray
    direction: StringArray


class OrbitRecord(ReadOnlyArrays):
    """Base of records with complex amplitudes of ux, uy, shape (..., 2)."""

    __slots__ = ()
    translation_m: ComplexArray

    def orbits(self) -> EllipticOrbits:
        """Return the orbits, arrays of shape (...)."""
        return elliptic_orbits(self.translation_m[..., 0], self.translation_m[..., 1])

    def major_m(self) -> FloatArray:
        """Return the major semi-axes of the orbits, shape (...), m; nan without translation."""
        return self.orbits().major_m


def elliptic_orbits(x_m: npt.ArrayLike, y_m: npt.ArrayLike) -> EllipticOrbits:
    """Return the ellipses of the motions x = Re(X e^{iωt}), y = Re(Y e^{iωt}).

    `x_m`, `y_m`: X and Y, complex, of equal shape, m. The result is of the same shape. Raises
    AnalysisError if the shapes differ.

    x + i y = a e^{iωt} + b e^{−iωt}, a = (X + iY)/2 and b* = (X − iY)/2: a forward and a backward
    circle, with semi-axes |a| ± |b| and the major axis at (arg a + arg b)/2 (Genta 2005, Dynamics
    of Rotating Systems, section 3.6).
    """
    x, y = np.asarray(x_m, dtype=complex), np.asarray(y_m, dtype=complex)
    if x.shape != y.shape:
        raise AnalysisError(f"x_m has shape {x.shape} and y_m {y.shape}; equal shapes are allowed")
    forward, backward = 0.5 * (x + 1j * y), 0.5 * (x - 1j * y).conj()
    along, against = np.abs(forward), np.abs(backward)
    major = along + against
    is_round = np.minimum(along, against) <= 0.5 * _CIRCLE * major
    # The angle of a·b is twice the inclination and needs no choice of branch.
    inclination = np.where(is_round, np.nan, 0.5 * np.angle(forward * backward))
    direction = np.where(along > against, "forward", "backward")
    direction = np.where(np.abs(along - against) <= _LINE * major, "line", direction)
    return EllipticOrbits(
        major_m=major,
        minor_m=np.abs(along - against),
        inclination_rad=inclination,
        direction=direction,
    )


def amplitude_along(x_m: npt.ArrayLike, y_m: npt.ArrayLike, direction_rad: float) -> ComplexArray:
    """Return the complex amplitude of a motion along a direction, as a probe there sees it.

    `x_m`, `y_m`: X and Y, complex, of equal shape, m; `direction_rad`: from +x towards +y.
    """
    x, y = np.asarray(x_m, dtype=complex), np.asarray(y_m, dtype=complex)
    return np.asarray(np.cos(direction_rad) * x + np.sin(direction_rad) * y)
