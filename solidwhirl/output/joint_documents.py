"""Pressed faces of joints as plain data."""

from __future__ import annotations

from typing import Any

from solidwhirl.core.joint_states import JointState
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S


def joint_document(state: JointState) -> dict[str, Any]:
    """Pressure, lifted part, torque and stress of a joint over the speeds of its body."""

    def rpm(speed: float | None) -> float | None:
        return None if speed is None else speed * RPM_PER_RAD_S

    return {
        "between": list(state.between),
        "interference_m": state.interference_m,
        "friction": state.friction,
        "area_m2": state.area_m2,
        "lifts_at_rpm": rpm(state.lifts_at_rad_s),
        "loose_at_rpm": rpm(state.loose_at_rad_s),
        "speed_rpm": (state.speeds_rad_s * RPM_PER_RAD_S).tolist(),
        "mean_pressure_pa": state.mean_pressure_pa.tolist(),
        "lifted_part": state.lifted_part.tolist(),
        "torque_n_m": state.torque_n_m.tolist(),
        "stress_pa": state.stress_pa.tolist(),
        "along_m": state.along_m.tolist(),
        "pressure_pa": state.pressure_pa.tolist(),
    }
