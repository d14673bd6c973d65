"""Array types of the stage, and the one way arrays are made read-only."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]
BoolArray = npt.NDArray[np.bool_]
StringArray = npt.NDArray[np.str_]


def freeze_arrays(record: Any, *names: str) -> None:
    """Replace the named arrays of a frozen dataclass by read-only copies.

    Parameters
    ----------
    record
        A frozen dataclass under construction.
    names
        Its array fields.
    """
    for name in names:
        array = np.array(getattr(record, name))
        array.setflags(write=False)
        object.__setattr__(record, name, array)
