"""Magnetic bearings as laws: the force of a controller, its sensors at the magnets or apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.assembly.bearing_laws import OfAnotherLaw, SpeedLaw
from solidwhirl.rotordyn.assembly.frequency_laws import AnyFrequencyLaw, Coefficients
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MagneticLaw(AnyFrequencyLaw):
    """Z(s) = ki H(s) − ks of a magnetic bearing on (ux, uy), the same at all spin speeds.

    Of slow motions K and C are those of s = 0; where the controller integrates, K is that of a very
    slow motion, which is very stiff.
    """

    name: str
    bearing: MagneticBearing

    # nothing of it comes from the spin
    is_symmetric = True
    follows_spin = False

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest spin speed: any."""
        return 0.0, np.inf

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(s), shape (2, 2)."""
        return self.bearing.dynamic_stiffness(speed_rad_s, rate)

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K and C at a frequency, as if the sensors were at the magnets."""
        whole = self.sensed_apart().at_frequency(speed_rad_s, frequency_rad_s)
        return Coefficients(*(matrix[:2, :2] + matrix[:2, 2:] for matrix in whole))

    def sensed_apart(self) -> SensedApartLaw:
        """Return the law on ux and uy of the magnets, then of the sensors."""
        return SensedApartLaw(law=self)


@dataclass(frozen=True, kw_only=True)
class SensedApartLaw(OfAnotherLaw, AnyFrequencyLaw):
    """A magnetic bearing on ux, uy of magnets, then of sensors: Z = [[−ks, ki H], [0, 0]]."""

    law: MagneticLaw
    size = 4
    is_symmetric = True
    follows_spin = False

    @property
    def bearing(self) -> MagneticBearing:
        """The bearing itself."""
        return self.law.bearing

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(s), shape (4, 4)."""
        return self._whole(self.bearing.sensor_stiffness(rate))

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K and C at a frequency, (4, 4) each."""
        frequency = abs(frequency_rad_s)
        if frequency == 0.0:
            gain, slope = self.bearing.slow_stiffness()
        else:
            found = self.bearing.sensor_stiffness(1j * frequency)
            gain, slope = found.real, found.imag / frequency
        damping = self._whole(slope) - self._whole(np.zeros((2, 2)))
        return Coefficients(self._whole(gain).real, damping.real, np.zeros((4, 4)))

    def _whole(self, sensed: ComplexArray | FloatArray) -> ComplexArray:
        held = -self.bearing.negative_stiffness_n_per_m * np.eye(2)
        return np.block([[held, sensed], [np.zeros((2, 4))]]).astype(complex)


def magnetic_bearing(law: SpeedLaw) -> MagneticBearing | None:
    """Return the magnetic bearing of a law, None of another one."""
    return law.bearing if isinstance(law, MagneticLaw | SensedApartLaw) else None
