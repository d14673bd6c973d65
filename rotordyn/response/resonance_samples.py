"""Where a response has to be sampled so that its resonances show, however sharp they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import NoSteadyResponseError

# Samples in which resonances are sought at least, and in one window; windows overlap by half.
_LEAST, _WINDOW = 257, 64
# Degree of a rational function, and its largest error over the largest value.
_DEGREE, _FITTED = 24, 1e-11
# A resonance counts that adds so much to the response, and is sharper than so many samples.
_COUNTS, _SHARP = 1e-3, 8.0
# Half-widths over the frequency: below the first there is no damping, and no height to resolve;
# what is sampled then has the second, so that the place shows.
_UNDAMPED, _SHOWN = 1e-7, 1e-4
_ROUNDS = 3
# Samples around a resonance, in half-widths: dense where it is highest and at half power.
_OFFSETS = np.array([0.05, 0.2, 0.45, 0.7, 0.9, 1.1, 1.4, 2.0, 3.2, 6.0, 14.0, 40.0])
# Samples between two knots at least, and beside a knot with a peak in parts of the next step.
_BETWEEN_KNOTS = 33
_BESIDE_KNOT = np.array([1e-4, 1e-3, 1e-2, 0.1])
# Samples beside a place where a resonance may be, over the frequency.
_BESIDE_PLACE = np.logspace(-6.0, -1.5, 10)
# A knot nearer to a sample than this (relative) is that sample.
_SAME = 1e-12


class Resonances(NamedTuple):
    """Places of resonances and half their widths at half power, shape (k,)."""

    places: FloatArray
    half_widths: FloatArray


class Pieces(NamedTuple):
    """Where a response is no longer the same rational function, and where it may resonate.

    `knots`: frequencies between which it is smooth, shape (k,); `places`: where resonances may be,
    shape (r,), of any damping.
    """

    knots: FloatArray
    places: FloatArray


SMOOTH = Pieces(np.empty(0), np.empty(0))


def resolving_samples(
    samples: npt.ArrayLike,
    respond: Callable[[FloatArray], ComplexArray],
    pieces: Pieces = SMOOTH,
) -> FloatArray:
    """Return samples with further ones around every resonance between them.

    `samples`: speeds or frequencies, 0 or more, rising, shape (s,). `respond`: complex amplitudes
    at some of these, shape (p,) → (p, c); it is not asked at 0. `pieces`: knots of what the
    response depends on, and hints; knots between the samples are returned among them. Returns the
    samples and further ones between them, rising.

    Between knots the response is a rational function of the frequency. The samples approximate it
    as one (the AAA algorithm: Nakatsukasa, Sète and Trefethen, SIAM J. Sci. Comput. 40 (2018)
    A1494-A1522; its form for several functions with common poles: Lietaert et al., IMA J. Numer.
    Anal. 42 (2022) 1087-1115); poles near the axis are the resonances, also those that lie between
    two samples. Samples around them make the approximation better, until the poles stand.
    """
    given = np.asarray(samples, dtype=float)
    if given.size < 2:
        return given
    given = with_knots(given, pieces.knots)
    known = _dense(given, pieces)
    known, values = answered(respond, known[known > 0.0])
    more, _, _ = _resolved(given, known, values, respond, pieces)
    return with_knots(given, more)


def with_knots(samples: npt.ArrayLike, knots: npt.ArrayLike) -> FloatArray:
    """Return samples with the knots between them, rising.

    `samples`: rising, shape (s,). `knots`: in any order; those at a sample or at another knot, and
    beyond them all, are left out.
    """
    given = np.asarray(samples, dtype=float)
    wanted = np.unique(np.asarray(knots, dtype=float))
    wanted = wanted[(wanted > given[0]) & (wanted < given[-1])] if given.size else wanted[:0]
    # two that differ by rounding are one frequency, or one again times a speed ratio
    wanted = wanted[np.diff(wanted, prepend=0.0) > _SAME * wanted]
    after = np.searchsorted(given, wanted)
    gap = np.minimum(given[after] - wanted, wanted - given[after - 1])
    return np.union1d(given, wanted[gap > _SAME * wanted])


def resolved_response(
    samples: npt.ArrayLike,
    values: npt.ArrayLike,
    respond: Callable[[FloatArray], ComplexArray],
    pieces: Pieces = SMOOTH,
) -> tuple[FloatArray, ComplexArray]:
    """Return a sampled response with all that resolves its resonances.

    `samples`, `respond`, `pieces`: as for `resolving_samples`; `values`: the response at the
    samples, shape (s, c). Returns the given ones and further ones between them, rising.
    """
    given, shown = np.asarray(samples, dtype=float), np.asarray(values, dtype=complex)
    if given.size < 2:
        return given, shown
    between = np.setdiff1d(_dense(with_knots(given, pieces.knots), pieces), given)
    known, found = given, shown
    if between.size:
        known, found = joined_samples(given, shown, *answered(respond, between))
    moving = known > 0.0
    _, more, further = _resolved(given, known[moving], found[moving], respond, pieces)
    return joined_samples(given, shown, more, further)


def joined_samples(
    samples: FloatArray, values: ComplexArray, more: FloatArray, further: ComplexArray
) -> tuple[FloatArray, ComplexArray]:
    """Return two sampled pieces of a response as one, rising; the first where both have a sample.

    `samples`, `more`: shapes (s,) and (p,); `values`, `further`: the response there, shapes (s, c)
    and (p, c).
    """
    both, first = np.unique(np.concatenate((samples, more)), return_index=True)
    return both, np.concatenate((values, further))[first]


def computable_samples(
    samples: FloatArray, respond: Callable[[FloatArray], ComplexArray]
) -> FloatArray:
    """Return samples, with those around a resonance too sharp for its height farther away from it.

    `samples`: rising, shape (s,), all above 0; `respond`: as for `resolving_samples`. Raises
    NoSteadyResponseError if there is a response at none of them.
    """
    if not samples.size:
        return samples
    kept, _ = answered(respond, samples)
    lost = np.setdiff1d(samples, kept)
    near = (np.abs(kept[:, None] - lost) <= _SHOWN * lost).any(axis=1)
    places = lost[np.diff(lost, prepend=-np.inf) > _SHOWN * lost]
    shown = _around(Resonances(places, np.zeros_like(places)), 0.0, np.inf)
    return np.union1d(kept[~near], shown)


def answered(
    respond: Callable[[FloatArray], ComplexArray], points: FloatArray
) -> tuple[FloatArray, ComplexArray]:
    """Return the points that have a steady response, shape (p,), and it, (p, c).

    Raises NoSteadyResponseError if none has.
    """
    try:
        return points, respond(points)
    except NoSteadyResponseError:
        halves = []
        for half in np.array_split(points, 2) if points.size > 1 else ():
            with suppress(NoSteadyResponseError):
                halves.append(answered(respond, half))
        if not halves:
            raise
    first, second = zip(*halves, strict=True)
    return np.concatenate(first), np.concatenate(second)


def _resolved(
    given: FloatArray,
    known: FloatArray,
    values: ComplexArray,
    respond: Callable[[FloatArray], ComplexArray],
    pieces: Pieces,
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Samples around sharp resonances between given ones, and all that they were found from."""
    beside = _beside_peaks(known, values, pieces.knots)
    around, samples, found = [beside], [known], [values]
    for inside in _segments(known, pieces.knots):
        sharp, more, further = _settled(given, known[inside], values[inside], respond)
        around.append(_around(sharp, more[0], more[-1]))
        samples.append(more)
        found.append(further)
    if beside.size:
        steady, motion = answered(respond, beside)
        samples.append(steady)
        found.append(motion)
    known, values = joined_samples(
        samples[0], found[0], np.concatenate(samples[1:]), np.concatenate(found[1:])
    )
    return np.unique(np.concatenate(around)), known, values


