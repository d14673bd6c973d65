"""Critical speeds with bearings whose force depends on frequency and growth, as added mass has it.

At the frequency of the excitation they are found as if bearings depended on the speed alone; from
there each is followed to the law itself, whose part is raised from none to all.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.assembly.bearing_laws import OfAnotherLaw
from solidwhirl.rotordyn.assembly.frequency_laws import AnyFrequencyLaw, FrequencyLaw
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.refined import Meeting, refined_root
from solidwhirl.rotordyn.modes.damping import PEAKLESS, damping_ratio

# Parts of the law in one step at first and at least, and how far (relative) a speed moves in one.
_STEP, _LEAST, _FARTHEST = 0.5, 1.0 / 64.0, 0.2


@dataclasses.dataclass(frozen=True, kw_only=True)
class _PartlyGrowing(OfAnotherLaw, AnyFrequencyLaw):
    """A law, and the same as it is without growth at the frequency, in parts."""

    law: FrequencyLaw
    part: float

    @property
    def size(self) -> int:  # type: ignore[override]
        return self.law.size

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        k, c, m = self.law.at_frequency(speed_rad_s, rate.imag)
        without = k + rate * c - rate.imag**2 * m
        with_growth = self.law.dynamic_stiffness(speed_rad_s, rate)
        return np.asarray((1.0 - self.part) * without + self.part * with_growth)


def with_growth(
    assembled: AssembledSystem, ratio: float, known: Sequence[Meeting]
) -> list[Meeting]:
    """Return critical speeds of a system from those with its bearings at the frequency αΩ.

    `ratio`: |α|; `known`: of the system that `at_whirl_ratio` returns. Motions that have no
    resonance may be lost on the way. Raises AnalysisError if another one is.
    """
    found = []
    for meeting in known:
        moved = _moved(assembled, ratio, meeting)
        if moved is not None:
            found.append(moved)
        elif damping_ratio(np.array([meeting.value]))[0] < PEAKLESS:
            raise AnalysisError(
                f"the critical speed near {meeting.speed:.6g} rad/s is lost as the growth of the "
                "motion is taken into account in the force of the bearings"
            )
    return found


def _moved(assembled: AssembledSystem, ratio: float, meeting: Meeting) -> Meeting | None:
    part, step = 0.0, _STEP
    while part < 1.0:
        step = min(step, 1.0 - part)
        root = refined_root(_partly(assembled, part + step), ratio, meeting, _FARTHEST)
        if root is not None:
            part, meeting = part + step, root.meeting
        else:
            step *= 0.5
            if step < _LEAST:
                return None
    return meeting


def _partly(assembled: AssembledSystem, part: float) -> AssembledSystem:
    if part >= 1.0:
        return assembled
    joints = tuple(
        joint
        if joint.frequency_law is None
        else joint.with_law(_PartlyGrowing(law=joint.frequency_law, part=part))
        for joint in assembled.law_joints
    )
    return dataclasses.replace(assembled, law_joints=joints)
