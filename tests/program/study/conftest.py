"""Measurements of a study whose errors and costs are known."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import Campbell, CriticalSpeed
from solidwhirl.study.measure import Measured, Usage

TRUE_HZ = np.array([[100.0, 90.0], [100.0, 110.0], [300.0, 280.0], [300.0, 320.0]])
WHIRL = [["straight", "backward"], ["straight", "forward"]] * 2


@pytest.fixture
def measurement():
    """Function: a measurement with frequencies and critical speeds off by a relative error."""

    def make(error=0.0, estimate=1e-7, unknowns=1000, cpu_s=2.0, memory_gib=0.2, rows=4):
        frequency = TRUE_HZ[:rows] * (1.0 + error)
        speed = 600.0 * (1.0 + error)
        return Measured(
            unknowns=unknowns,
            coordinates=20,
            bodies={"rotor": {"element_order": 2, "modes": 6}},
            startup=Usage(cpu_s=1.0, peak_memory_gib=0.1),
            plain=Usage(cpu_s=cpu_s, peak_memory_gib=memory_gib),
            estimated=None,
            wall_s=1.0,
            campbell=Campbell(
                speeds_rad_s=np.array([0.0, 500.0]),
                eigenvalues=2j * np.pi * frequency,
                frequency_hz=frequency,
                log_decrement=np.zeros_like(frequency),
                whirl=np.array(WHIRL[:rows]),
                shares=np.broadcast_to([1.0, 0.0, 0.0, 0.0], (*frequency.shape, 4)),
                overlap=np.ones_like(frequency),
                notes=(),
            ),
            critical_speeds=(
                CriticalSpeed(
                    speed_rad_s=speed,
                    frequency_hz=speed / (2.0 * np.pi),
                    whirl="forward",
                    shares=np.array([1.0, 0.0, 0.0, 0.0]),
                    shape=np.zeros(1, dtype=complex),
                    log_decrement=0.0,
                ),
            ),
            campbell_estimate=np.full(frequency.shape, estimate),
            critical_estimate=np.array([estimate]),
            parts={"mesh": estimate, "mode_truncation": 0.0},
        )

    return make
