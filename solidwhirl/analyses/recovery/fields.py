"""Fields of a solid body in a state: largest displacement and stress, and files of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solidwhirl.analyses.recovery.states import EngineState
from solidwhirl.core.outcome import Write
from solidwhirl.files.vtk_files import Grid, write_pvd, write_vtu
from solidwhirl.rotordyn import AnalysisError, AssembledSystem, Superelement
from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement.surface import angles

#: Makes the recovery of a body by its name (`reduction.recovery.stresses`).
Recoveries = Callable[[str], Any]
FOLDER = "recovery"
# [1e-9] on a coarse solid, [3e-12] on meridians, on springs from stiff to very soft
_ENERGY_LIMIT = 1e-8
# Where the superelement is a mean over turns of an anisotropic mesh, which the field is not.
_UNEVEN_LIMIT = 0.1
# Angles at which a meridian is looked at, points whose surroundings in θ are looked at for the
# largest value, and angles there.
_COARSE, _CANDIDATES, _ANGLES = 24, 8, 720
# Points whose fields are made at once.
_AT_ONCE = 100_000
# The superelement has no energy of steady spin to compare with.
_NO_ENERGIES = dict.fromkeys(("strain_energy_j", "strain_energy_of_field_j", "strain_energy_error"))
# Values nearer to each other are one but for rounding.
_EQUAL = 1e-9


class Asked(NamedTuple):
    """What is asked of every state: label of the analysis, bodies, stress, points around."""

    label: str
    bodies: tuple[str, ...]
    stressed: bool
    sectors: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Recovered:
    """One body in one state: fields at the mesh and in space, and what results.json holds."""

    body: str
    state: EngineState
    #: At the mesh, see `reduction.recovery.stresses`
    fields: Any
    sectors: int
    document: dict[str, Any]
    energy_limit: float
    elastic_j: float

    def in_space(self) -> Any:
        """Fields in space, which take more memory than all else."""
        from solidwhirl.reduction.recovery.spatial_fields import in_space

        return in_space(self.fields, self.sectors)


def bodies_of(
    asked: Asked, system: AssembledSystem, state: EngineState, recoveries: Recoveries
) -> Iterator[Recovered]:
    """All bodies in one state; a mode gets its amplitude here, the same for all of them."""
    makers = {name: recoveries(name) for name in asked.bodies}
    motions = {name: body_rows(system, name) @ state.motion for name in asked.bodies}
    speeds = {n: system.system.rotors[n].speed_ratio * state.speed_rad_s for n in asked.bodies}
    factor = 1.0
    if state.scaled_to_m is not None:
        largest = max(
            _largest_displacement(found.points, found.terms, asked.sectors)[0]
            for found in (makers[n].recover(q, 0.0) for n, q in motions.items())
        )
        if not largest > 0.0:
            raise AnalysisError(f"state {state.label!r} does not move {', '.join(asked.bodies)}")
        factor = state.scaled_to_m / largest
    for name, motion in motions.items():
        yield _recovered(asked, system, state, name, makers[name], factor * motion, speeds[name])


def _recovered(
    asked: Asked,
    system: AssembledSystem,
    state: EngineState,
    name: str,
    maker: Any,
    motion: NDArray[Any],
    speed_rad_s: float,
) -> Recovered:
    found = maker.recover(motion, speed_rad_s)
    if state.is_spin and found.steady is None:
        raise AnalysisError(f"state {state.label!r}: body {name!r} has no centrifugal field")
    shown = (found.steady,) if state.is_spin else found.terms
    largest, at = _largest_displacement(found.points, shown, asked.sectors)
    document: dict[str, Any] = {
        "speed_rpm": speed_rad_s * RPM_PER_RAD_S,
        "largest_displacement_m": largest,
        "largest_displacement_at_m": at,
    }
    element = system.system.rotors[name].element
    document |= _NO_ENERGIES if state.is_spin else _energies(element, motion, found)
    if asked.stressed:
        document |= _stresses(found, maker.material_names, state)
    kinetic = float(0.5 * np.real(motion.conj() @ element.mass @ motion))
    own = element.fixed_interface_frequencies_hz
    lowest = 2.0 * np.pi * float(own[own > 0.0].min(initial=np.inf))
    return Recovered(
        body=name,
        state=state,
        fields=found,
        sectors=asked.sectors,
        document=document,
        elastic_j=kinetic * lowest**2 if np.isfinite(lowest) else 0.0,
        energy_limit=_UNEVEN_LIMIT if maker.is_averaged else _ENERGY_LIMIT,
    )


def _energies(element: Superelement, motion: NDArray[Any], found: Any) -> dict[str, float]:
    energy = float(0.5 * np.real(motion.conj() @ element.stiffness @ motion))
    return {"strain_energy_j": energy, "strain_energy_of_field_j": found.strain_energy_j}


def _largest_displacement(
    points: Any, terms: Sequence[Any], sectors: int
) -> tuple[float, list[float]]:
    """Largest displacement over the cycle [m] and its place."""
    from solidwhirl.reduction.recovery.spatial_fields import places, values_at

    theta = points.theta_rad(sectors)
    size = np.concatenate(
        [
            cycle_length(values_at(terms, points, some)[0].reshape(-1, 3))
            for some in _in_parts(theta, len(points.points_m))
        ]
    )
    j, node = divmod(int(size.argmax()), len(points.points_m))
    at = places(points.points_m[node : node + 1], theta[j : j + 1])[0, 0]
    return float(size.max()), at.tolist()


def _in_parts(theta: NDArray[np.float64], points: int) -> list[NDArray[np.float64]]:
    """Angles in parts that do not take much memory."""
    return np.array_split(theta, min(len(theta), 1 + len(theta) * points // _AT_ONCE))


def cycle_length(vectors: NDArray[Any]) -> NDArray[np.float64]:
    """Return the largest length of Re(u e^{iφ}) over the phase, of real vectors their length.

    `vectors`: (p, 3).
    """
    square = (np.abs(vectors) ** 2).sum(axis=1)
    if not np.iscomplexobj(vectors):
        return np.asarray(np.sqrt(square))
    return np.asarray(np.sqrt(0.5 * (square + np.abs((vectors**2).sum(axis=1)))))


def _stresses(found: Any, materials: tuple[str, ...], state: EngineState) -> dict[str, Any]:
    """Largest von Mises stresses of the state, of the centrifugal load, and of both."""

    def largest(terms: tuple[Any, ...], steady: tuple[Any, ...]) -> dict[str, Any]:
        return _largest_stress(found, terms, steady, materials)

    steady = () if found.steady is None else (found.steady,)
    moves = not state.is_spin
    return {
        "dynamic": largest(found.terms, ()) if moves else None,
        "steady": largest((), steady) if steady else None,
        "total": largest(found.terms, steady) if steady and moves and state.has_size else None,
    }


def _largest_stress(
    found: Any, terms: tuple[Any, ...], steady: tuple[Any, ...], materials: tuple[str, ...]
) -> dict[str, Any]:
    """Largest von Mises stress over the solid and the cycle; on a meridian θ is sought finely."""
    from solidwhirl.reduction.recovery.spatial_fields import places, values_at
    from solidwhirl.reduction.recovery.stress_measures import peak_von_mises, principal_range

    points = found.points
    theta = points.theta_rad(_COARSE)

    def stresses(kept: NDArray[np.int64], theta: NDArray[np.float64]) -> Any:
        moving = values_at(terms, points, theta, kept)[1].reshape(-1, 6)
        rest = values_at(steady, points, theta, kept)[1].reshape(-1, 6) if steady else None
        return moving, rest

    def peaks(kept: NDArray[np.int64], theta: NDArray[np.float64]) -> NDArray[np.float64]:
        parts = _in_parts(theta, len(kept))
        found = [peak_von_mises(*stresses(kept, some))[0] for some in parts]
        return np.concatenate(found).reshape(len(theta), -1)

    kept = np.arange(len(points.points_m))
    stress = peaks(kept, theta)
    sector = None if points.copies == 1 else 0
    if sector is None and len(theta) > 1:
        kept = np.argsort(stress.max(axis=0))[-_CANDIDATES:]
        theta = angles(_ANGLES)
        stress = peaks(kept, theta)
    # the first of equals: at θ = 0 where all angles are the same
    highest_of = int((stress >= (1.0 - _EQUAL) * stress.max()).ravel().argmax())
    j, k = np.unravel_index(highest_of, stress.shape)
    node = kept[k : k + 1]
    highest, lowest = principal_range(*stresses(node, theta[j : j + 1]))
    return {
        "largest_von_mises_pa": float(stress[j, k]),
        "at_m": places(points.points_m[node], theta[j : j + 1])[0, 0].tolist(),
        "sector": None if sector is None else int(j),
        "material": materials[points.point_material[node[0]]],
        "largest_principal_pa": float(highest[0]),
        "smallest_principal_pa": float(lowest[0]),
    }


def state_files(asked: Asked, found: Recovered, phases: int) -> dict[str, Write]:
    """The state itself, and where asked the frames of one period."""
    files: dict[str, Write] = {
        path_of(asked.label, found.body, found.state.label): partial(
            written, partial(_write_state, found, asked.stressed)
        )
    }
    if not phases or not any(np.iscomplexobj(t.displacement_m) for t in found.fields.terms):
        return files
    series = []
    for k in range(phases):
        name = path_of(asked.label, found.body, f"{found.state.label}_{k:03d}")
        series.append((k / phases, name.rpartition("/")[2]))
        frame = partial(_write_frame, found, asked.stressed, 2.0 * np.pi * k / phases)
        files[name] = partial(written, frame)
    series_file = path_of(asked.label, found.body, found.state.label, "pvd")
    files[series_file] = partial(written, partial(write_pvd, series))
    return files


def path_of(analysis: str, body: str, state: str, ending: str = "vtu") -> str:
    """File of a state in the folder of a run, which has one level of folders."""
    return f"{FOLDER}/{analysis}_{body}_{state}.{ending}"


def written(write: Write, path: Path) -> None:
    """Write a file whose folder may not be there yet."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write(path)


