"""Cards of Nastran bulk data, with the file and line they came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.exchange.foreign_body import file_text
from solidwhirl.rotordyn.exchange.nastran_numbers import parsed_real

_DEEPEST = 4
_MOST_FILES = 50
_LARGEST_WHOLE = 10**9


@dataclass(frozen=True, kw_only=True, slots=True)
class Card:
    """One entry of bulk data.

    Attributes
    ----------
    path, line
        Where it begins.
    name
        First field, without the star of the large format.
    fields
        The others, continuations joined; blank ones are empty texts.
    """

    path: Path
    line: int
    name: str
    fields: tuple[str, ...]

    def error(self, said: str) -> SuperelementError:
        """Return an error at this entry."""
        return SuperelementError(f"{self.path}, line {self.line}: {self.name}: {said}")

    def text(self, at: int) -> str:
        """Field at a place, from 0; empty beyond the last."""
        return self.fields[at] if at < len(self.fields) else ""

    def whole(self, at: int, least: int = 0, default: int | None = None) -> int:
        """A whole number."""
        found = self.text(at)
        if not found and default is not None:
            return default
        if not (found.isascii() and found.isdigit()) or not least <= int(found) <= _LARGEST_WHOLE:
            raise self.error(
                f"field {at + 2} is {found[:20]!r}; whole numbers from {least} are allowed"
            )
        return int(found)

    def real(self, at: int, default: float | None = None) -> float:
        """A real number."""
        found = self.text(at)
        if not found and default is not None:
            return default
        try:
            return parsed_real(found)
        except (ValueError, OverflowError) as error:
            raise self.error(f"field {at + 2}: {error}") from error


def read_cards(path: Path, files: list[Path]) -> Iterator[Card]:
    """Read the entries of a file and of those that it includes, in their order.

    Parameters
    ----------
    path
        The file; executive and case control before BEGIN BULK are left out.
    files
        Filled with the files that were read.

    Raises
    ------
    SuperelementError
        A file that can't be read, includes that never end, a line that is no entry.
    """
    yield from _cards(path, files, 0)


def _cards(path: Path, files: list[Path], depth: int) -> Iterator[Card]:
    if depth > _DEEPEST or len(files) >= _MOST_FILES:
        raise SuperelementError(f"{path}: is included {depth} deep, or is one file too many")
    lines = file_text(path).splitlines()
    files.append(path)
    at = _bulk_begin(lines)
    open_card: tuple[int, str, list[str]] | None = None
    for number in range(at, len(lines)):
        line = lines[number].split("$", 1)[0].rstrip()
        if not line:
            continue
        if line[0] in " +*":
            if open_card is None:
                raise SuperelementError(f"{path}, line {number + 1}: continues nothing")
            open_card[2].extend(_fields(path, number, line))
            continue
        if open_card is not None:
            yield _card(path, open_card)
        open_card = None
        head = line.upper()
        if head.startswith("ENDDATA"):
            return
        if head.startswith("INCLUDE"):
            name = line[7:].strip().strip("'\"")
            yield from _cards(_included(path, number, name, files[0].parent), files, depth + 1)
            continue
        name = head.replace(",", " ").split()[0][:8]
        open_card = (number, name, _fields(path, number, line))
    if open_card is not None:
        yield _card(path, open_card)


def _included(path: Path, number: int, name: str, folder: Path) -> Path:
    """The file of an INCLUDE: a file of others' must not name what lies outside its folder."""
    found = path.parent / name
    if "\0" in name or not found.resolve().is_relative_to(folder.resolve()):
        raise SuperelementError(
            f"{path}, line {number + 1}: INCLUDE names {name[:80]!r}, which lies outside the "
            "folder of the file; files beside it and below are allowed"
        )
    if found.exists() and not found.is_file():
        raise SuperelementError(
            f"{path}, line {number + 1}: INCLUDE names {name[:80]!r}, which is no regular file"
        )
    return found


def _card(path: Path, found: tuple[int, str, list[str]]) -> Card:
    number, name, fields = found
    return Card(path=path, line=number + 1, name=name.rstrip("*"), fields=tuple(fields))


def _bulk_begin(lines: list[str]) -> int:
    for number, line in enumerate(lines):
        if line.upper().split()[:2] == ["BEGIN", "BULK"]:
            return number + 1
    return 0


def _fields(path: Path, number: int, line: str) -> list[str]:
    """Fields of one line behind the first: 8 of 8 columns, 4 of 16, or separated by commas."""
    wide = "*" in line[:8]
    width, count = (16, 4) if wide else (8, 8)
    if "," in line:
        texts = [text.strip() for text in line.split(",")[1 : count + 1]]
        return texts + [""] * (count - len(texts))
    if "\t" in line:
        raise SuperelementError(f"{path}, line {number + 1}: has a tabulator; use blanks")
    rest = line[8:].ljust(width * count)
    return [rest[width * k : width * (k + 1)].strip() for k in range(count)]
