"""Lowest modes of a system at one speed after another, by few whole spectra."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.perturbation.continued_spectrum import NearModes, known_spectrum

# Where one spectrum reaches no farther the next is taken so far ahead, as a part of that reach.
_AHEAD = 0.75


class LowestModes:
    """Compute modes on demand: the lowest alone, from the spectrum of another speed, if they do.

    `mode_count`: modes to compute where a spectrum is; `needed`: number of lowest modes of a speed
    that must be there. `coming_rad_s`: speeds that will be asked for, shape (s,), monotonic.
    """

    def __init__(
        self, assembled: AssembledSystem, mode_count: int, needed: Callable[[Modes], int]
    ) -> None:
        self._assembled, self._mode_count, self._needed = assembled, mode_count, needed
        self.coming_rad_s: FloatArray = np.empty(0)
        self._known: dict[float, Modes] = {}
        self._spectra: list[NearModes] = []
        self._continued: set[float] = set()

    def at(self, speed_rad_s: float) -> Modes:
        """Return the modes at a speed, computed once: the lowest alone where that is enough."""
        is_known = self._reaches(speed_rad_s)
        if not is_known and (ahead := self._ahead_of(speed_rad_s)) is not None:
            self.whole_at(ahead)
            # back from there, as each helps to find the next
            coming = self.coming_rad_s[::-1]
            between = (coming - speed_rad_s) * (coming - ahead) < 0
            is_known = all(map(self._reaches, [*coming[between].tolist(), speed_rad_s]))
        return self._known[speed_rad_s] if is_known else self.whole_at(speed_rad_s)

    def _reaches(self, speed_rad_s: float) -> bool:
        """Whether modes at a speed are known, or at hand, and so become known."""
        if speed_rad_s not in self._known and (found := self.at_hand(speed_rad_s)) is not None:
            self._known[speed_rad_s] = found
            self._continued.add(speed_rad_s)
        return speed_rad_s in self._known

    def whole_at(self, speed_rad_s: float) -> Modes:
        """Return all modes to compute at a speed, from which those at others are found."""
        if self.is_part(speed_rad_s) or speed_rad_s not in self._known:
            found = modes_at_speed(self._assembled, speed_rad_s, self._mode_count)
            self._known[speed_rad_s] = found
            self._continued.discard(speed_rad_s)
            needed = self._needed(found)
            spectrum = known_spectrum(self._assembled, found, needed) if needed else None
            self._spectra += [] if spectrum is None else [NearModes(self._assembled, spectrum)]
        return self._known[speed_rad_s]

    def is_part(self, speed_rad_s: float) -> bool:
        """Whether of a speed the lowest modes alone are known."""
        return speed_rad_s in self._continued

    def at_hand(self, speed_rad_s: float) -> Modes | None:
        """Return the lowest modes at a speed from the nearest whole spectrum, all that matter."""
        near = self._nearest(speed_rad_s)
        found = None if near is None else near.at(speed_rad_s)
        # the last one shows that no needed one of equal frequency is cut off
        enough = found is not None and self._needed(found) < found.eigenvalues.size
        return found if enough else None

    def _nearest(self, speed_rad_s: float) -> NearModes | None:
        return min(
            self._spectra, key=lambda s: abs(s.known.speed_rad_s - speed_rad_s), default=None
        )

    def _ahead_of(self, speed_rad_s: float) -> float | None:
        """Return a speed to come from whose spectrum modes may be found back to one and beyond."""
        near = self._nearest(speed_rad_s)
        if near is None:
            return None
        reach = speed_rad_s - near.known.speed_rad_s
        between = (self.coming_rad_s - speed_rad_s) / reach
        ahead = self.coming_rad_s[(between > 0) & (between <= _AHEAD)]
        return float(ahead[-1]) if ahead.size else None
