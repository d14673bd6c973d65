"""Frequencies in the frame that turns with a body, and back in the inertial frame.

A motion z = x + iy = f e^{iωt} + b e^{−iωt} of the axis, ω > 0, has a forward and a backward
circle. Seen from a body that turns at nΩ about +z it is f e^{i(ω − nΩ)t} + b e^{−i(ω + nΩ)t}: two
frequencies with a sign, positive where the motion turns about +z in that frame. A forward circle
slower than the body turns backward there: its frequency is mirrored at zero, its sign negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    freeze_arrays,
)
from solidwhirl.rotordyn.core.errors import AnalysisError

Kind = Literal["backward", "forward", "mirrored"]

_TURN = 2.0 * np.pi


def inertial_frequency(
    rotating_hz: npt.ArrayLike, spin_rad_s: npt.ArrayLike, kind: Kind
) -> FloatArray:
    """Return the frequency in the inertial frame of one seen in the frame of a body.

    `rotating_hz`: frequency seen by the body, Hz, 0 or more. `spin_rad_s`: its spin speed, rad/s, 0
    or more; forward is the body's own sense of spin here. `kind`: "backward": a backward whirl,
    whose frequency rises with the speed in the rotating frame; "forward": a forward whirl before it
    is mirrored at zero, faster than the body; "mirrored": a forward whirl after that, slower than
    the body. Returns Hz, in the shape of the broadcast arguments. Raises AnalysisError if the kind
    is unknown, a number is negative or not finite, or a frequency above that of the spin is called
    mirrored.

    Müller and Hennings, appendix B, equations 15 to 17: |f − Ω/2π|, f + Ω/2π and −f + Ω/2π. The
    first needs its bars only below Ω/2π, where no backward whirl lies.
    """
    frequency, spin = _checked(rotating_hz, "rotating_hz"), _checked(spin_rad_s, "spin_rad_s")
    turn = spin / _TURN
    if kind == "backward":
        return np.asarray(np.abs(frequency - turn))
    if kind == "forward":
        return np.asarray(frequency + turn)
    if kind == "mirrored":
        found = turn - frequency
        if (found < 0).any():
            raise AnalysisError(
                "rotating_hz is above spin_rad_s / 2π; a mirrored forward whirl lies below it"
            )
        return np.asarray(found)
    raise AnalysisError(f"kind is {kind!r}, allowed are {list(get_args(Kind))}")


def _checked(values: npt.ArrayLike, name: str) -> FloatArray:
    array = np.asarray(values, dtype=float)
    if not np.isfinite(array).all() or (array < 0).any():
        raise AnalysisError(f"{name} is {values!r}; finite numbers of 0 or more are allowed")
    return array


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingCampbell:
    """Hold the branches of a Campbell diagram as a turning body sees them.

    Each branch has c components, patterns of |μ| waves round the axis that turn about +z (μ > 0)
    or −z (μ < 0): μ = ±1 the two circles of an orbit, 0 axial motion and torsion.

    Attributes
    ----------
    body
        Name of the body; empty where only its speed ratio is known.
    speed_ratio
        n: the frame turns at nΩ.
    speeds_rad_s
        Ω of the reference shaft, shape (s,).
    orders
        μ of the components, shape (c,).
    signed_hz
        sign(μ) f − |μ| nΩ/2π with the inertial frequency f, shape (c, b, s), Hz; positive where
        the pattern turns about +z in the frame of the body. f itself for μ = 0; nan where a
        branch has ended.
    share
        Part of each component in the branch, 0 to 1 and 1 in all, shape (c, b, s); nan where it
        is not known or the body stands still.
    body_share
        Part of the body in the kinetic energy of the branch, shape (b, s); nan if not known.
    growth_rate_1_s
        Re λ, 1/s, the same in all frames, shape (b, s).
    share_source
        Where the shares come from: "kinetic energy" of the body's motion, "orbits" of its axis,
        "labels" of the diagram.
    """

    body: str
    speed_ratio: float
    speeds_rad_s: FloatArray
    orders: IntArray
    signed_hz: FloatArray
    share: FloatArray
    body_share: FloatArray
    growth_rate_1_s: FloatArray
    share_source: Literal["kinetic energy", "orbits", "labels"]

    def __post_init__(self) -> None:
        names = ("speeds_rad_s", "orders", "signed_hz", "share", "body_share", "growth_rate_1_s")
        freeze_arrays(self, *names)

    @property
    def spin_rad_s(self) -> FloatArray:
        """Spin speed of the body nΩ, rad/s, shape (s,)."""
        return self.speed_ratio * self.speeds_rad_s

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequencies the body sees, Hz, not negative, shape (c, b, s)."""
        return np.asarray(np.abs(self.signed_hz))

    @property
    def is_mirrored(self) -> BoolArray:
        """Whether a component turns the other way in the frame of the body, shape (c, b, s)."""
        return np.asarray(self.signed_hz * np.sign(self.orders)[:, None, None] < 0)

    @property
    def dominant(self) -> IntArray:
        """Index of the component with the largest share, shape (b, s); −1 where none is known."""
        known = np.nan_to_num(self.share, nan=-1.0)
        return np.where(known.max(axis=0) >= 0, known.argmax(axis=0), -1)


