"""Where the bearings of a system leave the range of their law, drive motion or push outwards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from solidwhirl.rotordyn.assembly.bearing_laws import RingLaw, TableLaw
from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyTableLaw, frequency_law
from solidwhirl.rotordyn.assembly.law_pieces import BearingCoefficients, LawPieces
from solidwhirl.rotordyn.assembly.magnetic_laws import magnetic_bearing
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem, law_speed_ratio, spin_sign
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Speeds looked at besides those given; a dip between two of them is found if it has a slope there.
_SAMPLES = 257
# An eigenvalue above minus this fraction of the largest entry is a rounded zero.
_ROUNDED_ZERO = 1e-14
# Halvings that locate the ends of an interval.
_HALVINGS = 48


class Beyond(NamedTuple):
    """A quantity (with its unit), its figure, and the limit that it is beyond."""

    quantity: str
    value: float
    limit: float


@dataclass(frozen=True, kw_only=True)
class BearingNote:
    """Tell that a bearing is doubtful over an interval of speed.

    `kind`: "outside range" (of the speeds the law was made for), "negative damping" or "negative
    stiffness" (a motion exists to which the bearing gives energy, or that it does not resist),
    "mirrored" or "not mirrored" (cross terms under a shaft that turns backward), "held torsion" (a
    spring between a turning shaft and the ground acts on rz), "beyond theory" (that the law is
    computed by; `beyond` has the figure and its limit then); `speed_low_rad_s`,
    `speed_high_rad_s`: where, as |Ω| of the reference shaft, rad/s. `finding`: what was found,
    with its figures but without bearing and speeds; the same for bearings of one law.
    """

    bearing: str
    kind: str
    speed_low_rad_s: float
    speed_high_rad_s: float
    finding: str
    beyond: Beyond | None = None

    @property
    def message(self) -> str:
        """One line with the speeds, the finding and the bearing."""
        return note_lines((self,))[0]

    @property
    def speed_low_rpm(self) -> float:
        """Lower end of the interval, rpm of the reference shaft."""
        return self.speed_low_rad_s * RPM_PER_RAD_S

    @property
    def speed_high_rpm(self) -> float:
        """Upper end of the interval, rpm of the reference shaft."""
        return self.speed_high_rad_s * RPM_PER_RAD_S


def note_lines(notes: Sequence[BearingNote]) -> tuple[str, ...]:
    """Return one line for each finding, the speeds of the reference shaft first.

    `notes`: from `bearing_notes`; bearings with the same finding at the same speeds share a line.
    """
    speeds: dict[tuple[str, str], list[str]] = {}
    for note in notes:
        speeds.setdefault((note.finding, note.bearing), []).append(_range_text(note))
    bearings: dict[tuple[str, str], list[str]] = {}
    for (finding, bearing), ranges in speeds.items():
        bearings.setdefault((finding, " and ".join(ranges)), []).append(bearing)
    return tuple(
        f"{ranges} rpm: {finding} (bearing{'s' if len(names) > 1 else ''} {', '.join(names)})"
        for (finding, ranges), names in bearings.items()
    )


def _range_text(note: BearingNote) -> str:
    low, high = note.speed_low_rpm, note.speed_high_rpm
    return f"{high:.6g}" if low == high else f"{low:.6g} to {high:.6g}"


def bearing_notes(
    assembled: AssembledSystem, speeds_rad_s: npt.ArrayLike
) -> tuple[BearingNote, ...]:
    """Find where bearings are used beyond their law, or have negative damping or stiffness.

    `speeds_rad_s`: Ω of an analysis; everything between the smallest and the largest |Ω| is looked
    at. The result is empty if all is well; bearings without a law are looked at too. Raises
    AnalysisError if there are no speeds or one is not finite.

    Negative means that the symmetric part of the 2×2 matrix on (ux, uy) has a negative eigenvalue.
    Besides the speeds given and 257 more those at which a law has a knot, a stationary entry or a
    singular matrix are looked at, and between them; ends are located to rounding.
    """
    speeds = np.abs(np.asarray(speeds_rad_s, dtype=float)).ravel()
    if not speeds.size or not np.isfinite(speeds).all():
        raise AnalysisError(f"speeds_rad_s needs finite speeds; found {speeds.size} values")
    signed = np.asarray(speeds_rad_s, dtype=float).ravel()
    low = 0.0 if signed.min() < 0 < signed.max() else float(speeds.min())
    sampled = np.unique(np.concatenate((speeds, np.linspace(low, speeds.max(), _SAMPLES))))
    joints = Counter(joint.bearing for joint in assembled.law_joints)
    # of a law that is made of several no one tells the whole
    pieces = {j.bearing: j.pieces for j in assembled.law_joints if joints[j.bearing] == 1}
    notes: list[BearingNote] = []
    for bearing in assembled.system.bearings:
        own = pieces.get(bearing.name)
        found = [*_range_findings(assembled, bearing, sampled)]
        found += _sign_findings(assembled, bearing, own, _with_turns(sampled, own))
        found += _sense_findings(assembled, bearing, sampled)
        for kind, first, last, text in found:
            notes.append(
                BearingNote(
                    bearing=bearing.name,
                    kind=kind,
                    speed_low_rad_s=first,
                    speed_high_rad_s=last,
                    finding=text,
                )
            )
    return tuple(notes)


# Kind, lowest and highest speed, and text.
_Finding: TypeAlias = tuple[str, float, float, str]


def _with_turns(speeds: FloatArray, pieces: LawPieces | None) -> FloatArray:
    """Return speeds with those at which the signs of a law may change, and their middles."""
    if pieces is None or speeds.size < 2:
        return speeds
    turns = pieces.turning_speeds(float(speeds[0]), float(speeds[-1]))
    turns = np.concatenate((speeds[:1], turns, speeds[-1:]))
    return np.asarray(np.unique(np.concatenate((speeds, turns, 0.5 * (turns[1:] + turns[:-1])))))


def _sense_findings(
    assembled: AssembledSystem, bearing: Bearing, speeds: FloatArray
) -> Iterator[_Finding]:
    """Yield what the sense in which a shaft turns means for its bearing."""
    sign = spin_sign(assembled.system, bearing)
    body = next((e.body for e in bearing.ends if assembled.system.rotors[e.body].speed_ratio), "")
    said: list[tuple[str, str]] = []
    if bearing.cross_coupling == "mirrored":
        text = f"{body!r} turns backward, so the signs of its cross terms are changed"
        said.append(("mirrored", f'{text} (cross_coupling = "with_spin")'))
    elif sign < 0 and bearing.has_spin_coupling:
        text = f"{body!r} turns backward, and its cross terms act as for a shaft that turns forward"
        said.append(("not mirrored", f'{text} (cross_coupling = "as_given")'))
    holds = "rz" in bearing.rigid or bearing.torsion_stiffness_n_m_per_rad != 0
    if bearing.second is None and holds and sign != 0:
        text = f"it holds rz of the rotating {body!r} to ground"
        said.append(("held torsion", f"{text}; treated as a constant-speed drive"))
    for kind, text in said:
        yield kind, float(speeds[0]), float(speeds[-1]), text


def spin_ratio(assembled: AssembledSystem, bearing: Bearing) -> float:
    """Return the spin speed of a bearing's first side over that of the reference shaft.

    It is not negative; a law is evaluated at this times |Ω|.
    """
    return abs(law_speed_ratio(assembled.system, bearing))


def coefficients_at_speed(
    assembled: AssembledSystem, bearing: Bearing, speed_rad_s: float
) -> BearingCoefficients:
    """Return the coefficients of a bearing on (ux, uy) at a speed of the reference shaft.

    The result is of its law, without tilt terms, or its own ones if it has none; each (2, 2).
    """
    if bearing.speed_law is None:
        return BearingCoefficients(bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)
    law = bearing.speed_law
    by_frequency = frequency_law(law)
    if by_frequency is not None:  # for slow motions: those of added mass are no stiffness
        law = by_frequency.at_rate(0j)
    found = law.coefficients(
        spin_ratio(assembled, bearing) * abs(speed_rad_s),
        bearing.stiffness_n_per_m,
        bearing.damping_n_s_per_m,
    )
    return BearingCoefficients(*(matrix[:2, :2] for matrix in found))


def _range_findings(
    assembled: AssembledSystem, bearing: Bearing, speeds: FloatArray
) -> Iterator[_Finding]:
    law = bearing.speed_law
    if law is None:
        return
    ratio = spin_ratio(assembled, bearing)
    low, high = law.speed_range_rad_s
    kind, beyond = "law", "its polynomials go on"
    if isinstance(law, TableLaw | FrequencyTableLaw | RingLaw):
        kind, beyond = "table", "end values are held"
    for sign, end in ((-1.0, low), (1.0, high)):
        outside = speeds[sign * ratio * speeds > sign * end * (1.0 + sign * _ROUNDED_ZERO)]
        if not outside.size:
            continue
        first, last = float(outside[0]), float(outside[-1])
        # The interval begins where the range ends, not at the sample after it.
        if ratio > 0 and sign > 0:
            first = max(end / ratio, float(speeds[0]))
        elif ratio > 0:
            last = min(end / ratio, float(speeds[-1]))
        whose = "" if ratio == 1 else f" of {bearing.first.body!r}"
        text = (
            f"{kind} {law.name!r} covers {low * RPM_PER_RAD_S:.6g} to {high * RPM_PER_RAD_S:.6g} "
            f"rpm{whose}; {beyond} outside"
        )
        yield "outside range", first, last, text


def _sign_findings(
    assembled: AssembledSystem, bearing: Bearing, pieces: LawPieces | None, speeds: FloatArray
) -> Iterator[_Finding]:
    if bearing.speed_law is not None and magnetic_bearing(bearing.speed_law) is not None:
        return  # a controller has its signs at each frequency: stability tells
    for part, kind, unit in ((1, "negative damping", "N s/m"), (0, "negative stiffness", "N/m")):

        def lowest(speeds: FloatArray, part: int = part) -> FloatArray:
            if pieces is not None:
                return _lowest_eigenvalues(pieces.along(speeds)[part][:, :2, :2])
            if bearing.speed_law is None:
                speeds = speeds[:1]
            found = [coefficients_at_speed(assembled, bearing, float(s))[part] for s in speeds]
            return _lowest_eigenvalues(np.array(found))

        law = "" if bearing.speed_law is None else f" by law {bearing.speed_law.name!r}"
        for low, high, value, at in _negative_intervals(lowest, speeds):
            text = f"{kind}{law}, down to {value:.4g} {unit} at {at * RPM_PER_RAD_S:.6g} rpm"
            yield kind, low, high, text


def _lowest_eigenvalues(matrices: FloatArray) -> FloatArray:
    """Return the smaller eigenvalue of the symmetric part of each, 0 if it is a rounded zero."""
    (xx, xy), (yx, yy) = np.moveaxis(matrices, 0, -1)
    values = 0.5 * (xx + yy - np.hypot(xx - yy, xy + yx))
    limits = _ROUNDED_ZERO * np.abs(matrices).max(axis=(1, 2))
    return np.asarray(np.where(np.abs(values) <= limits, 0.0, values))


def _negative_intervals(
    lowest: Callable[[FloatArray], FloatArray], speeds: FloatArray
) -> list[tuple[float, float, float, float]]:
    """Return where a function of the speed is negative, its lowest value there, and where.

    `lowest`: of speeds of shape (s,), shape (s,), or (1,) of one that is constant.
    """

    def measure(speed: float) -> float:
        return float(lowest(np.array([speed]))[0])

    values = np.broadcast_to(lowest(speeds), speeds.shape).tolist()
    points = list(zip(speeds.tolist(), values, strict=True))
    for i in range(1, len(values) - 1):
        # A dip between samples: the minimum is at or beside a sample that is not negative.
        if 0 <= values[i] <= min(values[i - 1], values[i + 1]) and values[i - 1] != values[i]:
            found = scipy.optimize.minimize_scalar(
                measure, bounds=speeds[[i - 1, i + 1]], method="bounded"
            )
            if found.fun < 0:
                points.append((float(found.x), float(found.fun)))
    points.sort()
    intervals = []
    for is_negative, group in groupby(range(len(points)), key=lambda i: points[i][1] < 0):
        if not is_negative:
            continue
        inside = list(group)
        start, stop = inside[0], inside[-1]
        low, high = points[start][0], points[stop][0]
        if start > 0:
            low = _end(measure, points[start][0], points[start - 1][0])
        if stop + 1 < len(points):
            high = _end(measure, points[stop][0], points[stop + 1][0])
        deepest = min((points[i][1], points[i][0]) for i in inside)
        intervals.append((low, high, *deepest))
    return intervals


def _end(measure: Callable[[float], float], negative: float, other: float) -> float:
    """Return where between two speeds a measure stops being negative."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (negative + other)
        if measure(middle) < 0:
            negative = middle
        else:
            other = middle
    return negative
