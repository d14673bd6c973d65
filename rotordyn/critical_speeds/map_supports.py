"""Supports of a critical speed map: without damping and cross-coupling, and as they are."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.bearing_laws import (
    LawPart,
    OfAnotherLaw,
    RingLaw,
    SpeedLaw,
    law_motions,
    law_pieces,
)
from solidwhirl.rotordyn.assembly.frequency_laws import frequency_law
from solidwhirl.rotordyn.assembly.law_pieces import BearingCoefficients, LawPieces
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    assemble,
    at_whirl_ratio,
    bearing_matrices,
    law_speed_ratio,
)
from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError


@dataclass(frozen=True, kw_only=True)
class _UncoupledLaw(OfAnotherLaw):
    """The symmetric part of the stiffness of a law, without damping."""

    law: SpeedLaw

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        return self.pieces(stiffness_n_per_m, damping_n_s_per_m).at(speed_rad_s)

    def pieces(self, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> LawPieces:
        found = law_pieces(self.law, stiffness_n_per_m, damping_n_s_per_m)
        assert found is not None
        rows = 0.5 * (found.polynomials + found.polynomials.swapaxes(-1, -2))
        rows[:, :, 1] = 0.0
        return LawPieces(starts_rad_s=found.starts_rad_s, polynomials=rows)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SupportStiffness(ReadOnlyArrays):
    """Hold the stiffness of a bearing over the speed.

    `speeds_rad_s`: Ω of the reference shaft, shape (s,); `kxx_n_per_m`, `kyy_n_per_m`: at them;
    `effective_n_per_m`: force over radius of a synchronous forward circle, stiffness and damping
    together, |½ (Zxx + Zyy − i Zxy + i Zyx)| with Z = K + iωC.
    """

    bearing: str
    speeds_rad_s: FloatArray
    kxx_n_per_m: FloatArray
    kyy_n_per_m: FloatArray
    effective_n_per_m: FloatArray


def uncoupled_supports(
    assembled: AssembledSystem, names: Sequence[str], ratio: float
) -> AssembledSystem:
    """Return a system whose other bearings have the symmetric part of their stiffness alone.

    `names`: bearings that a map varies, which stay; `ratio`: frequency over Ω, at which bearings
    that depend on the frequency are taken. The system itself if its stiffness is symmetric. Raises
    AnalysisError if a law does not tell its polynomials.
    """
    if assembled.has_symmetric_joints and not assembled.depends_on_frequency:
        return assembled
    system = assembled.system

    def changed(bearing: Bearing) -> Bearing:
        if bearing.name in names:
            return bearing
        law, by_frequency = bearing.speed_law, frequency_law(bearing.speed_law)
        if by_frequency is not None:
            law = by_frequency.at_whirl_ratio(abs(ratio / law_speed_ratio(system, bearing)))
        if isinstance(law, RingLaw):
            # symmetric as it is; of each part without damping
            parts = (LawPart(rows, _UncoupledLaw(law=own)) for rows, own in law.parts)
            law = dataclasses.replace(law, parts=tuple(parts))
        elif law is not None and (len(law_motions(law)) != 2 or not hasattr(law, "pieces")):
            raise AnalysisError(
                f"bearing {bearing.name!r}: its law {law.name!r} is not one of ux and uy over the "
                "speed; name it among the bearings of the map, which replaces it"
            )
        own = {
            key: 0.5 * (getattr(bearing, key) + getattr(bearing, key).T)
            for key in ("stiffness_n_per_m", "tilt_stiffness_n_m_per_rad")
        }
        law = law if law is None or isinstance(law, RingLaw) else _UncoupledLaw(law=law)
        return dataclasses.replace(bearing, **own, speed_law=law, sensor=None)

    bearings = tuple(changed(bearing) for bearing in system.bearings)
    return assemble(system.rotors, bearings, system.reference, system.gears)


def support_stiffness(
    assembled: AssembledSystem, name: str, speeds_rad_s: npt.ArrayLike, ratio: float = 1.0
) -> SupportStiffness:
    """Return the stiffness of a bearing over the speed, to draw it over a critical speed map.

    `speeds_rad_s`: Ω ≥ 0, shape (s,); `ratio`: frequency of the motion over Ω. Raises AnalysisError
    if there is no such bearing.
    """
    known = {bearing.name: bearing for bearing in assembled.system.bearings}
    if name not in known:
        raise AnalysisError(f"there is no bearing {name!r}; there are {list(known)}")
    steady, speeds = at_whirl_ratio(assembled, ratio), np.asarray(speeds_rad_s, dtype=float)
    found = [bearing_matrices(steady, known[name], float(speed)) for speed in speeds]
    stiffness = np.array([k[:2, :2] for k, _ in found])
    damping = np.array([c[:2, :2] for _, c in found])
    z = stiffness + 1j * ratio * speeds[:, None, None] * damping
    circle = 0.5 * (z[:, 0, 0] + z[:, 1, 1] - 1j * z[:, 0, 1] + 1j * z[:, 1, 0])
    return SupportStiffness(
        bearing=name,
        speeds_rad_s=speeds,
        kxx_n_per_m=stiffness[:, 0, 0],
        kyy_n_per_m=stiffness[:, 1, 1],
        effective_n_per_m=np.abs(circle),
    )
