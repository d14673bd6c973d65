"""Analyses of a run as datasets, from what results.json holds of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl.analyses.registry import KINDS
from solidwhirl.core.plain_data import Labelled
from solidwhirl.datasets.parts import labelled

Document = Mapping[str, Any]

_PEAK_NUMBERS = ("speed_rpm", "frequency_hz", "amplitude_m", "amplification")
_PEAK_ERRORS = ("frequency_error_estimate", "amplitude_error_estimate")


def analysis_dataset(document: Document) -> xr.Dataset:
    """Return one analysis of a run as a dataset.

    Names are those of results.json; single numbers and texts are attributes. Kinds without arrays
    have attributes alone.
    """
    found = KINDS[document["kind"]].labels(document)
    return labelled(*found[:2], **_single(document) | dict(found.attributes))


def peaks_dataset(document: Document) -> xr.Dataset | None:
    """Return the resonance peaks of one analysis as a dataset; None where it has none.

    place, exciter, speed_rpm, frequency_hz, amplitude_m, amplification over peak, which counts
    from 1, and error estimates where there are such.
    """
    peaks = KINDS[document["kind"]].peaks(document)
    if peaks is None:
        return None
    rows = list(peaks)
    errors = [key for key in _PEAK_ERRORS if rows and all(key in row for row in rows)]
    variables: dict[str, Labelled] = {
        key: ("peak", np.array([row[key] for row in rows], dtype=str))
        for key in ("place", "exciter")
    }
    for key in (*_PEAK_NUMBERS, *errors):
        variables[key] = ("peak", np.array([row[key] for row in rows], dtype=float))
    return labelled(variables)


def record_dataset(record: Mapping[str, Any], document: Document) -> xr.Dataset:
    """Return the record over time that an analysis writes beside results.json."""
    found = KINDS[document["kind"]].record_labels(record, document)
    return labelled(*found[:2], **found.attributes)


def _single(document: Document) -> dict[str, Any]:
    """Numbers, texts, and lists of texts."""
    out: dict[str, Any] = {}
    for key, value in document.items():
        texts = isinstance(value, list) and all(isinstance(v, str) for v in value)
        if isinstance(value, str | int | float) or (texts and value):
            out[key] = value
    return out
