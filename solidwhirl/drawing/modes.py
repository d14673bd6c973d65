"""Which modes are shown: at rest, at the speeds of the scene, at the critical speeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn import AssembledSystem, Campbell, Modes, modes_at_speed
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.kinds import motion_words
from solidwhirl.rotordyn.modes.whirl import motion_at_speed
from solidwhirl.rotordyn.plots.chart import hertz_text
from solidwhirl.rotordyn.plots.frame import mode_name

# Speeds, modes at each, and critical speeds that a page shows.
_SPEEDS, MODES, _CRITICAL = 4, 8, 12


@dataclass(frozen=True, kw_only=True, eq=False)
class ShownModes:
    """Modes that are chosen together.

    `label` and `texts` are what a list says of all and of each. The modes of the system are by
    rising frequency; those at critical speeds are each at its own `rpm` of the reference shaft,
    shape (m,). `numbers` are their branches of the Campbell diagram from 1, 0 for none; None where
    they are no list.
    """

    label: str
    modes: Modes
    rpm: FloatArray
    whirl: tuple[str, ...]
    texts: tuple[str, ...]
    numbers: tuple[int, ...] | None = None

    def only(self, kept: Sequence[int]) -> ShownModes:
        """Return some of the modes, by their places."""
        return replace(
            self,
            modes=_part(self.modes, kept),
            rpm=self.rpm[[*kept]],
            whirl=tuple(self.whirl[k] for k in kept),
            texts=tuple(self.texts[k] for k in kept),
            numbers=None if self.numbers is None else tuple(self.numbers[k] for k in kept),
        )


def shown_modes(results: Results) -> tuple[ShownModes, ...]:
    """Return the modes of a run that its page shows.

    Those at the speeds of its mode shape analyses, or at rest and at its top speed where it has
    none, then those at its critical speeds. With asymmetric bodies those at rest alone: at speed
    their shapes are none of fixed axes.
    """
    system = results.system
    if results.asymmetry is not None:
        return (_at_rest(results, MODES),)
    found = []
    for rpm in _speeds(results):
        speed = rpm / RPM_PER_RAD_S
        modes = results.at_rest if rpm == 0.0 else modes_at_speed(system, speed, MODES)
        # equal frequencies may be more than a list should hold
        modes = _part(modes, range(min(modes.eigenvalues.size, MODES)))
        if modes.eigenvalues.size:
            found.append(_at_speed(system, results.campbell, rpm, modes))
    return (*found, *critical_modes(results))


def pictured_modes(results: Results, count: int) -> tuple[str, ShownModes | None]:
    """Return the modes that pictures show, and how their names begin.

    Those at the lowest critical speeds; where there is none, the lowest ones of the Campbell
    diagram at its last speed. With asymmetric bodies those at rest.
    """
    if results.asymmetry is not None:
        return "mode", _at_rest(results, count)
    for critical in critical_modes(results, count):
        return "mode_critical", critical
    diagram = results.campbell
    branches = int(np.isfinite(diagram.frequency_hz[:, -1]).sum())
    if not min(count, branches):
        return "mode", None
    speed = float(diagram.speeds_rad_s[-1])
    highest = float(np.nanmax(diagram.frequency_hz[:, -1]))
    modes, more = modes_at_speed(results.system, speed, branches), branches
    # modes that the diagram leaves out lie between its branches
    while modes.frequency_hz.size == more and modes.frequency_hz.max() < highest:
        more *= 2
        modes = modes_at_speed(results.system, speed, more)
    shown = _at_speed(results.system, diagram, speed * RPM_PER_RAD_S, modes)
    return "mode", shown.only([k for k, number in enumerate(shown.numbers or ()) if number][:count])


def _at_rest(results: Results, count: int) -> ShownModes:
    """The lowest modes at rest, of asymmetric bodies at the angle 0."""
    modes = _part(results.at_rest, range(min(results.at_rest.eigenvalues.size, count)))
    motion = motion_at_speed(results.system, modes.shapes, modes.eigenvalues, 0.0)
    return ShownModes(
        label="at rest",
        modes=modes,
        rpm=np.zeros(modes.eigenvalues.size),
        whirl=tuple(str(w) for w in motion.whirl),
        texts=tuple(
            f"mode {k + 1}, {hertz_text(f)}, {motion_words(w, s)}"
            for k, (f, w, s) in enumerate(zip(modes.frequency_hz, *motion, strict=True))
        ),
    )


def _speeds(results: Results) -> list[float]:
    """Speeds, rpm, rising."""
    asked = [
        float(rpm)
        for spec in results.scene.analyses
        if spec.kind == "mode_shapes"
        for rpm in spec.speeds_rpm
    ]
    top = float(results.campbell.speeds_rad_s.max()) * RPM_PER_RAD_S
    return sorted({round(rpm, 9) for rpm in asked or [0.0, top]})[:_SPEEDS]


def _part(modes: Modes, kept: Sequence[int]) -> Modes:
    chosen = np.array(kept, dtype=int)
    family = None if modes.family is None else modes.family[chosen]
    return replace(
        modes, eigenvalues=modes.eigenvalues[chosen], shapes=modes.shapes[:, chosen], family=family
    )


def _at_speed(system: AssembledSystem, diagram: Campbell, rpm: float, modes: Modes) -> ShownModes:
    motion = motion_at_speed(system, modes.shapes, modes.eigenvalues, modes.speed_rad_s)
    numbers = tuple(int(k) for k in branch_numbers(system, diagram, modes))
    hertz = modes.eigenvalues.imag / (2.0 * np.pi)
    return ShownModes(
        label="at rest" if rpm == 0.0 else f"at {rpm:.0f} rpm",
        modes=modes,
        rpm=np.full(hertz.size, rpm),
        whirl=tuple(str(w) for w in motion.whirl),
        numbers=numbers,
        texts=tuple(
            f"mode {mode_name(numbers, k)}, {hertz_text(f)}, {motion_words(w, s)}"
            for k, (f, w, s) in enumerate(zip(hertz, *motion, strict=True))
        ),
    )


def critical_modes(results: Results, most: int = _CRITICAL) -> tuple[ShownModes, ...]:
    """Return the modes at the lowest critical speeds, those of several exciters once.

    Those that unbalance excites come first.
    """
    entries: dict[tuple[float, float, str], Any] = {}
    rule = results.scene.criteria.rule
    order = sorted(
        results.critical_speeds,
        key=lambda c: (not c.excitation.excited, float(c.critical.speed_rad_s)),
    )
    for c in order:
        found = c.critical
        if not found.counts(rule):
            continue
        # a pair of backward and forward whirl may be at one speed
        place = round(float(found.speed_rad_s), 6), round(float(found.frequency_hz), 6)
        key = (*place, str(found.whirl))
        entries.setdefault(key, c)
    chosen = list(entries.values())[:most]
    if not chosen:
        return ()
    critical = [c.critical for c in chosen]
    rpm = np.array([c.speed_rad_s * RPM_PER_RAD_S for c in critical])
    omega = np.array([2.0 * np.pi * c.frequency_hz for c in critical])
    decrement = np.array([c.log_decrement for c in critical])
    modes = Modes(
        speed_rad_s=float(critical[0].speed_rad_s),
        eigenvalues=omega * (1j - decrement / (2.0 * np.pi)),
        shapes=np.column_stack([c.shape for c in critical]).astype(complex),
        real_eigenvalues=np.empty(0),
        zero_count=0,
        negative_stiffness_count=0,
    )
    shown = ShownModes(
        label="at the critical speeds",
        modes=modes,
        rpm=rpm,
        whirl=tuple(str(c.whirl) for c in critical),
        texts=tuple(
            f"{c.speed_rad_s * RPM_PER_RAD_S:.1f} rpm, {hertz_text(c.frequency_hz)}, "
            f"{motion_words(c.whirl, c.shares)}"
            for c in critical
        ),
    )
    return (shown,)
