"""The values of a sweep's cases: grid, list, Latin hypercube, Sobol's points."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping

import numpy as np
from scipy.special import ndtr, ndtri

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.sweep import SAMPLED, SweepParameterSpec, SweepSpec
from solidwhirl.sweep.records import Value

# Digits of values that are computed: the same on every machine, whatever its last bits are.
_DIGITS = 12
# Half the spacing of Sobol's points: a sample at 0 or 1 would be infinitely far out in a tail.
_HALF_SPACING = 2.0**-31


def sweep_values(sweep: SweepSpec) -> tuple[Mapping[str, Value], ...]:
    """Return the values of all cases by name of parameter, in the order of the cases.

    `sweep`: without problems (`solidwhirl.scene.sweep.sweep_problems`).
    Of a grid the last parameter changes fastest. Samples are the same for the same seed,
    and those of Sobol's points are the first ones of a sweep with more samples. Computed values are
    rounded to 12 digits.
    """
    names = [p.name for p in sweep.parameters]
    rows: Iterable[tuple[Value, ...]]
    if sweep.method in SAMPLED:
        unit = unit_samples(sweep)
        columns = [quantiles(p, column) for p, column in zip(sweep.parameters, unit.T, strict=True)]
        rows = zip(*columns, strict=True)
    elif sweep.method == "grid":
        rows = itertools.product(*(_grid_values(p) for p in sweep.parameters))
    else:
        rows = zip(*(p.values or () for p in sweep.parameters), strict=True)
    return tuple(dict(zip(names, row, strict=True)) for row in rows)


def unit_samples(sweep: SweepSpec) -> FloatArray:
    """Return samples × parameters in the unit cube.

    Latin hypercube: McKay, Beckman, Conover, Technometrics 21 (1979) 239. Sobol: directions of Joe
    and Kuo, SIAM J. Sci. Comput. 30 (2008) 2635, scrambled (scipy.stats.qmc).

    `sweep`: of a sampled method; the seed is 0 where none is given.
    """
    from scipy.stats import qmc  # takes a fifth of a second

    kind = qmc.LatinHypercube if sweep.method == "latin_hypercube" else qmc.Sobol
    # a number, not a generator, of which scipy 1.15 and later draw another one
    points: FloatArray = kind(d=len(sweep.parameters), seed=sweep.seed or 0).random(sweep.samples)
    return points


def quantiles(parameter: SweepParameterSpec, probability: FloatArray) -> tuple[Value, ...]:
    """Return the values of a parameter at which its distribution function has these values.

    `parameter`: with a distribution, or with values that are equally likely. `probability`: from 0
    to 1 (n); 0 and 1 themselves are moved inwards by 2^-31.
    """
    inside = np.clip(probability, _HALF_SPACING, 1.0 - _HALF_SPACING)
    if parameter.values is not None:
        places = np.floor(inside * len(parameter.values)).astype(int)
        return tuple(parameter.values[k] for k in places)
    if parameter.distribution in ("normal", "lognormal"):
        return _rounded(_tailed(parameter, inside))
    lower, upper = parameter.lower, parameter.upper
    assert lower is not None and upper is not None
    if parameter.distribution == "uniform":
        return _rounded((1.0 - inside) * lower + inside * upper)
    return _rounded(np.exp((1.0 - inside) * np.log(lower) + inside * np.log(upper)))


def _tailed(parameter: SweepParameterSpec, probability: FloatArray) -> FloatArray:
    """Normal or lognormal, of what lies within the bounds."""
    mean, deviation = parameter.mean, parameter.standard_deviation
    assert mean is not None and deviation is not None
    lower, upper = parameter.lower, parameter.upper
    logarithmic = parameter.distribution == "lognormal"
    if logarithmic:
        # mean and deviation are those of the value, not of its logarithm
        square = np.log1p((deviation / mean) ** 2)
        mean, deviation = np.log(mean) - 0.5 * square, np.sqrt(square)
        # a bound at or below 0 cuts off nothing
        lower = np.log(lower) if lower is not None and lower > 0.0 else None
        upper = np.log(upper) if upper is not None else None
    below = 0.0 if lower is None else float(ndtr((lower - mean) / deviation))
    above = 1.0 if upper is None else float(ndtr((upper - mean) / deviation))
    found: FloatArray = mean + deviation * ndtri(below + probability * (above - below))
    return np.exp(found) if logarithmic else found


def _grid_values(parameter: SweepParameterSpec) -> tuple[Value, ...]:
    if parameter.values is not None:
        return parameter.values
    lower, upper, count = parameter.lower, parameter.upper, parameter.count
    assert lower is not None and upper is not None and count is not None
    spaced = np.geomspace if parameter.spacing == "logarithmic" else np.linspace
    return _rounded(spaced(lower, upper, count))


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(f"{value:.{_DIGITS}g}") for value in values)
