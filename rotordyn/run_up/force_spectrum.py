"""Spectra of recorded forces: over all of a record, over short pieces, and by order of speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak, resonance_peaks

WINDOWS = ("boxcar", "hann", "flattop")
# Times may miss an even spacing by this fraction of it.
_EVEN = 1e-6
# A window of an order must hold this many turns of it, so that it tells the order from −order.
_TURNS = 2.0
# A line of the spectrum is a peak where it rises above its surroundings by this factor.
_PROMINENT = 3.0
# Beyond what drives a signal its peaks are above side lobes by this factor.
_ABOVE_LOBES = 10.0
# Lines in which there may be a peak.
_FEWEST_LINES = 3


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class AmplitudeSpectrum(ReadOnlyArrays):
    """Hold the amplitudes of the harmonic parts of a signal.

    `frequency_hz`: from 0 to half the sample rate, shape (f,); `amplitude`: in the unit of the
    signal, shape (..., f): a·cos(2πft + φ) gives a at f. `window`: name of the window; amplitudes
    are divided by its mean.
    """

    frequency_hz: FloatArray
    amplitude: FloatArray
    window: str


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Spectrogram(ReadOnlyArrays):
    """Hold amplitude spectra of short pieces of a signal.

    `time_s`: middle of each piece, shape (t,); `frequency_hz`: shape (f,); `amplitude`: in the
    unit of the signal, shape (f, t). `duration_s`: of each piece; lines closer than about
    2/duration are not told apart.
    """

    time_s: FloatArray
    frequency_hz: FloatArray
    amplitude: FloatArray
    window: str
    duration_s: float


def amplitude_spectrum(
    time_s: npt.ArrayLike, signal: npt.ArrayLike, window: str = "hann"
) -> AmplitudeSpectrum:
    """Return the one-sided amplitude spectrum of real signals.

    `time_s`: evenly spaced times, shape (s,), s; `signal`: shape (..., s); `window`: "boxcar"
    (sharp lines, if their periods fit the record), "hann" (general), "flattop" (amplitudes right to
    0.2 % between lines). The result is of each signal. Raises AnalysisError if times are not even,
    shapes do not fit or the window is unknown.

    Harris 1978, Proc. IEEE 66: amplitudes are corrected by the coherent gain of the window.
    """
    step, values = _checked(time_s, signal)
    _check_real(values)
    weight = _window(window, values.shape[-1])
    return AmplitudeSpectrum(
        frequency_hz=np.fft.rfftfreq(values.shape[-1], step),
        amplitude=_one_sided(values * weight, weight),
        window=window,
    )


def spectrum_peaks(
    spectrum: AmplitudeSpectrum, from_hz: float, driven_to_hz: float, floor: float = 1e-4
) -> tuple[ResonancePeak, ...]:
    """Return the peaks of a spectrum that are more than side lobes of its window.

    `spectrum`: of one signal, with the Hann window; `from_hz`: lowest frequency that counts;
    `floor`: lowest peak over the highest. `driven_to_hz`: highest frequency of what drives the
    signal. Peaks above it must rise ten times above the side lobes that a line there as high as the
    highest peak would have. The result is by rising frequency; each rises by a factor of three
    above its surroundings. Raises AnalysisError if the spectrum is of several signals or has
    another window.

    Side lobes of the Hann window k lines off are at most 1/(π k (k² − 1)) of the line
    (Harris 1978, Proc. IEEE 66).
    """
    if spectrum.amplitude.ndim != 1 or spectrum.window != "hann":
        raise AnalysisError(
            f"the spectrum has shape {spectrum.amplitude.shape} and window {spectrum.window!r}; "
            "allowed are (f,) and 'hann'"
        )
    known = spectrum.frequency_hz > from_hz
    hertz, height = spectrum.frequency_hz[known], spectrum.amplitude[known]
    if hertz.size < _FEWEST_LINES:
        return ()
    found = resonance_peaks(2.0 * np.pi * hertz, height, _PROMINENT)
    highest = max((p.amplitude for p in found), default=0.0)
    spacing = float(spectrum.frequency_hz[1])

    def stands_out(peak: ResonancePeak) -> bool:
        lines = (peak.position_rad_s / (2.0 * np.pi) - driven_to_hz) / spacing
        lobe = 0.0 if lines <= 1.0 else _ABOVE_LOBES / (np.pi * lines * (lines**2 - 1.0))
        return bool(peak.amplitude >= max(floor, lobe) * highest)

    return tuple(p for p in found if stands_out(p))


def spectrogram(
    time_s: npt.ArrayLike,
    signal: npt.ArrayLike,
    duration_s: float,
    window: str = "hann",
    overlap: float = 0.75,
) -> Spectrogram:
    """Return amplitude spectra of overlapping pieces of a real signal.

    `time_s`: evenly spaced times, shape (s,), s; `signal`: shape (s,). `duration_s`: of each
    piece. Resolution in frequency is about 2/duration for "hann"; a line that moves by more within
    a piece is blurred. `window`: see `amplitude_spectrum`; `overlap`: share of a piece that the
    next one has in common with it, 0 to below 1. There are whole pieces only. Raises AnalysisError
    if an argument has no meaning.
    """
    step, values = _checked(time_s, signal)
    _check_real(values)
    count = round(duration_s / step) if np.isfinite(duration_s) else 0
    if values.ndim != 1 or not 8 <= count <= values.size:
        raise AnalysisError(
            f"duration_s is {duration_s} and the signal has shape {values.shape}; pieces of 8 "
            f"samples ({8 * step:.3g} s) up to all of one signal are allowed"
        )
    if not 0 <= overlap < 1:
        raise AnalysisError(f"overlap is {overlap}; allowed is 0 to below 1")
    weight = _window(window, count)
    hop = max(1, round(count * (1.0 - overlap)))
    starts = np.arange(0, values.size - count + 1, hop)
    pieces = np.lib.stride_tricks.sliding_window_view(values, count)[starts]
    first = float(np.asarray(time_s, dtype=float)[0])
    return Spectrogram(
        time_s=first + step * (starts + 0.5 * (count - 1)),
        frequency_hz=np.fft.rfftfreq(count, step),
        amplitude=_one_sided(pieces * weight, weight).T,
        window=window,
        duration_s=count * step,
    )


def order_amplitude(
    time_s: npt.ArrayLike,
    angle_rad: npt.ArrayLike,
    signal: npt.ArrayLike,
    order: float,
    duration_s: float,
) -> ComplexArray:
    """Return the complex amplitude of the part of a signal that follows an order of the speed.

    `time_s`: evenly spaced times, shape (s,), s; `angle_rad`: ∫Ω dt of the reference shaft, shape
    (s,); `signal`: real, or complex such as F_x + i F_y, shape (s,). `order`: turns per turn of the
    reference shaft; in a complex signal positive is forward and negative backward. `duration_s`: of
    the Hann window over which the part is averaged. Other parts are kept out if they are more than
    2/duration away in frequency; changes faster than that are smoothed. Returns a with signal ≈
    Re(a e^{i·order·angle}) for a real signal, a e^{i·order·angle} for a complex one, shape (s,);
    nan within half a window of the ends, and where the window holds fewer than two turns of the
    order. Raises AnalysisError if an argument has no meaning.

    Heterodyne order tracking: multiplied by e^{−i·order·angle} the part stands still, whatever the
    acceleration, and a window takes its mean.
    """
    step, values = _checked(time_s, signal)
    angle = np.asarray(angle_rad, dtype=float)
    count = 2 * round(0.5 * duration_s / step) + 1 if np.isfinite(duration_s) else 0
    if values.ndim != 1 or angle.shape != values.shape or not 8 <= count <= values.size:
        raise AnalysisError(
            f"duration_s is {duration_s}, the signal has shape {values.shape} and the angle "
            f"{angle.shape}; a window of 8 samples ({8 * step:.3g} s) up to all of one signal is "
            "allowed"
        )
    if not np.isfinite(order) or order == 0:
        raise AnalysisError(f"order is {order}; it must be finite and not 0")
    from scipy.signal import fftconvolve, get_window  # takes a quarter of a second to import

    weight = get_window("hann", count)
    factor = (1.0 if np.iscomplexobj(values) else 2.0) / weight.sum()
    still = values * np.exp(-1j * order * angle)
    found = factor * fftconvolve(still, weight, mode="same")
    half = count // 2
    turned = np.zeros(values.size)
    turned[half:-half] = np.abs(angle[2 * half :] - angle[: -2 * half])
    few = turned * abs(order) < _TURNS * 2.0 * np.pi
    return np.where(few, np.nan, found)


def _checked(time_s: npt.ArrayLike, signal: npt.ArrayLike) -> tuple[float, Matrix]:
    """Return the time step and the signal."""
    times, values = np.asarray(time_s, dtype=float), np.asarray(signal)
    if times.ndim != 1 or times.size < 2 or values.ndim < 1 or values.shape[-1] != times.size:
        raise AnalysisError(
            f"time_s has shape {times.shape} and the signal {values.shape}; allowed are (s,) and "
            "(..., s) with two or more samples"
        )
    step = float(times[-1] - times[0]) / (times.size - 1)
    if not (np.isfinite(times).all() and np.isfinite(values).all()):
        raise AnalysisError("time_s or the signal has entries that are not finite")
    if step <= 0 or np.abs(np.diff(times) - step).max() > _EVEN * step:
        raise AnalysisError("time_s is not evenly spaced and rising")
    return step, values


def _check_real(values: Matrix) -> None:
    if np.iscomplexobj(values):
        raise AnalysisError("the signal is complex; one-sided spectra are those of real signals")


def _window(name: str, count: int) -> FloatArray:
    if name not in WINDOWS:
        raise AnalysisError(f"window is {name!r}; allowed are {WINDOWS}")
    from scipy.signal import get_window

    return np.asarray(get_window(name, count))


def _one_sided(weighted: Matrix, weight: FloatArray) -> FloatArray:
    """Return amplitudes of real signals, 0 and half the sample rate counted once."""
    amplitude = 2.0 * np.abs(np.fft.rfft(weighted, axis=-1)) / weight.sum()
    amplitude[..., 0] *= 0.5
    if weight.size % 2 == 0:
        amplitude[..., -1] *= 0.5
    return np.asarray(amplitude)
