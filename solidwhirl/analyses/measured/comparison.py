"""Measured functions and modes as results tell them, beside the computed ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.analyses.measured.records import Measured, MeasuredFunction, MeasuredMode
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.modal_test.assurance import (
    Pair,
    assurance,
    pairs_by_frequency,
    pairs_by_shape,
)
from solidwhirl.rotordyn.modal_test.families import ModeFamilies
from solidwhirl.rotordyn.modal_test.functions import ORDERS

# Modes whose motion at the sensors is below this part of the largest are not seen.
_UNSEEN = 1e-6


def compared(
    measured: Measured,
    families: ModeFamilies,
    motions: Sequence[FloatArray | ComplexArray],
    sensors: Sequence[str],
    quantity: str,
) -> dict[str, Any]:
    """Return measured functions as a quantity, and measured modes with the computed ones.

    `motions`: of the sensors in the modes of each family that is compared, (p, c).
    """
    hertz = families.family_hz[: len(motions)]
    mac = _mac(measured.modes, motions, sensors)
    pairs = _pairs(measured.modes, families, motions, mac)
    return {
        "notes": list(measured.notes),
        "functions": [_function(function, quantity) for function in measured.functions],
        "modes": [
            _mode(mode, pair, hertz, mac) for mode, pair in zip(measured.modes, pairs, strict=True)
        ],
        "mac": None if mac is None else mac.tolist(),
    }


def _mac(
    modes: Sequence[MeasuredMode],
    motions: Sequence[FloatArray | ComplexArray],
    sensors: Sequence[str],
) -> FloatArray | None:
    """Return the MAC of measured modes and families, nan of modes without shape; None of none."""
    if not motions or not any(mode.shape for mode in modes):
        return None
    found = np.full((len(modes), len(motions)), np.nan)
    for k, mode in enumerate(modes):
        if mode.shape:
            at = [sensors.index(name) for name in mode.shape]
            shape = np.array(list(mode.shape.values()))[:, None]
            if np.any(shape):
                found[k] = assurance(shape, [motion[at] for motion in motions])[0]
    return found


def _pairs(
    modes: Sequence[MeasuredMode],
    families: ModeFamilies,
    motions: Sequence[FloatArray | ComplexArray],
    mac: FloatArray | None,
) -> list[Pair]:
    """Pair by shapes where all modes have them, else by frequency what the sensors see."""
    own, hertz = np.array([mode.frequency_hz for mode in modes]), families.family_hz[: len(motions)]
    size = np.array([np.abs(motion).max() for motion in motions])
    seen = np.flatnonzero(size > _UNSEEN * size.max(initial=0.0))
    if not len(own) or not len(seen):
        return [Pair(k, None) for k in range(len(own))]
    if mac is None or np.isnan(mac).any():
        found = pairs_by_frequency(own, hertz[seen])
        return [Pair(k, None if at is None else int(seen[at])) for k, at in found]
    return pairs_by_shape(mac, own, hertz, families.sizes[: len(hertz)])


def _mode(
    mode: MeasuredMode, pair: Pair, hertz: FloatArray, mac: FloatArray | None
) -> dict[str, Any]:
    at = pair.computed
    paired = None if at is None else float(hertz[at])
    return {
        "frequency_hz": mode.frequency_hz,
        "uncertainty_hz": mode.uncertainty_hz,
        "damping_ratio": mode.damping_ratio,
        "computed": None if at is None else at + 1,
        "computed_hz": paired,
        "relative_difference": None if paired is None else paired / mode.frequency_hz - 1.0,
        "mac": None if at is None or mac is None else float(mac[pair.measured, at]),
    }


def _function(function: MeasuredFunction, quantity: str) -> dict[str, Any]:
    power = ORDERS[quantity] - ORDERS[function.quantity]
    values = function.values * (2j * np.pi * function.frequency_hz) ** power
    return {
        "hammer": function.hammer,
        "sensor": function.sensor,
        "measured_as": function.quantity,
        "frequency_hz": function.frequency_hz.tolist(),
        "real": values.real.tolist(),
        "imaginary": values.imag.tolist(),
    }
