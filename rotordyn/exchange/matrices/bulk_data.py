"""Nastran bulk data: cards with the file and line they came from, and real numbers in fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import ForeignError, included
from solidwhirl.rotordyn.exchange.matrices.foreign_body import file_bytes

_LARGEST_WHOLE = 10**9
_REAL = re.compile(r"([+-]?)(\d*\.?\d*)(?:[eEdD]?([+-]?\d{1,3}))?")
_TOO_SMALL = 1e-99


@dataclass(frozen=True, kw_only=True, slots=True)
class Card:
    """One entry of bulk data.

    `path`, `line`: where it begins.
    `name`: first field, without the star of the large format.
    `fields`: the others, continuations joined; blank ones are empty texts.
    """

    path: Path
    line: int
    name: str
    fields: list[str]

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
    """Read the entries behind BEGIN BULK, those of included files too, which `files` then lists.

    Raises SuperelementError: a file that can't be read, includes that never end, a line that is no
    entry.
    """
    lines = file_bytes(path).decode("utf-8", errors="replace").splitlines()
    files.append(path)
    begins = (k + 1 for k, s in enumerate(lines) if s.upper().split()[:2] == ["BEGIN", "BULK"])
    card: Card | None = None
    for number in range(next(begins, 0), len(lines)):
        line = lines[number].split("$", 1)[0].expandtabs(8).rstrip()
        if not line:
            continue
        if line[0] in " +*,":
            if card is None:
                raise SuperelementError(f"{path}, line {number + 1}: continues nothing")
            card.fields.extend(_fields(line))
            continue
        if card is not None:
            yield card
        card, head = None, line.upper()
        if head.startswith("ENDDATA"):
            return
        if head.startswith("INCLUDE"):
            name = line[7:].strip().strip("'\"")
            try:
                other = included(path, name, files)
            except ForeignError as error:
                raise SuperelementError(f"{path}, line {number + 1}: {error}") from error
            yield from read_cards(other, files)
            continue
        name = head.replace(",", " ").split()[0][:8].rstrip("*")
        card = Card(path=path, line=number + 1, name=name, fields=_fields(line))
    if card is not None:
        yield card


def _fields(line: str) -> list[str]:
    """Fields of one line behind the first: 8 of 8 columns, 4 of 16, or separated by commas."""
    wide = "*" in line[:8]
    width, count = (16, 4) if wide else (8, 8)
    if "," in line:
        texts = [text.strip() for text in line.split(",")[1 : count + 1]]
        if texts and texts[-1] == "+":  # the mark of a continuation, which may come early
            texts.pop()
        return texts + [""] * (count - len(texts))
    rest = line[8:].ljust(width * count)
    return [rest[width * k : width * (k + 1)].strip() for k in range(count)]


def real_field(value: float, width: int = 16) -> str:
    """Write a number with as many digits as a field has room for.

    `value`: finite, below 1e99 in magnitude. Returns `width` characters. With 16 columns: 12 digits
    or more between 1e-10 and 1e20, 11 or more elsewhere; numbers below 1e-99 are written as zero.
    The point is where it saves the sign of an exponent (Nastran's real numbers may have it
    anywhere, and an exponent without E).
    """
    if value == 0.0 or abs(value) < _TOO_SMALL:
        return "0.0".rjust(width)
    exact, found = Decimal(value), list[str]()
    for power in (0, 9, -9, exact.adjusted()):
        mantissa, shown = exact.scaleb(-power), f"{power:+d}" if power else ""
        room = width - 1 - (value < 0) - max(mantissa.adjusted() + 1, 0) - len(shown)
        # one place less where rounding needs one more before the point
        for places in range(max(room - 1, 0), room + 1):
            text = re.sub(r"^(-?)0\.", r"\1.", f"{mantissa:.{places}f}")
            found.append(f"{text}{'' if places else '.'}{shown}")
    fits = (text for text in found if len(text) <= width)
    return min(fits, key=lambda text: abs(parsed_real(text) - value)).rjust(width)


def parsed_real(text: str) -> float:
    """Read a real number of bulk data, "1.5", "-.2+3", "4.D-2", "12.E4", or raise ValueError."""
    found = text.strip()
    match = _REAL.fullmatch(found)
    if match is None or "." not in match[2] or match[2] == ".":
        raise ValueError(f"{found[:40]!r} is no real number")
    return float(f"{match[1]}{match[2]}E{int(match[3] or 0)}")
