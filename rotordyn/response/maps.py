"""Maps of the steady response: place of the unbalance × speed, and ground motion × speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.coordinates import Placed
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response import harmonic_response as harmonic
from solidwhirl.rotordyn.response import unbalance as exciters
from solidwhirl.rotordyn.response.orbits import OrbitRecord

# Colours of a map reach from a part of its largest height to this many times the median: one
# resonance without damping would leave a single colour to all else.
_DARKEST, _BRIGHTEST = 1e-5, 1e3
# Bytes of the amplitudes of all coordinates that are held at a time.
_BLOCK_BYTES = 1 << 25

Direction = Literal["x", "y"]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PlaceMap(OrbitRecord):
    """Hold the response to one unbalance put at each of some places in turn.

    `moment_kg_m`: of the unbalance, kg m; `places`: where it was put; `speeds_rad_s`: Ω of the
    reference shaft, shape (s,); `frequencies_rad_s`: |speed ratio| Ω of the body of each place,
    shape (places, s); `nodes`: all interface nodes. `translation_m`: complex amplitudes of ux, uy,
    shape (places, s, nodes, 2); nan where a node has none.
    """

    moment_kg_m: float
    places: tuple[End, ...]
    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    nodes: tuple[End, ...]
    translation_m: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class GroundMotionMap(OrbitRecord):
    """Hold the response to a common harmonic motion of the ground, speed × frequency.

    `amplitude_m`: of the ground's displacement, m; `direction`: "x" or "y"; `speeds_rad_s`: Ω,
    shape (s,); `frequencies_rad_s`: ω of the ground, shape (f,); `node`: where the response is
    taken; `translation_m`: complex amplitudes of its absolute ux, uy, shape (s, f, 2).
    """

    amplitude_m: float
    direction: Direction
    speeds_rad_s: FloatArray
    frequencies_rad_s: FloatArray
    node: End
    translation_m: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StepPeaks(ReadOnlyArrays):
    """Hold the highest response in the step around every frequency of a map.

    `height_m`: largest major semi-axis between the middles to the frequencies beside, shape (rows,
    f); `frequency_rad_s`: where it is, shape (rows, f). `sampling_error`: of a height that is a
    peak over the frequency: what finding it between samples may be worth, relative, shape (rows,
    f); 0 where the highest is no peak, inf without damping.
    """

    height_m: FloatArray
    frequency_rad_s: FloatArray
    sampling_error: FloatArray


def shown_range(heights: npt.ArrayLike) -> tuple[float, float]:
    """Return the lowest and highest height that colours of a map tell apart.

    `heights`: of any shape; nan and 0 are none. Returns low < high. All that is lower or higher has
    the colour of the end. Raises AnalysisError if all heights are 0.
    """
    values = np.asarray(heights, dtype=float)
    positive = values[np.isfinite(values) & (values > 0)]
    if not positive.size:
        raise AnalysisError("all responses of the map are zero; there is nothing to draw")
    high = float(min(positive.max(), _BRIGHTEST * np.median(positive)))
    return min(max(float(positive.min()), _DARKEST * high), 0.999 * high), high


def place_map(
    assembled: AssembledSystem,
    places: Sequence[End],
    moment_kg_m: float,
    speeds_rad_s: npt.ArrayLike,
    spin_rad_s: float | None = None,
) -> PlaceMap:
    """Compute the response to one unbalance at each of some places in turn.

    `places`: interfaces with ux and uy on bodies that turn; each excites at its body's frequency
    and in its sense. `speeds_rad_s`, `spin_rad_s`: as for `unbalance_response`. The result is as in
    Müller and Hennings, figures 14 and 15. Raises AnalysisError if a place or number has no
    meaning, or a speed lies at an undamped resonance.
    """
    speeds = harmonic.non_negative("speeds_rad_s", speeds_rad_s)
    if not places:
        raise AnalysisError("places is empty; one or more are needed")
    unbalances = [
        exciters.Unbalance(body=end.body, interface=end.interface, moment_kg_m=moment_kg_m)
        for end in places
    ]
    ratios = np.array([exciters.frequency_ratio(assembled, one) for one in unbalances])
    nodes = harmonic.interface_nodes(assembled)
    result = np.empty((len(places), speeds.size, len(nodes), 2), dtype=complex)
    for ratio in np.unique(ratios):
        group = np.flatnonzero(ratios == ratio)
        patterns = [exciters.unbalance_loads(assembled, [unbalances[i]]) for i in group]
        loads = ((ratio * speeds) ** 2)[:, None, None] * np.stack(patterns, axis=1)
        spins = exciters.spins_at(speeds, spin_rad_s)
        solved = harmonic.harmonic_response(assembled, spins, ratio * speeds, loads)
        for column, place in enumerate(group):
            motion = solved.displacement[:, :, column]
            result[place] = harmonic.node_amplitudes(
                assembled, nodes, harmonic.TRANSLATIONS, motion
            )
    return PlaceMap(
        moment_kg_m=float(moment_kg_m),
        places=tuple(places),
        speeds_rad_s=speeds,
        frequencies_rad_s=np.multiply.outer(ratios, speeds),
        nodes=nodes,
        translation_m=result,
    )


def ground_motion_map(
    assembled: AssembledSystem,
    amplitude_m: float,
    direction: Direction,
    speeds_rad_s: npt.ArrayLike,
    frequencies_rad_s: npt.ArrayLike,
    node: End,
) -> GroundMotionMap:
    """Compute the response of a node to a common harmonic motion of all supports on the ground.

    `assembled`: the system; every body must be able to move along (no body held within itself).
    `amplitude_m`: of the displacement of the ground, m. `speeds_rad_s`, `frequencies_rad_s`: Ω ≥
    0, shape (s,), and ω ≥ 0, shape (f,), rad/s; every pair is solved. The result is the waterfall
    diagram of Müller and Hennings, figure 16. Raises AnalysisError if an argument has no meaning,
    or a pair lies at an undamped resonance.

    With u = R x_g + T q, R the common translation of all bodies and T q the motion relative to the
    ground: bearings see T q alone, and K R, (Kgeo − S) R and G R vanish for a translation, so that
    M q'' + ... = −Tᵀ M_bodies R x_g'' (Genta 2005, Dynamics of Rotating Systems, section 3.9).
    """
    speeds = harmonic.non_negative("speeds_rad_s", speeds_rad_s)
    frequencies = harmonic.non_negative("frequencies_rad_s", frequencies_rad_s)
    if not np.isfinite(amplitude_m):
        raise AnalysisError(f"amplitude_m is {amplitude_m}; it must be finite")
    harmonic.check_lateral(assembled, node, "node of the response")
    pattern = amplitude_m * harmonic.independent_loads(assembled, _momentum(assembled, direction))
    result = np.empty((speeds.size, frequencies.size, 2), dtype=complex)
    rows = max(1, _BLOCK_BYTES // (16 * assembled.size * frequencies.size))
    for start in range(0, speeds.size, rows):
        block = speeds[start : start + rows]
        omega = np.tile(frequencies, block.size)
        loads = (omega**2)[:, None, None] * pattern[:, None]
        repeated = np.repeat(block, frequencies.size)
        relative = harmonic.node_response(assembled, (node,), repeated, omega, loads)
        result[start : start + rows] = relative.reshape(block.size, frequencies.size, 2)
    result[..., ("x", "y").index(direction)] += amplitude_m
    return GroundMotionMap(
        amplitude_m=float(amplitude_m),
        direction=direction,
        speeds_rad_s=speeds,
        frequencies_rad_s=frequencies,
        node=node,
        translation_m=result,
    )


def check_followed(assembled: Placed, direction: str) -> int:
    """Return the axis of the ground's motion, 0 or 1.

    Raises AnalysisError: no such axis, or a body that cannot follow.
    """
    if direction not in ("x", "y"):
        raise AnalysisError(f"direction is {direction!r}; allowed are 'x' and 'y'")
    column = ("x", "y").index(direction)
    for name, rotor in assembled.system.rotors.items():
        if not rotor.element.rigid_body_present[column]:
            raise AnalysisError(
                f"body {name!r} cannot move along {direction} as a whole, so it cannot follow the "
                "ground; hold it by a bearing instead of within its superelement"
            )
    return column


def _momentum(assembled: AssembledSystem, direction: str) -> dict[str, ComplexArray]:
    """Return the momentum of each body as it moves by one metre per second with the ground."""
    column = check_followed(assembled, direction)
    return {
        name: np.asarray(r.element.mass @ r.element.rigid_body_modes[:, column], dtype=complex)
        for name, r in assembled.system.rotors.items()
    }
