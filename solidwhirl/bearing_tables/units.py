"""Units that makers' tables are in, and their factors to SI."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from types import MappingProxyType

# NIST SP 811: one pound-force and one inch, exact.
_LB_N, _IN_M = 4.4482216152605, 0.0254
_LB_PER_IN = _LB_N / _IN_M
_RPM = math.pi / 30.0
_STIFFNESS = {
    "N/m": 1.0,
    "N/mm": 1e3,
    "N/um": 1e6,
    "kN/m": 1e3,
    "kN/mm": 1e6,
    "MN/m": 1e6,
    "lb/in": _LB_PER_IN,
}
_DAMPING = {
    f"{force}-s/{length}": factor
    for (force, length), factor in ((key.split("/"), value) for key, value in _STIFFNESS.items())
}
_TURNS = {"rpm": _RPM, "r/min": _RPM, "1/min": _RPM, "rad/s": 1.0, "Hz": 2.0 * math.pi}
#: Units of a quantity by the spelling that `canonical` gives, and SI values of one of them.
UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "stiffness": _STIFFNESS,
        "damping": _DAMPING,
        "mass": {"kg": 1.0, "N-s2/m": 1.0, "lb-s2/in": _LB_PER_IN},
        "speed": _TURNS,
        "frequency": _TURNS,
        "load": {"N": 1.0, "kN": 1e3, "MN": 1e6, "lb": _LB_N},
    }
)
# Endings of a column's name, as in `kxx_n_per_m`; mega is the only meaning of "mn" there.
_SUFFIXES = {
    unit.lower().replace("-", "_").replace("/", "_per_"): unit
    for units in UNITS.values()
    for unit in units
}


def factor_of(quantity: str, unit: str) -> float | None:
    """Return what one of a unit is in SI, None of a unit that the quantity does not have.

    `quantity`: a key of `UNITS`; `unit`: as in a header, such as "[lbf·s/in]" or "N/mm", or as the
    end of a key, such as "n_s_per_m". Upper and lower case matter where they change the meaning: m
    is milli and M is mega, but mega in keys, which have no upper case.
    """
    known = UNITS[quantity]
    as_key = _SUFFIXES.get(unit.lower().replace("lbf", "lb"), "") if "/" not in unit else ""
    spelt = canonical(unit)
    if quantity == "damping":
        spelt = re.sub(r"^([kM]?)Ns/", r"\1N-s/", spelt)
    for spelling in (spelt, as_key):
        if spelling in known:
            return known[spelling]
    if spelt[:2].lower() == "mn":
        return None
    folded = [key for key in known if key.lower() == spelt.lower()]
    return known[folded[0]] if folded else None


def canonical(unit: str) -> str:
    """Return a unit as the tables here spell it: "lbf * sec^2 / inch" becomes "lb-s2/in"."""
    text = unit.strip(" []().").replace("µ", "u").replace("μ", "u").replace("²", "2")
    text = re.sub(r"\s*/\s*", "/", text)
    text = re.sub(r"\*\*2|\^2", "2", text)
    text = re.sub(r"\s*[·⋅*.-]\s*|\s+", "-", text)
    text = re.sub(r"\b(lbf|lbs)\b", "lb", text, flags=re.IGNORECASE)
    text = re.sub(r"\bsec(?=\b|2)", "s", text, flags=re.IGNORECASE)
    return re.sub(r"\b(inches|inch)\b", "in", text, flags=re.IGNORECASE)
