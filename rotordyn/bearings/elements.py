"""What ball and roller bearings share: their elements on the pitch circle, in one row or more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray

# Motions of a ring with its rows: ux, uy, uz, rx, ry, and the shifts of rows that carry +z and −z.
RING_MOTIONS = 7


class ElementForces(NamedTuple):
    """Forces of rolling elements, and what makes them.

    Of each of N elements, along its r own directions: `force`: (b, N, r); `stiffness`: (b, N, r,
    r), or (b, N, r) where the directions are independent. Of all of them, at motions of the ring
    and its rows: `force` that is needed to hold them there, N and N m, (b, 7); `stiffness`, its
    derivative, (b, 7, 7). In both cases `inner_load_n`, `outer_load_n`: on the two races;
    `inner_angle_rad`, `outer_angle_rad`: contact angles, (b, N) each; `gap_m`: smooth, and of
    another sign on either side of a corner of the forces, such as the loss of contact, (b, g);
    `place`: where balls are, to begin the next search from, (b, N, 2).
    """

    force: FloatArray
    stiffness: FloatArray
    inner_load_n: FloatArray
    outer_load_n: FloatArray
    inner_angle_rad: FloatArray
    outer_angle_rad: FloatArray
    gap_m: FloatArray
    place: FloatArray


class Elements(Protocol):
    """A row of balls or rollers."""

    @property
    def element_count(self) -> int:
        """Number of elements."""

    def seen(self, angle: FloatArray) -> FloatArray:
        """Return what the ring does at elements at angles (..., Z) from +x, (..., Z, r, 5)."""

    def contacts(
        self, moved: FloatArray, centrifugal_n: FloatArray, near: FloatArray | None
    ) -> ElementForces:
        """Return the forces of each element at motions (b, N, r) of the ring there.

        `centrifugal_n`: that presses an element outward, (b,); `near`: `place` of a state nearby.
        """


def row_motion(facing: int, place_m: float) -> FloatArray:
    """Return what a ring does at one of its rows, (5, 7).

    `facing`: 1 of a row that carries a load on the inner ring along +z, −1 along −z; `place_m`:
    along z from the middle of the ring.
    """
    motion = np.eye(5, RING_MOTIONS)
    motion[0, 4], motion[1, 3] = place_m, -place_m
    motion[2:] *= facing
    motion[2, 5 if facing > 0 else 6] = 1.0
    return motion


def element_forces(
    row: Elements,
    rows: Sequence[FloatArray],
    motion: FloatArray,
    position: FloatArray,
    centrifugal_n: FloatArray,
    near: FloatArray | None = None,
) -> ElementForces:
    """Return what all elements of equal rows do together.

    `rows`: `row_motion` of each; `motion`: (b, 7); `position`: angle of the first element of each
    row from +x, (b,); `centrifugal_n`: that presses an element outward, (b,);
    `near`: `place` of a state nearby.
    """
    angle = position[:, None] + 2.0 * np.pi * np.arange(row.element_count) / row.element_count
    seen = row.seen(angle)
    seen = np.concatenate([seen @ one for one in rows], axis=1)
    found = row.contacts(np.einsum("bnri,bi->bnr", seen, motion), centrifugal_n, near)
    pushed = (
        found.stiffness @ seen if found.stiffness.ndim == 4 else found.stiffness[..., None] * seen
    )
    flat = seen.reshape(len(motion), -1, RING_MOTIONS)
    return found._replace(
        force=np.einsum("bki,bk->bi", flat, found.force.reshape(len(motion), -1)),
        stiffness=flat.swapaxes(1, 2) @ pushed.reshape(flat.shape),
    )


def element_problems(what: str, count: int, diameter_m: float, pitch_m: float) -> list[str]:
    """Return what is wrong with the number and size of balls or rollers, `what` they are called."""
    problems = []
    if count < 3:
        problems.append(f"{count} {what}s; needed are 3 or more")
    if not 0 < diameter_m < pitch_m < np.inf:
        problems.append(
            f"{what} diameter {diameter_m:g} m, pitch diameter {pitch_m:g} m; needed is "
            f"0 < {what} diameter < pitch diameter"
        )
    elif count * diameter_m > np.pi * pitch_m:
        problems.append(f"{count} {what}s do not fit on the pitch circle")
    return problems


def centrifugal_load_n(mass_kg: float, pitch_m: float, ratio: float, speed_rad_s: float) -> float:
    """Return the load that presses an element outward, N.

    It goes round with ½ Ω (1 − ratio), the ratio being Dw cos α / Dpw, at the speed of the inner
    ring Ω.
    """
    orbit = 0.5 * speed_rad_s * (1.0 - ratio)
    return float(0.5 * mass_kg * pitch_m * orbit**2)
