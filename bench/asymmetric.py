"""Time of unstable ranges of an asymmetric rotor beside the Campbell diagram of a symmetric one.

A shaft of beams with two disks on two bearings, 60 coordinates: once bending alike in all
directions, by the road of fixed axes (all branches of the diagram and the unstable intervals), once
softer in one plane, in its own frame (all exponents up to twice the fastest change of the bearings,
and the unstable ranges). Everything in one process on one core; the ratio is what to quote.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time

import numpy as np

from solidwhirl.rotordyn import (
    Bearing,
    Disk,
    End,
    Rotor,
    Superelement,
    assemble,
    beam_superelement,
    campbell,
)
from solidwhirl.rotordyn.asymmetric import (
    Joint,
    PeriodicSystem,
    floquet_exponents,
    turning_body,
    unstable_ranges,
)
from solidwhirl.rotordyn.stability import unstable_intervals

SPEEDS = np.linspace(100.0, 1500.0, 51)
ENDS = {"left": 0.0, "right": 1.2}
# Damping along and cross stiffness of a bearing, N s/m and N/m.
CASES = ((2000.0, 1e6), (500.0, 0.0), (100.0, 0.0))


def shaft() -> Superelement:
    """The symmetric body: 15 stations with four motions each."""
    stations = np.linspace(0.0, 1.2, 15)
    disks = [
        Disk(name="first", position_m=stations[5], mass_kg=20.0, polar_kg_m2=0.3,
             diametral_kg_m2=0.16),
        Disk(name="second", position_m=stations[10], mass_kg=15.0, polar_kg_m2=0.2,
             diametral_kg_m2=0.11),
    ]  # fmt: skip
    return beam_superelement("rotor", stations, 0.03, 0.0, (2e11, 0.3, 7800.0), ENDS, disks)


def bearing(drag: float, cross: float):
    """Stiffness and damping across the axis."""
    return np.array([[6e7, cross], [-cross, 3e7]]), drag * np.diag([1.0, 0.5])


def in_fixed_axes(stiffness, damping):
    """The symmetric rotor on its bearings."""
    bearings = tuple(
        Bearing(
            name=end,
            first=End(body="rotor", interface=end),
            stiffness_n_per_m=stiffness,
            damping_n_s_per_m=damping,
        )
        for end in ENDS
    )
    return assemble({"rotor": Rotor(element=shaft(), speed_ratio=1.0)}, bearings, "rotor")


def in_its_own_axes(stiffness, damping, soft: float) -> PeriodicSystem:
    """The rotor whose bending stiffness across is `soft` times that along."""
    body = shaft()
    turn, own = body.spin_generator, body.stiffness.copy()
    first = [c.component in ("ux", "ry") if c.kind == "interface" else k % 2 == 0
             for k, c in enumerate(body.coordinates)]  # fmt: skip
    across = np.flatnonzero(~np.array(first))
    own[np.ix_(across, across)] *= soft
    matrices = {
        "mass": body.mass,
        "gyroscopic": body.gyroscopic + 2.0 * body.mass @ turn,
        "stiffness": own,
        "centrifugal_stiffness": (body.mass @ turn + body.gyroscopic) @ turn,
    }
    spring, drag = np.zeros((2, 6, 6))
    spring[:2, :2], drag[:2, :2] = stiffness, damping
    joints = []
    for end in ENDS:
        motion = np.zeros((6, body.size))
        for row, component in enumerate(("ux", "uy", "uz", "rx", "ry", "rz")):
            if component in ("ux", "uy", "rx", "ry"):
                motion[row, body.interface_index(end, component)] = 1.0
        joints.append(Joint(motion, spring, drag))
    return turning_body(matrices, joints)


def cpu_s(function, *arguments):
    """Seconds of the processor, and the result."""
    begun = time.process_time()
    found = function(*arguments)
    return time.process_time() - begun, found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--soft", type=float, default=0.7)
    asked = parser.parse_args()
    low, high = SPEEDS[[0, -1]].tolist()
    for drag, cross in CASES:
        held = bearing(drag, cross)
        twin, own = in_fixed_axes(*held), in_its_own_axes(*held, asked.soft)
        diagram, _ = cpu_s(lambda: campbell(twin, SPEEDS, branch_count=twin.size))  # noqa: B023
        windows, _ = cpu_s(unstable_intervals, twin, low, high)
        exponents, _ = cpu_s(floquet_exponents, own, SPEEDS)
        search, ranges = cpu_s(unstable_ranges, own, low, high)
        ratio = (exponents + search) / (diagram + windows)
        print(
            f"{own.size} coordinates, damping {drag:g} N s/m, cross {cross:g} N/m: symmetric "
            f"{diagram:.2f} + {windows:.2f} s, asymmetric {exponents:.2f} + {search:.2f} s, "
            f"{len(ranges)} ranges, ratio {ratio:.1f}",
            flush=True,
        )
        for one in ranges:
            print(
                f"  {one.low_rad_s:9.3f} to {one.high_rad_s:9.3f} rad/s, growth "
                f"{one.growth_1_s:9.4f} (multipliers {one.floquet_1_s:9.4f}) 1/s, {one.meeting}"
            )


if __name__ == "__main__":
    main()
