"""What one picture of a run is, and the page that lists those in a folder, earlier ones too."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from solidwhirl.core.errors import markdown_text
from solidwhirl.rotordyn.core.atomic import replace_text

Draw = Callable[[Path], None]
#: Endings of still pictures, and of moving ones.
STILL_FORMATS, MOVING_FORMATS = ("pdf", "svg", "png"), ("gif", "mp4")
INDEX = "pictures.md"
_ENTRY = re.compile(r"- \*\*(?P<name>.+?)\*\* \((?P<files>\[.*?\]\(.*?\))\): (?P<caption>.*)")
_FILE = re.compile(r"\[[^\]]*\]\((?P<file>[^)]*)\)")
_FORMATS = STILL_FORMATS + MOVING_FORMATS


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """One picture of a run."""

    name: str  # of its file, without the ending
    # "plot": drawn as lines and text; "still": a view of the bodies in space, an image with lines
    # and text around it; "film": moving
    kind: Literal["plot", "still", "film"]
    caption: str  # what is to be seen, a sentence or two
    draw: Draw  # writes the file that it is given; the ending chooses the format

    @property
    def formats(self) -> tuple[str, ...]:
        """Endings that it can be written with."""
        return MOVING_FORMATS if self.kind == "film" else STILL_FORMATS


def write_index(
    index: Path, title: str, pictures: Sequence[Picture], drawn: Mapping[str, Sequence[Path]]
) -> None:
    """Write the list of pictures, with those that it had before and whose files are still there.

    `index`: the page, in the folder of the pictures. `pictures`: all that the run has something
    for; they give captions and order. `drawn`: files by name of the picture, drawn now.
    """
    folder = index.parent
    captions, files = _listed(index)
    for name, own in drawn.items():
        added = [path.relative_to(folder).as_posix() for path in own]
        files[name] = list(dict.fromkeys([*files.get(name, ()), *added]))
    captions |= {picture.name: picture.caption for picture in pictures}
    known = [picture.name for picture in pictures]
    names = [*(n for n in known if n in files), *(n for n in files if n not in known)]
    lines = [f"# Pictures of {markdown_text(title)}", ""]
    for name in names:
        ordered = sorted(files[name], key=_rank)
        links = ", ".join(f"[{file}]({file})" for file in ordered)
        lines += [f"- **{name}** ({links}): {captions[name]}"]
    replace_text(index, "\n".join(lines) + "\n")


def pictures_listed(folder: Path) -> frozenset[str]:
    """Return the names of the pictures that a folder's page lists."""
    return frozenset(file for files in _listed(folder / INDEX)[1].values() for file in files)


def _listed(index: Path) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Captions and files of a page by name; nothing where there is none."""
    captions: dict[str, str] = {}
    files: dict[str, list[str]] = {}
    if not index.is_file():
        return captions, files
    for line in index.read_text(encoding="utf-8", errors="replace").splitlines():
        entry = _ENTRY.fullmatch(line)
        if entry is None:
            continue
        linked = [found["file"] for found in _FILE.finditer(entry["files"])]
        there = [file for file in linked if (index.parent / file).is_file()]
        if there:
            captions[entry["name"]], files[entry["name"]] = entry["caption"], there
    return captions, files


def _rank(file: str) -> int:
    ending = Path(file).suffix.lstrip(".")
    return _FORMATS.index(ending) if ending in _FORMATS else len(_FORMATS)
