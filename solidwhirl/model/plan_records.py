"""Records of the plan: effects, what is computed for each body, and the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from solidwhirl.model.resolution import Resolution
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene_checks.speeds_asked import SpeedAsked


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One effect."""

    #: As in the scene's [effects] table, or of what the scene can not ask for
    name: str
    on: bool
    why: str
    #: What it adds, in matrices assembled, factorisations and eigenproblems per body
    cost: str = ""


@dataclass(frozen=True, kw_only=True)
class BodyPlan:
    """What is computed for one body."""

    level: str
    #: Circumferential orders, or cyclic indices of a sector, that are solved one by one, or kept of
    #: the whole mesh of a solid; none in a body of any shape, whose modes have no order
    orders: tuple[int, ...]
    components: tuple[str, ...]
    #: Motions of each interface; each is one constraint mode
    interface_components: Mapping[str, tuple[str, ...]]
    maximum_speed_rad_s: float
    #: Mesh and element order to begin with; None on the beam level
    resolution: Resolution | None = None
    #: How many, at most, the reduction will need
    matrices: int = 0
    factorisations: int = 0
    eigenproblems: int = 0
    #: Of a solid, as `solidwhirl.reduction` tells them apart: "cyclic" is one of equal sectors, as
    #: of every profile, "round" and "any" are whole meshes
    shape: str = "cyclic"
    #: How systems of a whole mesh are solved: "direct", "iterative", or "auto": by the memory there
    #: is; those of sectors and meridians always directly
    solver: str = "direct"

    @property
    def solved_orders(self) -> tuple[int | None, ...]:
        """Orders or indices that are solved one by one; None is the whole mesh of a solid."""
        whole = self.level == "solid" and self.shape != "cyclic"
        return (None,) if whole else self.orders


@dataclass(frozen=True, kw_only=True)
class Plan:
    """The plan of a run."""

    effects: tuple[Effect, ...]
    bodies: Mapping[str, BodyPlan]
    #: Motions of the interfaces of all bodies, by "body.interface"
    carried: Mapping[str, tuple[str, ...]]
    #: Name and kind of the analyses beyond modes, Campbell diagram and critical speeds
    analyses: tuple[tuple[str, str], ...]
    #: (s,) speeds of the reference shaft
    speeds_rad_s: FloatArray
    #: Analyses that look to speeds above those, for which the bodies have to be good too
    speeds_beyond: tuple[SpeedAsked, ...] = ()

    def on(self, name: str) -> bool:
        """Whether an effect is computed."""
        return next(e.on for e in self.effects if e.name == name)
