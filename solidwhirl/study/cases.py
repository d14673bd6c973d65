"""The cases of a study: one scene with ladders of `[model]` settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from solidwhirl.geometry import Blade
from solidwhirl.meshing import CORNER_RATE
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene.records import Scene

# Fixed meshes: the estimates' own comparison models follow this accuracy.
_FIXED_ACCURACY = 5e-3
# Sizes over the thinnest section: largest element, element at corners, uniform elements.
_LARGEST, _CORNER, _UNIFORM = 4.0, 0.3, 2.0
# One rung of the graded ladder divides the largest size by this.
_STEP = 2.0**0.5


@dataclass(frozen=True, kw_only=True)
class Ladders:
    """How much a study runs.

    `reference` (the truth) and `adaptive` are accuracies by level; `graded` and `uniform` are rungs
    (refinements) of the harmonic level by element order, `solid` graded ones of sectors; `modes`
    are numbers of fixed-interface modes on one fine graded mesh of order 4. The mesh ladders have
    so many modes that the mesh's error shows. Cases with a longer predicted processor time [s],
    which is also longer than that of the reference, are skipped. Bodies with blades, holes or slots
    are solids in all cases.
    """

    reference: Mapping[str, float]
    graded: Mapping[int, Sequence[int]]
    uniform: Mapping[int, Sequence[int]]
    solid: Sequence[int]
    adaptive: Mapping[str, Sequence[float]]
    modes: Sequence[int]
    ladder_modes: int
    longest_s: float


FULL = Ladders(
    reference={"harmonic": 1e-6, "solid": 5e-4},
    graded={2: range(-1, 6), 3: range(-1, 5), 4: range(4)},
    uniform={2: range(4), 3: range(3), 4: range(2)},
    solid=range(-2, 8),
    adaptive={"harmonic": (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), "solid": (1e-1, 1e-2, 3e-3, 1e-3, 3e-4)},
    modes=(2, 4, 8, 16),
    ladder_modes=24,
    longest_s=600.0,
)
QUICK = Ladders(
    reference={"harmonic": 1e-4, "solid": 5e-3},
    graded={2: (-1, 0, 2, 5)},
    uniform={},
    solid=(-2, 0, 2, 5),
    adaptive={"harmonic": (1e-2,), "solid": (1e-2,)},
    modes=(),
    ladder_modes=6,
    longest_s=20.0,
)


@dataclass(frozen=True, kw_only=True)
class StudyCase:
    """One case: the scene with another `[model]` table, run in a process of its own."""

    name: str  #: Unique in the study
    ladder: str  #: "reference", "graded", "uniform", "adaptive", "modes" or "beam"
    settings: Mapping[str, Any]  #: The `[model]` keys that are set
    scene: Scene  #: What is run
    #: "both" runs it without and with error estimates, "on" and "off" once; an adaptive mesh needs
    #: them
    estimates: Literal["both", "on", "off"] = "both"

    @property
    def level(self) -> str:
        """The model level."""
        return str(self.settings["level"])

    @property
    def series(self) -> str:
        """Name of the line it is drawn on and fitted with, such as "harmonic, order 3, graded"."""
        if self.ladder in ("beam", "reference"):
            return self.ladder
        order = [f"order {self.settings['order']}"] if "order" in self.settings else []
        return ", ".join([self.level, *order, self.ladder])


def study_cases(scene: Scene, ladders: Ladders) -> tuple[StudyCase, ...]:
    """Return the cases of a study, the reference first; analyses of the scene are left out."""
    bodies = {name: b.model_copy(update={"modes": None}) for name, b in scene.bodies.items()}
    base = scene.model_copy(update={"analyses": (), "bodies": bodies})
    spec = type(scene.model)
    return tuple(
        StudyCase(
            name=name,
            ladder=ladder,
            settings=settings,
            estimates="on" if ladder in ("adaptive", "reference") else "both",
            scene=base.model_copy(
                update={"model": spec.model_validate({"compare_coupling": "off", **settings})}
            ),
        )
        for name, ladder, settings in _settings(
            thinnest_m(scene), ladders, only_solid=has_features(scene)
        )
    )


def has_features(scene: Scene) -> bool:
    """Return whether a body has blades, holes or slots, which no level but the solid has."""
    return any(body.features for body in build_bodies(scene).values())


def thinnest_m(scene: Scene) -> float:
    """Return the smallest dimension of sections and blades of all bodies, m: it sets the sizes."""
    bodies = build_bodies(scene).values()
    blades = [f for b in bodies for f in b.features if isinstance(f, Blade)]
    return min(
        *(
            min(
                s.end_m - s.start_m,
                max(o - i for i, o in zip(s.inner_radius_m, s.outer_radius_m, strict=True)),
            )
            for body in bodies
            for s in body.sections
        ),
        *(max(blade.thickness_m) for blade in blades),
        np.inf,
    )


def graded_sizes(thinnest: float, order: int, rung: int) -> dict[str, float]:
    """Return the sizes of a graded mesh, m.

    Each rung divides largest size and growth by √2 and the size at corners by √2 to the power
    2p / 1.089, so that the error of the corners falls as fast as that of smooth fields would.
    """
    factor = _STEP**-rung
    corner = _CORNER * thinnest * factor ** (2.0 * order / CORNER_RATE)
    size = _LARGEST * thinnest * factor
    return {
        "size_m": size,
        "corner_size_m": min(max(corner, 1e-5 * thinnest), size),
        "growth": factor,
    }


def _settings(
    thinnest: float, ladders: Ladders, *, only_solid: bool
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Name, ladder and `[model]` settings of every case."""
    truth = "solid" if only_solid else "harmonic"
    yield "reference", "reference", {"level": truth, "accuracy": ladders.reference[truth]}
    for level, accuracies in ladders.adaptive.items():
        if level == "solid" or not only_solid:
            for accuracy in accuracies:
                settings = {"level": level, "accuracy": accuracy}
                yield f"{level}, accuracy {accuracy:g}", "adaptive", settings
    if not only_solid:
        yield "beam", "beam", {"level": "beam"}
        yield from _harmonic(thinnest, ladders)
    fixed = {"level": "solid", "accuracy": _FIXED_ACCURACY, "modes": ladders.ladder_modes}
    for rung in ladders.solid:
        sizes = graded_sizes(thinnest, 2, rung)
        yield f"solid, order 2, graded, rung {rung}", "graded", {**fixed, "order": 2, **sizes}


def _harmonic(thinnest: float, ladders: Ladders) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Mesh ladders of the harmonic level, and that of modes."""
    fixed = {"level": "harmonic", "accuracy": _FIXED_ACCURACY, "modes": ladders.ladder_modes}
    for order, rungs in ladders.graded.items():
        for rung in rungs:
            name = f"harmonic, order {order}, graded, rung {rung}"
            sizes = graded_sizes(thinnest, order, rung)
            yield name, "graded", {**fixed, "order": order, **sizes}
    for order, rungs in ladders.uniform.items():
        for rung in rungs:
            size = _UNIFORM * thinnest * 0.5**rung
            name = f"harmonic, order {order}, uniform, rung {rung}"
            sizes = {"size_m": size, "corner_size_m": size, "growth": 1.0}
            yield name, "uniform", {**fixed, "order": order, **sizes}
    for modes in ladders.modes:
        sizes = {"order": 4, **graded_sizes(thinnest, 4, 2)}
        yield f"harmonic, order 4, {modes} modes", "modes", {**fixed, **sizes, "modes": modes}
