"""Force through a bearing during a run-up, normalised to the unbalance force that excites it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.run_up.force_spectrum import order_amplitude
from solidwhirl.rotordyn.run_up.record import RunUp

# Share of the record over which its two ends together fade in and out.
_FADE = 0.1
_AXES = ("x", "y")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class NormalisedResponse(ReadOnlyArrays):
    """Hold the size of a force per size of the excitation, over the frequency.

    `frequency_hz`: shape (f,). `ratio`: N/N, shape (f,); nan where the excitation has next to
    nothing. `excited_hz`: lowest and highest frequency at which there is excitation; the ratio is
    nan outside.
    """

    frequency_hz: FloatArray
    ratio: FloatArray
    excited_hz: tuple[float, float] = (0.0, np.inf)


def excitation_force_n(run: RunUp, time_s: npt.ArrayLike) -> ComplexArray:
    """Return the unbalance force of each body of a run-up over time.

    `time_s`: times within its profile, shape (s,); just at a breakpoint the acceleration after it.
    Returns F_x + i F_y, one row for each body with unbalance in the order in which they first
    appear, shape (bodies, s), N.
    """
    times = np.asarray(time_s, dtype=float)
    angle, speed = run.profile.angle_rad(times), run.profile.speed_rad_s(times)
    change = run.profile.acceleration_rad_s2(times)
    bodies = excited_bodies(run)
    total = np.zeros((len(bodies), times.size), dtype=complex)
    for unbalance in run.unbalances:
        ratio = run.speed_ratios[unbalance.body]
        moment = unbalance.moment_kg_m * np.exp(1j * unbalance.phase_rad)
        square = (ratio * speed) ** 2 - 1j * ratio * change
        total[bodies.index(unbalance.body)] += moment * square * np.exp(1j * ratio * angle)
    return total


def excited_bodies(run: RunUp) -> tuple[str, ...]:
    """Return the bodies of a run-up that have unbalance, each once, as they first appear."""
    return tuple(dict.fromkeys(unbalance.body for unbalance in run.unbalances))


def excited_band_hz(run: RunUp) -> tuple[float, float]:
    """Return the frequencies that the unbalance of a run-up passes through.

    `run`: the record, with unbalance on one or more bodies that turn. Returns lowest and highest,
    Hz: |ratio| times the speed of the profile over 2π, of all bodies with unbalance together. The
    lowest is at least 2/duration, what the record resolves. Raises AnalysisError if no body has
    unbalance.
    """
    bodies = excited_bodies(run)
    if not bodies:
        raise AnalysisError("the run-up has no unbalance; nothing is excited")
    ratios = [abs(run.speed_ratios[body]) for body in bodies]
    speed_hz = run.profile.speeds_rad_s / (2.0 * np.pi)
    passes_zero = speed_hz.min() <= 0.0 <= speed_hz.max()
    slowest = 0.0 if passes_zero else min(ratios) * float(np.abs(speed_hz).min())
    fastest = max(ratios) * float(np.abs(speed_hz).max())
    duration_s = run.time_s.size / run.sample_rate_hz
    return max(slowest, 2.0 / duration_s), fastest


def normalised_response(
    run: RunUp, bearing: str, axis: str = "x", band_hz: float = 1.0, floor: float = 1e-6
) -> NormalisedResponse:
    """Return the spectrum of a bearing force divided by that of the excitation.

    `run`: the record, with the force of the bearing and unbalance on one or more bodies; `axis`:
    component of the force, "x" or "y". `band_hz`: width over which squared magnitudes are averaged
    before they are divided; smooths the ripple of the spectrum of a sweep. `floor`: frequencies at
    which the excitation is below this share of its largest value are nan. Returns √(⟨|F_P|²⟩ / Σ_b
    ⟨|F_b|²⟩) over the frequency: F_P the Fourier transform of the force along the axis, F_b that
    of the unbalance force of body b along it, ⟨⟩ the mean over the band. At a frequency that one
    body alone sweeps through this is the amplitude of the force per amplitude of its excitation.
    Both records fade in and out over a twentieth of their length. Outside `excited_band_hz` the
    ratio is nan: both spectra are side lobes there, whose quotient has peaks that belong to no
    resonance. Raises AnalysisError if the force was not recorded, there is no unbalance, or
    records are too coarse for the fastest excitation.

    Müller and Hennings, figure 18, "normalised to the respective excitation force", do not print a
    formula; this is the reading taken here. `order_response` keeps the bodies apart.
    """
    if axis not in _AXES:
        raise AnalysisError(f"axis is {axis!r}; allowed are {_AXES}")
    force = run.bearing_force_n(bearing)[_AXES.index(axis)]
    excitation = excitation_force_n(run, run.time_s)
    if not excitation.size or not np.abs(excitation).any():
        raise AnalysisError("the run-up has no unbalance to normalise with")
    low, high = excited_band_hz(run)
    if run.sample_rate_hz < 2.5 * high:
        raise AnalysisError(
            f"the force is recorded at {run.sample_rate_hz:.6g} Hz, the excitation goes to "
            f"{high:.6g} Hz; record 2.5 times per period or more"
        )
    part = excitation.real if axis == "x" else excitation.imag
    from scipy.signal import get_window  # takes a quarter of a second to import

    weight = get_window(("tukey", _FADE), run.time_s.size, fftbins=False)
    frequency = np.fft.rfftfreq(run.time_s.size, 1.0 / run.sample_rate_hz)
    width = max(1, round(band_hz / float(frequency[1])))
    out = _band_mean(_power(force * weight), width)
    given = _band_mean(_power(part * weight).sum(axis=0), width)
    middle = _band_mean(np.asarray(frequency), width)
    # the band that holds an end of the excitation still shows it
    half = 0.5 * width * float(frequency[1])
    known = (given > floor**2 * given.max()) & (middle >= low - half) & (middle <= high + half)
    known &= middle >= 2.0 / (run.time_s.size / run.sample_rate_hz)
    ratio = np.sqrt(np.divide(out, given, out=np.full(out.size, np.nan), where=known))
    return NormalisedResponse(frequency_hz=middle, ratio=ratio, excited_hz=(low, high))


def order_response(run: RunUp, bearing: str, body: str, duration_s: float) -> NormalisedResponse:
    """Return the force of a bearing that follows the unbalance of one body, per unit of it.

    `run`: the record, with the force of the bearing. Returns over the frequency of the body, at all
    records: largest radius of the ellipse that the force (F_x, F_y) of the order |ratio| draws,
    over the size of the unbalance force of all bodies with the same speed ratio. Raises
    AnalysisError if the force was not recorded or the body has no unbalance.
    """
    if body not in excited_bodies(run):
        raise AnalysisError(f"body {body!r} has no unbalance; there are {excited_bodies(run)}")
    ratio = run.speed_ratios[body]
    same = [name for name in excited_bodies(run) if run.speed_ratios[name] == ratio]
    rows = [excited_bodies(run).index(name) for name in same]
    given = np.abs(excitation_force_n(run, run.time_s)[rows].sum(axis=0))
    force = run.bearing_force_n(bearing)
    path = force[0] + 1j * force[1]
    sizes = [
        np.abs(order_amplitude(run.time_s, run.angle_rad, path, sign * ratio, duration_s))
        for sign in (1.0, -1.0)
    ]
    known = given > 0
    return NormalisedResponse(
        frequency_hz=np.abs(ratio) * np.abs(run.speed_rad_s) / (2.0 * np.pi),
        ratio=np.divide(sizes[0] + sizes[1], given, out=np.full(given.size, np.nan), where=known),
    )


def _power(signal: FloatArray) -> FloatArray:
    """Return the squared magnitude of the Fourier transform, (..., f)."""
    return np.asarray(np.abs(np.fft.rfft(signal, axis=-1)) ** 2)


def _band_mean(values: FloatArray, width: int) -> FloatArray:
    """Return the mean of each group of neighbours; a last group that is not full is left out."""
    whole = values.size // width * width
    return np.asarray(values[:whole].reshape(-1, width).mean(axis=1))