def _settled(
    given: FloatArray,
    known: FloatArray,
    values: ComplexArray,
    respond: Callable[[FloatArray], ComplexArray],
) -> tuple[Resonances, FloatArray, ComplexArray]:
    """Sharp resonances of one smooth piece, and the samples that they were found from."""
    found = Resonances(np.empty(0), np.empty(0))
    for _ in range(_ROUNDS):
        last, found = found, _sharp(resonances(known, values), given)
        if _is_same(last, found):
            break
        more = np.setdiff1d(_around(found, known[0], known[-1]), known)
        if not more.size:
            break
        known, values = joined_samples(known, values, *answered(respond, more))
    return found, known, values


def _segments(known: FloatArray, knots: FloatArray) -> Iterator[slice]:
    """Samples between neighbouring knots, with those at the knots."""
    inside = np.unique(knots[(knots > known[0]) & (knots < known[-1])])
    edges = [0, *np.searchsorted(known, inside * (1.0 - _SAME)).tolist(), known.size - 1]
    for first, last in pairwise(edges):
        if last > first:
            yield slice(first, last + 1)


def _beside_peaks(known: FloatArray, values: ComplexArray, knots: FloatArray) -> FloatArray:
    """Samples beside the knots at which the response has a peak: it may be a corner."""
    at = np.searchsorted(known, np.unique(knots) * (1.0 - _SAME))
    at = at[(at > 0) & (at < known.size - 1)]
    size = np.abs(values)
    at = at[((size[at] >= size[at - 1]) & (size[at] >= size[at + 1])).any(axis=1)]
    steps = [_BESIDE_KNOT * (known[at + side] - known[at])[:, None] for side in (-1, 1)]
    return np.asarray(np.unique(known[at][:, None] + np.hstack(steps)), dtype=float)


