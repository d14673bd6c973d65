"""Data as JSON holds it, and arrays with the names of their axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np


def plain_data(value: Any) -> Any:
    """Return lists, names and numbers for nested records; null for numbers that JSON has not."""
    if isinstance(value, float):  # most are
        return float(value) if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain_data(v) for key, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain_data(value.tolist())
    if isinstance(value, list | tuple):
        return [plain_data(v) for v in value]
    return value


#: Dimensions and values of one variable.
Labelled = tuple[Sequence[str] | str, Any]


class Labels(NamedTuple):
    """Arrays with their dimensions by name, the coordinates along these, and single values."""

    variables: Mapping[str, Labelled]
    coordinates: Mapping[str, Labelled] = MappingProxyType({})
    attributes: Mapping[str, Any] = MappingProxyType({})


def tabled(document: Mapping[str, Any], over: Mapping[str, Sequence[str]]) -> Labels:
    """Return arrays of a document with their dimensions; those it does not have are left out.

    Of a dimension that is a key of the document, that is the coordinate.
    """
    variables = {key: (dims, document[key]) for key, dims in over.items() if key in document}
    axes = {dim for dims in over.values() for dim in dims if dim in document}
    return Labels(variables, {dim: (dim, document[dim]) for dim in axes})
