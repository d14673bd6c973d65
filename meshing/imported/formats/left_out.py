"""What of a file is not taken: refused where it carries stiffness or mass, else told once."""

from __future__ import annotations

from dataclasses import dataclass, field

from solidwhirl.meshing.errors import MeshingError

#: What to do about things that join, hold or load, by kind.
SPRINGS = (
    "take them out of the file and give the scene [[bearings]] between interfaces or to the ground"
)
BEAMS = (
    "mesh the part with solid elements, or take them out and make it a body of the scene, "
    "[beams.<name>], joined by [[bearings]]"
)
SHELLS = (
    "mesh the part with solid elements; shells that are to name surfaces alone need no section "
    "or property"
)
LINKS = (
    "merge the nodes in the mesher; what is to be loaded goes through a reference node with a "
    "rigid or distributing coupling (RBE2, RBE3; *COUPLING), which becomes an interface"
)
MASSES = (
    "give the mass as point masses on nodes, or as rigid_disks of the scene, or as density of a "
    "material"
)
_MOST_NAMED = 12


@dataclass(kw_only=True)
class LeftOut:
    """Names of cards or keywords, how often they came, and the line of the first."""

    #: Name to what to do about it, count and line
    refused: dict[str, tuple[str, int, str]] = field(default_factory=dict)
    told: dict[str, tuple[str, int, str]] = field(default_factory=dict)

    def refuse(self, name: str, line: str, what_to_do: str, count: int = 1) -> None:
        """Note what carries stiffness or mass. `line`: "line 7"."""
        _note(self.refused, name, line, what_to_do, count)

    def tell(self, name: str, line: str, said: str, count: int = 1) -> None:
        """Note what is not taken and need not matter."""
        _note(self.told, name, line, said, count)

    def remarks(self) -> tuple[str, ...]:
        """Return a sentence for each of what is to be told.

        Raises MeshingError: something is refused; all of it is named.
        """
        if self.refused:
            by_remedy: dict[str, list[str]] = {}
            for name, (what_to_do, count, line) in self.refused.items():
                by_remedy.setdefault(what_to_do, []).append(
                    f"{name} ({count}, the first in {line})"
                )
            raise MeshingError(
                "; ".join(
                    f"found {_few(names)}, whose stiffness or mass is not taken: {what_to_do}"
                    for what_to_do, names in by_remedy.items()
                )
            )
        return tuple(
            f"{name} ({count}, the first in {line}) {said}"
            for name, (said, count, line) in self.told.items()
        )


def _few(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more kinds" if more > 0 else "")


def _note(
    where: dict[str, tuple[str, int, str]], name: str, line: str, said: str, count: int
) -> None:
    known, before, first = where.get(name, (said, 0, line))
    where[name] = (known, before + count, first)