def samples_around_modes(samples: npt.ArrayLike, eigenvalues: npt.ArrayLike) -> FloatArray:
    """Return samples with further ones around the modes between them.

    `samples`: frequencies, 0 or more, rising, shape (s,), rad/s; `eigenvalues`: λ of a system whose
    matrices are those at all of the frequencies, shape (m,). Returns the samples and further ones
    between them, rising.
    """
    given, poles = np.asarray(samples, dtype=float), np.asarray(eigenvalues)
    if given.size < 2:
        return given
    places = np.abs(poles.imag)
    widths = _half_widths(poles.real, places)
    inside = (places > 0.0) & (places >= given[0]) & (places <= given[-1])
    found = _merged(places[inside], widths[inside])
    return with_knots(given, _around(_sharp(found, given), given[0], given[-1]))


def resonances(samples: npt.ArrayLike, values: npt.ArrayLike) -> Resonances:
    """Find the resonances of a sampled response.

    `samples`: rising, shape (s,); `values`: complex amplitudes of some quantities with the same
    resonances, shape (s, c). Returns within the samples, by rising place.
    """
    x, f = np.asarray(samples, dtype=float), _mixed(np.asarray(values, dtype=complex))
    found: list[complex] = []
    for begin in range(0, max(x.size - _WINDOW // 2, 1), _WINDOW // 2):
        window = slice(begin, begin + _WINDOW)
        poles = _poles(x[window], f[window])
        found.extend(poles[(poles.real >= x[window][0]) & (poles.real <= x[window][-1])])
    poles = np.array(found, dtype=complex)
    return _merged(poles.real, _half_widths(poles.imag, poles.real))


def _half_widths(damping: FloatArray, places: FloatArray) -> FloatArray:
    """Half-widths of poles, those without damping as wide as tells them apart from rounding."""
    return np.asarray(np.maximum(np.abs(damping), _UNDAMPED * np.abs(places)))


def _sharp(found: Resonances, samples: FloatArray) -> Resonances:
    """Those that are too sharp for the samples to show."""
    step = np.interp(found.places, samples[1:], np.diff(samples))
    use = found.half_widths < _SHARP * step
    return Resonances(found.places[use], found.half_widths[use])


def _dense(samples: FloatArray, pieces: Pieces) -> FloatArray:
    """The samples, and points between them where they are few or a resonance may be."""
    while 1 < samples.size < _LEAST:
        samples = np.union1d(samples, 0.5 * (samples[1:] + samples[:-1]))
    low, high = samples[0], samples[-1]
    beside = pieces.places[:, None] * (1.0 + np.concatenate((-_BESIDE_PLACE, _BESIDE_PLACE)))
    inside = beside[(beside > low) & (beside < high)]
    knots = np.unique(pieces.knots[(pieces.knots > low) & (pieces.knots < high)])
    more = [inside]
    for begin, end in pairwise((low, *knots, high) if knots.size else ()):
        if np.count_nonzero((samples >= begin) & (samples <= end)) < _BETWEEN_KNOTS:
            more.append(np.linspace(begin, end, _BETWEEN_KNOTS)[1:-1])
    return np.union1d(samples, np.concatenate(more))


def _mixed(values: ComplexArray) -> ComplexArray:
    """Two mixtures of many quantities: what resonates in any of them does in a mixture."""
    if values.shape[1] <= 2:
        return values
    weights = np.random.default_rng(1).standard_normal((2, values.shape[1], 2))
    return np.asarray(values @ (weights[0] + 1j * weights[1]))


def _poles(x: FloatArray, f: ComplexArray) -> ComplexArray:
    """Poles near the axis of a rational function through samples that matter for its size."""
    size = np.abs(f).max(axis=1)
    if x.size < 5 or not size.any():
        return np.empty(0, dtype=complex)
    chosen: list[int] = []
    rest = np.ones(x.size, dtype=bool)
    shown = np.broadcast_to(f.mean(axis=0), f.shape).copy()
    weights = np.empty(0, dtype=complex)
    for _ in range(min(_DEGREE, (x.size - 1) // 2)):
        error = np.where(rest, np.abs(f - shown).max(axis=1), 0.0)
        if error.max() <= _FITTED * size.max():
            break
        chosen.append(int(error.argmax()))
        rest[chosen[-1]] = False
        cauchy = 1.0 / (x[rest, None] - x[chosen])
        loewner = (f[rest].T[:, :, None] - f[chosen].T[:, None, :]) * cauchy
        weights = la.svd(loewner.reshape(-1, len(chosen)), full_matrices=False)[2][-1].conj()
        shown[rest] = (cauchy @ (weights[:, None] * f[chosen])) / (cauchy @ weights)[:, None]
        shown[chosen] = f[chosen]
    return _significant(x, size, x[chosen], f[chosen], weights)


def _significant(
    x: FloatArray,
    size: FloatArray,
    support: FloatArray,
    heights: ComplexArray,
    weights: ComplexArray,
) -> ComplexArray:
    """Poles of a function in barycentric form whose peaks stand out of what is sampled."""
    count = support.size
    if count < 2:
        return np.empty(0, dtype=complex)
    arrow = np.zeros((count + 1, count + 1), dtype=complex)
    arrow[0, 1:], arrow[1:, 0] = weights, 1.0
    arrow[1:, 1:] = np.diag(support)
    poles = la.eigvals(arrow, np.diag([0.0] + [1.0] * count))
    poles = poles[np.isfinite(poles)]
    # a pole at a sample is one of rounding, and drops out as nan
    with np.errstate(divide="ignore", invalid="ignore"):
        cauchy = 1.0 / (poles[:, None] - support)
        residue = (cauchy @ (weights[:, None] * heights)) / -(cauchy**2 @ weights)[:, None]
    peak = np.abs(residue).max(axis=1) / _half_widths(poles.imag, poles.real)
    level = np.interp(poles.real, x, size)
    return np.asarray(poles[peak > _COUNTS * level])


def _merged(places: FloatArray, widths: FloatArray) -> Resonances:
    """Resonances that two windows have found, once."""
    order = np.argsort(places)
    kept: list[int] = []
    for at in order:
        if kept and places[at] - places[kept[-1]] < 0.3 * min(widths[at], widths[kept[-1]]):
            continue
        kept.append(int(at))
    return Resonances(places[kept], widths[kept])


def _around(found: Resonances, low: float, high: float) -> FloatArray:
    """Samples around resonances, inside a range; none near one without damping."""
    undamped = found.half_widths <= _UNDAMPED * found.places
    widths = np.where(undamped, _SHOWN * found.places, found.half_widths)[:, None]
    offsets = np.where(undamped[:, None] & (_OFFSETS < 0.9), np.nan, _OFFSETS)
    points = np.hstack(
        (found.places[:, None] - widths * offsets, found.places[:, None] + widths * offsets)
    )
    inside = points[(points > max(low, 0.0)) & (points < high)]
    return np.asarray(np.unique(inside), dtype=float)


def _is_same(first: Resonances, second: Resonances) -> bool:
    """Whether places and widths stand, to a twentieth of the widths."""
    if first.places.size != second.places.size:
        return False
    limit = 0.05 * second.half_widths
    return bool(
        np.all(np.abs(first.places - second.places) <= limit)
        and np.all(np.abs(first.half_widths - second.half_widths) <= limit)
    )
