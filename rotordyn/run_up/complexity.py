"""How much flexibility a model needs: bodies without modes, rigid bodies, and what that costs.

Müller and Hennings, section 5.8, leave out the modes of single units of an engine and compare the
force at its mount during a run-up.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, assemble
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError, SuperelementError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import PartRun, run_up
from solidwhirl.rotordyn.run_up.record import Divergence, RunUp
from solidwhirl.rotordyn.run_up.response import NormalisedResponse, normalised_response
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile
from solidwhirl.rotordyn.superelement.mass_moments import projected_moments
from solidwhirl.rotordyn.superelement.record import Superelement

# A spin generator may couple kept and dropped coordinates by this.
_COUPLED = 1e-9
_SQUARE = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
# What a body with other coordinates does not know of itself.
_NOTHING_KNOWN: dict[str, Any] = {
    **dict.fromkeys(("free_frequencies_hz", "fixed_interface_frequencies_hz"), np.empty(0)),
    "frequency_error_estimate": np.empty(0),
    "error_forms": (),
}


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ComplexityComparison(ReadOnlyArrays):
    """Hold what models of one system give for the force through a bearing during a run-up.

    `names`: of the v models, the full one first; `sizes`: independent coordinates of each;
    `bearing`: whose force is compared; `bands_hz`: bands of frequency, shape (b, 2);
    `peak_force_n`: largest √(F_x² + F_y²) of each run, shape (v,); `peak_error`: of that relative
    to the full model, signed, shape (v,). `band_error`: root mean square difference of the
    normalised responses over the root mean square of the full model's, in the part of each band
    that is excited, shape (v, b); nan of a band of which nothing is. `wall_time_s`: of each run,
    shape (v,); `responses`: normalised response of each. `diverged`: models that diverged, by
    name: where they were stopped. They are in no other list.
    """

    names: tuple[str, ...]
    sizes: tuple[int, ...]
    bearing: str
    bands_hz: FloatArray
    peak_force_n: FloatArray
    peak_error: FloatArray
    band_error: FloatArray
    wall_time_s: FloatArray
    responses: tuple[NormalisedResponse, ...]
    diverged: Mapping[str, Divergence]


def without_modes(element: Superelement) -> Superelement:
    """Return a body that keeps only the static flexibility between its interfaces.

    It has no modal coordinates (Guyan 1965, AIAA J. 3, static condensation): rigid motion, mass
    and inertia are exact, the stiffness between interfaces is that of statics. What was known of
    its frequencies and errors is gone: the error forms are of other coordinates. Raises
    SuperelementError if the body has no interface coordinates.
    """
    kept = np.flatnonzero([c.kind == "interface" for c in element.coordinates])
    if not kept.size:
        raise SuperelementError(
            f"superelement {element.name!r} has no interface coordinates; without its modes "
            "nothing is left"
        )
    block = np.ix_(kept, kept)
    return dataclasses.replace(
        element,
        coordinates=tuple(element.coordinates[i] for i in kept),
        **{name: getattr(element, name)[block] for name in _SQUARE},
        rigid_body_modes=element.rigid_body_modes[kept],
        recovery_modes=element.recovery_modes[:, :, kept],
        **_NOTHING_KNOWN,
        spin_generator=_kept_turn(element, kept),
        constraint=None if element.constraint is None else element.constraint[kept],
        surface=None if element.surface is None else element.surface.of_coordinates(kept),
        provenance={**element.provenance, "without_modes": True},
        moments=projected_moments(element.moments, np.eye(element.size)[:, kept]),
    )


# a body is a record that never changes; models in which the same one is rigid share what it does
@lru_cache(maxsize=8)
def as_rigid_body(element: Superelement) -> Superelement:
    """Return a body that moves as one rigid piece.

    Its coordinates are the same, tied to its rigid motions by a `constraint`: mass, inertia and
    gyroscopic moment are exact, interfaces stay where they were. The error forms are left out, as
    they do not hold what the rigid body lacks. Raises SuperelementError if the body has no rigid
    motion.
    """
    if not element.rigid_body_present.any():
        raise SuperelementError(
            f"superelement {element.name!r} has no rigid motion; a body held to the ground cannot "
            "move as a rigid one"
        )
    return dataclasses.replace(
        element,
        constraint=element.rigid_body_modes[:, element.rigid_body_present],
        **_NOTHING_KNOWN,
        provenance={**element.provenance, "rigid": True},
    )


def system_with(
    assembled: AssembledSystem, elements: Mapping[str, Superelement]
) -> AssembledSystem:
    """Assemble a system again with other models of some bodies.

    `assembled`: the system; bearings, gears and speeds are taken from it. `elements`: new
    superelement of each body to exchange, by the name of the body. It is assembled from all parts,
    so that no reduction of the whole system is left. Raises AnalysisError if a body does not
    exist. Raises AssemblyError if a new element lacks an interface or component that a joint
    needs.
    """
    system = assembled.system
    _check_bodies(assembled, elements)
    rotors = {
        name: dataclasses.replace(rotor, element=elements.get(name, rotor.element))
        for name, rotor in system.rotors.items()
    }
    return assemble(rotors, system.bearings, system.reference, system.gears)


def rigid_bodies_system(assembled: AssembledSystem, bodies: Sequence[str]) -> AssembledSystem:
    """Return a system with some of its bodies rigid.

    `bodies`: names of the bodies that lose all flexibility. There are fewer coordinates: those of
    each body follow its rigid motions exactly. Raises AnalysisError if a body does not exist.
    Raises SuperelementError if a body has no rigid motion.
    """
    rotors = assembled.system.rotors
    _check_bodies(assembled, bodies)
    return system_with(assembled, {name: as_rigid_body(rotors[name].element) for name in bodies})


def compare_complexity(
    variants: Mapping[str, AssembledSystem],
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    *,
    bearing: str,
    bands_hz: Sequence[tuple[float, float]],
    band_hz: float = 1.0,
    known: dict[Hashable, PartRun] | None = None,
    **settings: Any,
) -> ComplexityComparison:
    """Run up models of the same system and compare the force through one bearing.

    `variants`: models by name; the first one is the full model that the others are measured by.
    `bearing`: the mount, without rigid components; `bands_hz`: lower and upper end of each band of
    frequency in which responses are compared. `band_hz`: see `normalised_response`; the response is
    that along x. `known`, `settings`: parts of other runs of the same machine and settings other
    than `outputs` and `bearings`, as of `run_up`; `step_s` must be given.

    Raises AnalysisError if there is no model, a band has no meaning or no frequency of the record
    in it, an argument of the run has no meaning, or the full model diverges.
    """
    if not variants:
        raise AnalysisError("there are no models to compare; give one or more")
    bands = _checked_bands(bands_hz)
    measured: dict[str, _Measured] = {}
    diverged: dict[str, Divergence] = {}
    known = {} if known is None else known  # models share what is the same in them
    for name, system in variants.items():
        run = run_up(system, profile, unbalances, known=known, bearings=[bearing], **settings)
        if run.stopped is None:
            response = normalised_response(run, bearing, "x", band_hz)
            measured[name] = _Measured(_peak_force_n(run, bearing), response, run.wall_time_s)
        elif measured:
            diverged[name] = run.stopped
        else:
            raise AnalysisError(
                f"{run.stopped.speed_rad_s * RPM_PER_RAD_S:.6g} rpm: the model {name!r} "
                "diverges; models are compared with its whole run-up"
            )
    peaks, responses, seconds = zip(*measured.values(), strict=True)
    return ComplexityComparison(
        names=tuple(measured),
        sizes=tuple(variants[name].size for name in measured),
        bearing=bearing,
        bands_hz=bands,
        peak_force_n=np.array(peaks),
        peak_error=np.array(peaks) / peaks[0] - 1.0,
        band_error=np.array([_band_errors(r, responses[0], bands) for r in responses]),
        wall_time_s=np.array(seconds),
        responses=responses,
        diverged=diverged,
    )


class _Measured(NamedTuple):
    """What is compared of a model that ran to the end."""

    peak_force_n: float
    response: NormalisedResponse
    wall_time_s: float


def _peak_force_n(run: RunUp, bearing: str) -> float:
    """Return the largest force across the axis."""
    force = run.bearing_force_n(bearing)
    return float(np.hypot(force[0], force[1]).max())


def _checked_bands(bands_hz: Sequence[tuple[float, float]]) -> FloatArray:
    bands = np.array(bands_hz, dtype=float).reshape(-1, 2)
    if not (np.isfinite(bands).all() and (bands[:, 0] >= 0).all() and (np.diff(bands) > 0).all()):
        raise AnalysisError(f"bands_hz is {bands.tolist()}; each needs 0 <= low < high")
    return bands


def _band_errors(
    response: NormalisedResponse, full: NormalisedResponse, bands_hz: FloatArray
) -> list[float]:
    """Return the relative difference from the full model in each band, root mean square."""
    errors = []
    for low, high in bands_hz:
        inside = (full.frequency_hz >= low) & (full.frequency_hz <= high)
        if not inside.any():
            raise AnalysisError(
                f"there is no response between {low:g} and {high:g} Hz; it goes from "
                f"{full.frequency_hz[0]:.4g} to {full.frequency_hz[-1]:.4g} Hz"
            )
        inside &= np.isfinite(full.ratio) & np.isfinite(response.ratio)
        if not inside.any():
            errors.append(np.nan)
            continue
        difference = response.ratio[inside] - full.ratio[inside]
        errors.append(float(np.sqrt(np.mean(difference**2) / np.mean(full.ratio[inside] ** 2))))
    return errors


def _kept_turn(element: Superelement, kept: IntArray) -> FloatArray | None:
    """Return the spin generator of some coordinates, None if a turn leaves them."""
    if element.spin_generator is None:
        return None
    dropped = np.setdiff1d(np.arange(element.size), kept)
    if np.abs(element.spin_generator[np.ix_(dropped, kept)]).max(initial=0.0) > _COUPLED:
        return None
    return np.asarray(element.spin_generator[np.ix_(kept, kept)])


def _check_bodies(assembled: AssembledSystem, bodies: Iterable[str]) -> None:
    rotors = assembled.system.rotors
    unknown = [name for name in bodies if name not in rotors]
    if unknown:
        raise AnalysisError(f"there are no bodies {unknown}; there are {list(rotors)}")