def campbell_in_rotating_frame(campbell: Campbell, speed_ratio: float) -> RotatingCampbell:
    """Transform a Campbell diagram to the frame of a body, with both circles of each orbit.

    `speed_ratio`: n of the body, negative for a counter-rotating one. Returns orders 1 and −1. The
    shares come from the labels: a "forward" branch is taken for a forward circle, a "backward" one
    for a backward circle, exact in supports that are the same in x and y; nan for "planar" and
    "mixed" branches, whose circles may be of any size. `body_frames.campbell_seen_by_body` measures
    the shares. Raises AnalysisError if the ratio is not finite.

    The frequencies of both components are exact for lateral motion whatever the shares. Axial
    motion and torsion, which a body sees at their own frequency, cannot be told apart here from
    an orbit that is a line.
    """
    if not np.isfinite(speed_ratio):
        raise AnalysisError(f"speed_ratio is {speed_ratio}; it must be finite")
    orders = np.array([1, -1])
    return RotatingCampbell(
        body="",
        speed_ratio=float(speed_ratio),
        speeds_rad_s=campbell.speeds_rad_s,
        orders=orders,
        signed_hz=signed_frequency(campbell, float(speed_ratio), orders),
        share=np.stack([_label_share(campbell, 1), _label_share(campbell, -1)]),
        body_share=np.full(campbell.frequency_hz.shape, np.nan),
        growth_rate_1_s=campbell.eigenvalues.real,
        share_source="labels",
    )


def signed_frequency(campbell: Campbell, speed_ratio: float, orders: IntArray) -> FloatArray:
    """Return the signed frequencies of a diagram's components in the frame of a body.

    `speed_ratio`: n of the body; `orders`: μ, shape (c,). Returns sign(μ) f − |μ| nΩ/2π, f for μ =
    0, shape (c, b, s), Hz.
    """
    turn = speed_ratio * campbell.speeds_rad_s / _TURN
    sign = np.where(orders == 0, 1, np.sign(orders))[:, None, None]
    return np.asarray(sign * campbell.frequency_hz - np.abs(orders)[:, None, None] * turn)


def _label_share(campbell: Campbell, order: int) -> FloatArray:
    """Return 1 where a branch is labelled as the order's whirl, 0 as the other, nan elsewhere."""
    # A label tells the sense relative to Ω, an order relative to +z.
    sense = np.where(campbell.speeds_rad_s < 0, -order, order)
    turning = np.select([campbell.whirl == "forward", campbell.whirl == "backward"], [1, -1], 0)
    return np.where(turning == 0, np.nan, (turning == sense).astype(float))
