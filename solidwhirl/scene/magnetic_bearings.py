"""Magnetic bearings of a scene: a controller in one of three forms and what is behind it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.core.fields import MOST, Finite, NotNegative, Positive, Record
from solidwhirl.rotordyn.bearings.speed_tables import SpeedTable
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.bearing_physics import AbsoluteLaw

if TYPE_CHECKING:  # loaded by a scene that has such a bearing
    from solidwhirl.rotordyn.bearings.controllers import Controller
    from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing

# Frequency of the damping that stands for a controller where one number is asked for, rad/s.
_COMMON = 2.0 * np.pi * 50.0
_Row = Annotated[tuple[Finite, ...], Field(max_length=MOST)]
_Rows = Annotated[tuple[_Row, ...], Field(max_length=MOST)]
_Powers = Annotated[tuple[Finite, ...], Field(min_length=1, max_length=50)]


class PidSpec(Record):
    """A controller P + I/s + D s / (1 + s / roll-off)."""

    kind: Literal["pid"]
    proportional_a_per_m: Finite
    integral_a_per_m_s: Finite = 0.0
    derivative_a_s_per_m: Finite = 0.0
    roll_off_hz: Positive | None = None

    def controller(self) -> Controller:
        """Return the controller of an axis."""
        from solidwhirl.rotordyn.bearings import controllers as ct

        roll_off = None if self.roll_off_hz is None else _rad_s(self.roll_off_hz)
        return ct.pid(
            self.proportional_a_per_m, self.integral_a_per_m_s, self.derivative_a_s_per_m, roll_off
        )


class TransferSpec(Record):
    """A controller as a quotient of polynomials in s, highest power first."""

    kind: Literal["transfer"]
    numerator: _Powers
    denominator: _Powers

    def controller(self) -> Controller:
        """Return the controller of an axis."""
        from solidwhirl.rotordyn.bearings import controllers as ct

        return ct.transfer(self.numerator, self.denominator)


class StateSpaceControllerSpec(Record):
    """A controller x' = A x + B y, i = −(C x + D y), of one axis or of x and y together."""

    kind: Literal["state_space"]
    a: _Rows
    b: _Rows
    c: _Rows
    d: _Rows

    def controller(self) -> Controller:
        """Return the controller of an axis, or of both."""
        from solidwhirl.rotordyn.bearings.controllers import Controller

        found = {key: _matrix(key, getattr(self, key)) for key in ("a", "b", "c", "d")}
        states = len(self.a)
        if len(self.b) != states:
            raise ValueError(f"b has {len(self.b)} rows; a has {states}")
        if not states:  # empty lists do not tell how many signals there are, d does
            outputs, inputs = found["d"].shape
            found["b"] = np.zeros((0, inputs))
            found["c"] = found["c"] if self.c else np.zeros((outputs, 0))
        return Controller(**found)


ControllerSpec = Annotated[
    PidSpec | TransferSpec | StateSpaceControllerSpec, Field(discriminator="kind")
]


class MagneticLawSpec(AbsoluteLaw):
    """A magnetic bearing, linear about its bias, with its controller."""

    kind: Literal["magnetic"]
    current_stiffness_n_per_a: Positive
    negative_stiffness_n_per_m: NotNegative
    controller: ControllerSpec
    controller_y: ControllerSpec | None = None
    low_pass_hz: Positive | None = None
    low_pass_damping_ratio: Positive | None = None
    sensor_hz: Positive | None = None
    amplifier_hz: Positive | None = None
    delay_s: NotNegative = 0.0

    @model_validator(mode="after")
    def _possible(self) -> MagneticLawSpec:
        self.bearing()
        return self

    def bearing(self) -> MagneticBearing:
        """Return the bearing; ValueError names what is wrong."""
        from solidwhirl.rotordyn.bearings import controllers as ct
        from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing

        if self.low_pass_damping_ratio is not None and self.low_pass_hz is None:
            raise ValueError("low_pass_damping_ratio needs low_pass_hz")
        first = self.controller.controller()
        if first.d.shape == (2, 2):
            if self.controller_y is not None:
                raise ValueError("controller has both axes; leave out controller_y")
            chain = [ct.side_by_side(part, part) for part in self._in_series()]
            whole = ct.series(first, *chain)
        else:
            axes = [first, (self.controller_y or self.controller).controller()]
            if any(axis.d.shape != (1, 1) for axis in axes):
                raise ValueError(
                    "a controller is of one signal in and out, or in state space of two for x and y"
                )
            whole = ct.side_by_side(*(ct.series(axis, *self._in_series()) for axis in axes))
        return MagneticBearing(
            current_stiffness_n_per_a=self.current_stiffness_n_per_a,
            negative_stiffness_n_per_m=self.negative_stiffness_n_per_m,
            controller=whole,
        )

    def _in_series(self) -> list[Controller]:
        """What comes in series with the controller of an axis."""
        from solidwhirl.rotordyn.bearings import controllers as ct

        parts = []
        if self.low_pass_hz is not None:
            parts.append(ct.low_pass(_rad_s(self.low_pass_hz), self.low_pass_damping_ratio))
        poles = (self.sensor_hz, self.amplifier_hz)
        parts += [ct.low_pass(_rad_s(pole)) for pole in poles if pole is not None]
        return parts + ([ct.delay(self.delay_s)] if self.delay_s else [])

    def table(self) -> SpeedTable:
        """Return the stiffness for slow motions, and the damping at 50 Hz."""
        bearing = self.bearing()
        stiffness = bearing.slow_stiffness()[0] - self.negative_stiffness_n_per_m * np.eye(2)
        damping = bearing.sensor_stiffness(1j * _COMMON).imag / _COMMON
        both = [np.array([matrix, matrix]) for matrix in (stiffness, damping)]
        return SpeedTable(np.array([0.0, 1.0]), both[0], both[1], "linear")


def _rad_s(frequency_hz: float) -> float:
    return 2.0 * np.pi * frequency_hz


def _matrix(key: str, rows: Sequence[Sequence[float]]) -> FloatArray:
    lengths = {len(row) for row in rows}
    if len(lengths) > 1:
        raise ValueError(f"{key} has rows of different lengths")
    return np.array(rows, dtype=float).reshape(len(rows), max(lengths, default=0))
