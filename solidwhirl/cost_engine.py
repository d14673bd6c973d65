"""What of a scene decides the cost of its assembled engine: size, damping, evenness, exciters."""

from __future__ import annotations

import numpy as np

from solidwhirl.imported_bodies import imported_element
from solidwhirl.plan_records import Plan
from solidwhirl.scene import Scene
from solidwhirl.scene_base import Matrix


def simple_coordinates(plan: Plan, scene: Scene) -> int:
    """Coordinates of beams, rigid and imported bodies, at most."""
    out = 6 * len(scene.rigid_bodies)
    for name, spec in scene.beams.items():
        carried = {m for place in spec.interfaces for m in plan.carried[f"{name}.{place}"]}
        nodes = len({*spec.stations_m, *spec.interfaces.values(), *(d.at_m for d in spec.disks)})
        out += nodes * len({"ux", "uy", "rx", "ry", *carried})
    return out + sum(imported_element(name, s).size for name, s in scene.imported.items())


def engine_kind(plan: Plan, scene: Scene) -> str:
    """Which eigenproblem the engine has: damped, undamped with uneven supports, or even."""
    if plan.on("bearing_damping") or plan.on("internal_damping"):
        return "damped"
    even = not scene.imported and all(
        _is_even(bearing.stiffness_n_per_m) for bearing in scene.bearings
    )
    return "even" if even and not plan.on("speed_dependent_bearings") else "uneven"


def _is_even(stiffness: Matrix) -> bool:
    """Whether a stiffness is the same in all directions."""
    (xx, xy), (yx, yy) = stiffness
    return xx == yy and xy == -yx


def exciters(plan: Plan, scene: Scene) -> int:
    """Different speeds at which unbalances turn."""
    if float(np.max(plan.speeds_rad_s)) == 0.0:
        return 0
    return len({abs(ratio) for ratio in scene.speed_ratios().values() if ratio})
