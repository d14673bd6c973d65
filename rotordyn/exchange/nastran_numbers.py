"""Real numbers in the fields of Nastran's bulk data."""

from __future__ import annotations

import re

_REAL = re.compile(r"([+-]?)(\d*\.?\d*)(?:[eEdD]?([+-]?\d{1,3}))?")
_TOO_SMALL = 1e-99


def real_field(value: float, width: int = 16) -> str:
    """Write a number with as many digits as a field has room for.

    Parameters
    ----------
    value
        Finite, below 1e99 in magnitude.
    width
        Columns of the field.

    Returns
    -------
    str
        `width` characters. With 16 columns: 12 digits or more between 1e-10 and 1e20, 11 or more
        elsewhere; numbers below 1e-99 are written as zero. The point is where it saves the sign of
        an exponent (Nastran's real numbers may have it anywhere, and an exponent without E).
    """
    if value == 0.0 or abs(value) < _TOO_SMALL:
        return "0.0".rjust(width)
    best, error = "", float("inf")
    for text in _candidates(value, width):
        wrong = abs(parsed_real(text) - value)
        if wrong < error:
            best, error = text, wrong
    return best.rjust(width)


def _candidates(value: float, width: int) -> list[str]:
    sign = "-" if value < 0 else ""
    room = width - len(sign) - 1  # without the point
    found = []
    for exponent in ("", "+9", "-9", "+00"):
        digits = min(room - len(exponent), 17)
        mantissa, power = f"{abs(value):.{digits - 1}E}".split("E")
        figures, order = mantissa.replace(".", ""), int(power)  # d.ddd times 10^order
        if not exponent:
            if 0 <= order < digits:
                found.append(f"{sign}{figures[: order + 1]}.{figures[order + 1 :]}")
            elif order == -1:
                found.append(f"{sign}.{figures}")
            continue
        if exponent == "+00":
            shown = f"{order:+03d}"
            found.append(f"{sign}{figures[0]}.{figures[1:]}{shown}")
            continue
        # one digit of exponent: the point moves into the figures
        left = min(max(order + 1 - (9 if exponent == "+9" else -9), 0), digits)
        shift = order + 1 - left
        if -9 <= shift <= 9 and shift:
            found.append(f"{sign}{figures[:left]}.{figures[left:]}{shift:+d}")
    return [text for text in found if len(text) <= width]


def parsed_real(text: str) -> float:
    """Read a real number of bulk data: "1.5", "-.2+3", "4.D-2", "12.E4".

    Parameters
    ----------
    text
        Of one field.

    Raises
    ------
    ValueError
        It is none; whole numbers without a point are none.
    """
    found = text.strip()
    match = _REAL.fullmatch(found)
    if match is None or "." not in match[2] or match[2] == ".":
        raise ValueError(f"{found[:40]!r} is no real number")
    return float(f"{match[1]}{match[2]}E{int(match[3] or 0)}")
