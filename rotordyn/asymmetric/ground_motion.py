"""Response to harmonic motion of the ground, of engines in the frame that turns with their bodies.

A ground that moves at one frequency ω moves them at ω + kΩ too. What is seen at ω therefore comes
from ground motion of all frequencies |ω + kΩ|; each is a right hand side of one system.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.loads import gravity_force
from solidwhirl.rotordyn.asymmetric.parametric.basis import held_to, search_basis
from solidwhirl.rotordyn.asymmetric.parametric.constant import ConstantMotions
from solidwhirl.rotordyn.asymmetric.parametric.exponents import PeriodicMotions
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, PeriodicSystem
from solidwhirl.rotordyn.asymmetric.response import driven_motion, held_where_free
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response import harmonic_response as harmonic
from solidwhirl.rotordyn.response import map_peaks as peaks
from solidwhirl.rotordyn.response.maps import Direction, StepPeaks, check_followed
from solidwhirl.rotordyn.response.orbits import OrbitRecord

# Multiples of the speed between the ground and what is seen: those that are always told, and those
# that are told where they matter, in parts of the largest motion.
_TOLD, _MOST, _MATTERS = 2, 4, 1e-6
# Answers of fast motions that resonances are sought with.
_ANSWER = 3e-4
# Bytes of the matrices that are held at a time.
_BLOCK_BYTES = 1 << 23


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingGroundMap(OrbitRecord):
    """Hold the response to ground motion of an engine with asymmetric bodies, speed × frequency.

    `amplitude_m`, `direction`, `node`: as of `GroundMotionMap`; `speeds_rad_s`: Ω of the frame,
    shape (s,); `frequencies_rad_s`: ω at which the motion is seen, shape (f,); `multiples`: k,
    rising, shape (k,). `translation_m`: complex amplitudes of absolute ux, uy at ω, by ground
    motion A e^{i(ω + kΩ)t}, shape (s, f, k, 2): at a negative ω + kΩ the conjugate of a motion at
    |ω + kΩ|. At rest all is at k = 0, with the bodies at the angle 0.
    """

    amplitude_m: float
    direction: Direction
    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    node: End
    multiples: IntArray
    translation_m: ComplexArray

    def height_m(self) -> FloatArray:
        """Return the motion by ground motion alike at all frequencies, shape (s, f), m.

        The root of the sum of the squares of the major semi-axes of all k: the phases of different
        frequencies have nothing to do with each other.
        """
        return np.asarray(np.linalg.norm(self.major_m(), axis=2))


def rotating_ground_map(
    rotating: RotatingSystem,
    amplitude_m: float,
    direction: Direction,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    node: End,
) -> RotatingGroundMap:
    """Compute the response of a node to a common harmonic motion of all supports on the ground.

    Arguments as of `ground_motion_map`; speeds are those of the frame. Raises AnalysisError as
    there, and if the multiples of the speed in a motion do not die out.
    """
    speeds = harmonic.non_negative("speeds_rad_s", speeds_rad_s)
    frequencies = harmonic.non_negative("frequencies_rad_s", frequencies_rad_s)
    if not np.isfinite(amplitude_m):
        raise AnalysisError(f"amplitude_m is {amplitude_m}; it must be finite")
    stride = rotating.periodic.stride
    reach = _MOST if stride else _TOLD
    multiples = np.arange(-reach, reach + 1, stride or 2)
    every = RotatingGroundMap(
        amplitude_m=float(amplitude_m),
        direction=direction,
        speeds_rad_s=speeds,
        frequencies_rad_s=frequencies,
        node=node,
        multiples=multiples,
        translation_m=np.zeros((0, 0, 0, 2), dtype=complex),
    )
    shaken = _shaken(rotating, every)
    motion = np.array([shaken.response(speed, frequencies) for speed in speeds])
    sizes = np.abs(motion).max(axis=(0, 1, 3))
    told = (sizes > _MATTERS * sizes.max()) | (multiples % 2 == 0) & (abs(multiples) <= _TOLD)
    return replace(every, multiples=multiples[told], translation_m=motion[:, :, told])


def rotating_ground_peaks(rotating: RotatingSystem, ground_map: RotatingGroundMap) -> StepPeaks:
    """Find the highest response to ground motion in the steps of a map, see `ground_motion_peaks`.

    Sought around the frequencies |Im λ + kΩ| at which motions of the engine are seen.
    """
    known, speeds = ground_map.frequencies_rad_s, ground_map.speeds_rad_s
    shaken = _shaken(rotating, ground_map)
    modes = _modes(shaken, float(speeds.max()), float(known.max()))

    def row(at: int) -> peaks.Row:
        speed = float(speeds[at])
        return peaks.resolved_row(
            known, ground_map.translation_m[at], modes(speed), partial(shaken.response, speed)
        )

    rows = (row(at) for at in range(speeds.size))
    summits = peaks.summits if shaken.periodic.is_damped else peaks.sampled_peaks
    return peaks.step_peaks(known, rows, summits)


class _Shaken(NamedTuple):
    """An engine on a moving ground.

    `seat`: ux and uy of the node in fixed axes by harmonic, (2, n); `load`: of the ground by
    harmonic, (n,), at unit frequency; `ground`: its motion, (2,), m; `multiples`: k, (k,).
    """

    periodic: PeriodicSystem
    seat: Harmonics
    load: Harmonics
    ground: FloatArray
    multiples: IntArray

    def response(self, speed: float, frequencies: FloatArray) -> ComplexArray:
        """Amplitudes of ux, uy at frequencies (f,) by the ground at ω + kΩ, (f, k, 2)."""
        own = self if speed else self._at_rest()
        loads = own._loads(speed)
        rate = np.add.outer(frequencies, speed * self.multiples)
        held = max(1, int(_BLOCK_BYTES / (32 * len(loads) * self.periodic.size**2)))
        pieces = np.split(frequencies, range(held, frequencies.size, held))
        relative = np.concatenate([own._seen(speed, piece, loads) for piece in pieces])
        out = (rate**2)[:, :, None] * relative
        out[:, self.multiples == 0] += self.ground
        return np.asarray(out)

    def _seen(self, speed: float, frequencies: FloatArray, loads: Harmonics) -> ComplexArray:
        motion = driven_motion(self.periodic, speed, frequencies, loads)
        found = [part @ motion[-a] for a, part in self.seat.items() if -a in motion]
        return np.asarray(np.sum(found, axis=0).swapaxes(1, 2))

    def _loads(self, speed: float) -> Harmonics:
        """Loads of all k that meet the node, (n, k) by harmonic."""
        stride = self.periodic.stride
        out: Harmonics = {}
        for column, k in enumerate(self.multiples.tolist()):
            for h, load in self.load.items() if speed or not k else ():
                beside = [h + k + a for a in self.seat]
                if any(not b % stride if stride else not b for b in beside):
                    out.setdefault(h + k, np.zeros((load.size, self.multiples.size), dtype=complex))
                    out[h + k][:, column] = load
        return out

    def _at_rest(self) -> _Shaken:
        """The same at rest, with all bodies at the angle 0."""
        seat, load = ({0: np.sum([*parts.values()], axis=0)} for parts in (self.seat, self.load))
        return self._replace(periodic=self.periodic.at_angle_zero(), seat=seat, load=load)


def _shaken(rotating: RotatingSystem, ground_map: RotatingGroundMap) -> _Shaken:
    """What a map looks at."""
    column = check_followed(rotating, ground_map.direction)
    harmonic.check_lateral(rotating, ground_map.node, "node of the response")
    top = max(float(ground_map.speeds_rad_s.max()), float(ground_map.frequencies_rad_s.max()), 1.0)
    motion = ground_map.amplitude_m * np.eye(3)[column]
    return _Shaken(
        periodic=held_where_free(rotating, top),
        seat={h: part[:2] for h, part in rotating.seat(ground_map.node).items() if part[:2].any()},
        load=gravity_force(rotating, motion),
        ground=motion[:2],
        multiples=ground_map.multiples,
    )


def _modes(
    shaken: _Shaken, speed_rad_s: float, frequency_rad_s: float
) -> Callable[[float], ComplexArray]:
    """Return what makes λ of a speed as they are seen at the node, Im λ + kΩ their frequencies.

    `speed_rad_s`, `frequency_rad_s`: the highest.
    """
    stride, few, turning = shaken.periodic.stride, shaken.periodic, None
    if stride:
        fastest = frequency_rad_s + (1 + stride) * speed_rad_s
        few = held_to(few, search_basis(few, fastest, speed_rad_s, _ANSWER))
        turning = PeriodicMotions(few, np.eye(few.size), fastest)
    multiples = sorted({a + m * stride for a in shaken.seat for m in (-1, 0, 1)})

    def modes(speed: float) -> ComplexArray:
        if turning is not None and speed:
            values = turning.solve(speed).own
        else:
            still = few if speed else few.at_angle_zero()
            values = ConstantMotions(still, 0.5 * speed, max(speed, 1.0)).solve(speed).values
        return np.add.outer(values, 1j * speed * np.array(multiples)).ravel()

    return modes
