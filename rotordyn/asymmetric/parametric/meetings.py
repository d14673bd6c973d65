"""Which modes drive each other where a motion begins to grow."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.asymmetric.parametric.hill_roots import Root
from solidwhirl.rotordyn.core.arrays import FloatArray

# Part of what grows from which a mode is one of those that drive each other.
_PART = 0.01

Relation = Literal["main", "sum", "difference", "alone"]


class Meeting(NamedTuple):
    """The modes that meet where a range opens, or where it closes if it does not open.

    `first_rad_s`, `second_rad_s`: their frequencies there in the frame of the body, first ≥ second
    ≥ 0. With `order` m strides of the speed: "main": twice the one frequency is m strides (m = 0:
    it stands still, a divergence); "sum", "difference": of both; "alone": a mode that no other
    drives.
    """

    relation: Relation
    order: int
    first_rad_s: float
    second_rad_s: float


def beyond_strides(rate: float, beat: float) -> float:
    """Return what is left of a rate beside the nearest whole number of strides, signed."""
    return rate - beat * round(rate / beat) if beat else rate


def with_itself(root: Root, beat: float) -> Meeting:
    """Return the meeting of a mode with its conjugate; `beat`: a stride of the speed, rad/s.

    All harmonics of what grows tell on the whole how fast the mode is.
    """
    if not beat:
        return Meeting("main", 0, 0.0, 0.0)
    most = len(root.right) // 2
    rates = root.value.imag + beat * np.arange(-most, most + 1)
    energy = (np.abs(root.right) ** 2).sum(axis=1)
    fast = float(np.sqrt(energy @ rates**2 / energy.sum()))
    odd = round(2.0 * root.value.imag / beat) % 2
    order = 2 * round(fast / beat - 0.5 * odd) + odd
    return Meeting("main", order, 0.5 * order * beat, 0.5 * order * beat)


def of_modes(rate: float, beside: FloatArray, parts: FloatArray, beat: float) -> Meeting:
    """Return the meeting of the two modes that are the most of what grows.

    `rate`: Im λ where they meet; `beside`, `parts`: Im λ of all modes beside it and their parts of
    what grows, each (m,); `beat`: a stride of the speed; rad/s.
    """
    first, second = np.argsort(-parts)[:2]
    rates = [
        float(beside[k]) - beyond_strides(float(beside[k]) - rate, beat) if beat else rate
        for k in (first, second)
    ]
    slow, fast = sorted(abs(r) for r in rates)
    if parts[second] < _PART:
        return Meeting("alone", 0, abs(rates[0]), abs(rates[0]))
    relation: Relation = "sum" if rates[0] * rates[1] < 0 else "difference"
    both = fast + slow if relation == "sum" else fast - slow
    return Meeting(relation, round(both / beat) if beat else 0, fast, slow)