def _write_state(found: Recovered, stressed: bool, path: Path) -> None:
    from solidwhirl.reduction.recovery.stress_measures import (
        peak_von_mises,
        principal_range,
        von_mises,
    )

    space, state = found.in_space(), found.state
    steady = space.steady_stress_pa if stressed else None
    fields: dict[str, Any] = {}
    if not state.is_spin:
        fields |= _at_phases("displacement", space.displacement_m)
    if space.steady_displacement_m is not None:
        fields["displacement_steady"] = space.steady_displacement_m
    if stressed and not state.is_spin:
        fields |= _at_phases("stress", space.stress_pa)
        fields["von_mises_dynamic"] = peak_von_mises(space.stress_pa)[0]
    if steady is not None:
        fields["stress_steady"] = steady
        fields["von_mises_steady"] = von_mises(steady)
    if steady is not None and not state.is_spin and state.has_size:
        fields["von_mises_total"] = peak_von_mises(space.stress_pa, steady)[0]
    if stressed:
        both = steady if state.has_size else None
        names = ("principal_largest", "principal_smallest")
        fields |= dict(zip(names, principal_range(space.stress_pa, both), strict=True))
    _write_grid(found, space, fields, path)


def _at_phases(name: str, values: NDArray[Any]) -> dict[str, Any]:
    """Re(a e^{iφ}) at φ = 0 and 90° of a vibration; of an instant the values themselves.

    Every other phase is cos φ times the first plus sin φ times the second.
    """
    if not np.iscomplexobj(values):
        return {name: values}
    return {f"{name}_0deg": values.real, f"{name}_90deg": -values.imag}


def _write_frame(found: Recovered, stressed: bool, phase: float, path: Path) -> None:
    from solidwhirl.reduction.recovery.stress_measures import von_mises

    space, state = found.in_space(), found.state
    turn = np.exp(1j * phase)
    fields = {"displacement": (space.displacement_m * turn).real}
    if stressed:
        now = (space.stress_pa * turn).real
        fields["von_mises_dynamic"] = von_mises(now)
        if space.steady_stress_pa is not None and state.has_size:
            fields["von_mises_total"] = von_mises(now + space.steady_stress_pa)
    _write_grid(found, space, fields, path)


def _write_grid(found: Recovered, space: Any, fields: Mapping[str, Any], path: Path) -> None:
    numbers = {"speed_rpm": found.document["speed_rpm"]}
    numbers |= {k: v for k, v in found.state.facts.items() if isinstance(v, float)}
    grid = Grid(
        points_m=space.points_m,
        cells=space.cells,
        point_data={
            **{name: np.asarray(values, np.float32) for name, values in fields.items()},
            "material": space.material.astype(np.int32),
        },
        field_data={name: np.array([value]) for name, value in numbers.items()},
    )
    write_vtu(grid, path)
