"""Undamped critical speeds over the stiffness of supports."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import (
    Field,
)

from solidwhirl.analyses.base import (
    Engine,
    OperatingSpec,
    Stiffnesses,
)
from solidwhirl.core.fields import (
    Count,
    Name,
    Positive,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.plots.maps import draw_critical_speed_map


class CriticalSpeedMapSpec(Stiffnesses):
    """Critical speeds over the stiffness of supports."""

    kind: Literal["critical_speed_map"]
    excited_by: Name
    branches: Annotated[Count, Field(le=50)] = 6
    search_to_rpm: Positive
    operating_speed_rpm: Positive | None = None

    def operating_named(self) -> Iterator[OperatingSpec]:
        """Yield the operating speed that it is drawn for."""
        rpm = self.operating_speed_rpm
        if rpm is not None:
            yield OperatingSpec(shaft=self.excited_by, from_rpm=rpm, to_rpm=rpm)

    def run(self, engine: Engine) -> Outcome:
        """Undamped critical speeds over the stiffness of supports."""
        stiffness = np.geomspace(
            self.stiffness_from_n_per_m, self.stiffness_to_n_per_m, self.stiffness_count
        )
        ratio = abs(engine.speed_ratio(self.excited_by))
        found = critical_speed_map(
            engine.system,
            self.bearings,
            stiffness,
            excitation_ratio=ratio,
            branch_count=self.branches,
            speed_max_rad_s=self.search_to_rpm * RAD_S_PER_RPM / ratio,
        )
        operating = {}
        if self.operating_speed_rpm is not None:
            operating[self.excited_by] = self.operating_speed_rpm * RAD_S_PER_RPM / ratio
        return Outcome(
            kind=self.kind,
            document={
                "bearings": list(self.bearings),
                "excited_by": self.excited_by,
                "stiffness_n_per_m": stiffness.tolist(),
                "critical_speed_rpm": (found.speed_rad_s * RPM_PER_RAD_S).tolist(),
                "shaft_speed_rpm": (ratio * found.speed_rad_s * RPM_PER_RAD_S).tolist(),
                "whirl": [[w or None for w in branch] for branch in found.whirl.tolist()],
                "free_rpm": (found.free_rad_s * RPM_PER_RAD_S).tolist(),
                "rigid_rpm": (found.rigid_rad_s * RPM_PER_RAD_S).tolist(),
                "operating_speed_rpm": self.operating_speed_rpm,
            },
            files={
                f"{self.label}.png": lambda path: draw_critical_speed_map(
                    found, path, engine.title, operating
                )
            }
            if np.isfinite(found.speed_rad_s).any()
            else {},
            headline=f"{len(found.speed_rad_s)} branches over {self.stiffness_count} stiffnesses",
        )
