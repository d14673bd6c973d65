"""Displacement and stress in the solid bodies in some states of the engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
)
from solidwhirl.analyses.kinds.recovery_states import (
    MOST_STATES,
    EngineState,
    RecoveryStateSpec,
    engine_states,
)
from solidwhirl.core.fields import (
    MOST,
    Name,
    alike_in_files,
)
from solidwhirl.core.outcome import Outcome, Write
from solidwhirl.files.vtk_files import Grid, write_pvd, write_vtu
from solidwhirl.rotordyn import AnalysisError, AssembledSystem, Invariant
from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement.invariants import compared

#: Makes the recovery of a body by its name (`reduction.recovery.stresses`).
Recoveries = Callable[[str], Any]
FOLDER = "recovery"
# [1e-9] on a coarse solid, [3e-12] on meridians, on springs from stiff to very soft
_ENERGY_LIMIT = 1e-8
# Where the superelement is a mean over turns of an uneven mesh, which the field is not.
_UNEVEN_LIMIT = 0.1
# Nearly rigid motion strains a body so little that rounding counts: this part of the energy that
# it would have at the lowest frequency of the held body is the least to compare an error with.
_SMALL = 1e-4
_CHECK = "strain energy of the recovered field"
# Points whose surroundings in θ are looked at for the largest value, and angles there.
_CANDIDATES, _ANGLES = 8, 720
# Values nearer to each other are one but for rounding.
_EQUAL = 1e-9


class RecoverySpec(Analysis):
    """Displacement and stress in the solid bodies in some states of the engine."""

    kind: Literal["recovery"]
    bodies: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST)]
    states: Annotated[tuple[RecoveryStateSpec, ...], Field(min_length=1, max_length=MOST_STATES)]
    quantities: Annotated[
        tuple[Literal["displacement", "stress"], ...], Field(min_length=1, max_length=2)
    ] = ("displacement", "stress")
    sectors: Annotated[int, Field(ge=8, le=360, strict=True)] = 32

    @model_validator(mode="after")
    def _different(self) -> RecoverySpec:
        for key in ("bodies", "quantities"):
            if len(set(getattr(self, key))) < len(getattr(self, key)):
                raise ValueError(f"{key} names something twice")
        labels = [state.label for state in self.states]
        alike = alike_in_files(list(dict.fromkeys(labels)))
        for label in labels:
            if labels.count(label) > 1 or (alike and label in alike):
                raise ValueError(f"more than one state is named {label!r}; give them names")
        return self

    @property
    def speeds_rpm(self) -> tuple[float, ...]:
        """Speeds of the reference shaft that the states name; the bases are made for them."""
        return tuple(s.speed_rpm for s in self.states if s.speed_rpm is not None)

    @property
    def refers_to(self) -> tuple[str, ...]:
        """Names of the analyses whose states are recovered."""
        named = [state.response or state.run_up for state in self.states]
        return tuple(dict.fromkeys(name for name in named if name is not None))

    def run(self, engine: Engine) -> Outcome:
        """Recover the states that are asked for; AnalysisError if one does not exist."""
        documents: list[dict[str, Any]] = []
        files: dict[str, Write] = {}
        checks: list[Invariant] = []
        for asked in self.states:
            instants: dict[str, list[tuple[float, str]]] = {}
            for state in engine_states(asked, engine.analyses, engine.system):
                bodies = {}
                for found in _bodies_of(self, engine.system, state, engine.recoveries):
                    bodies[found.body] = found.document
                    checks.append(_energy_check(self, found))
                    files |= _files(self, found, asked.phases)
                    if state.time_s is not None:
                        name = _path(self, found.body, state.label).rpartition("/")[2]
                        instants.setdefault(found.body, []).append((state.time_s, name))
                documents.append(_state_document(state, bodies))
            for body, series in instants.items():
                if len(series) > 1:
                    files[_path(self, body, asked.label, "pvd")] = partial(
                        _write, partial(write_pvd, series)
                    )
        return Outcome(
            kind=self.kind,
            document={"states": documents, "checks": [asdict(check) for check in checks]},
            files=files,
            headline=_headline(documents),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Recovered:
    """One body in one state: fields at the mesh and in space, and what results.json holds."""

    body: str
    state: EngineState
    space: Any
    document: dict[str, Any]
    energy_limit: float
    elastic_j: float


def _bodies_of(
    spec: RecoverySpec, system: AssembledSystem, state: EngineState, recoveries: Recoveries
) -> Iterator[_Recovered]:
    """All bodies in one state; a mode gets its amplitude here, the same for all of them."""
    makers = {name: recoveries(name) for name in spec.bodies}
    motions = {name: body_rows(system, name) @ state.motion for name in spec.bodies}
    speeds = {n: system.system.rotors[n].speed_ratio * state.speed_rad_s for n in spec.bodies}
    factor = 1.0
    if state.scaled_to_m is not None:
        largest = max(
            _largest_displacement(makers[n].recover(q, 0.0), spec.sectors)[0]
            for n, q in motions.items()
        )
        if not largest > 0.0:
            raise AnalysisError(f"state {state.label!r} does not move {', '.join(spec.bodies)}")
        factor = state.scaled_to_m / largest
    for name, motion in motions.items():
        yield _recovered(spec, system, state, name, makers[name], factor * motion, speeds[name])


def _recovered(
    spec: RecoverySpec,
    system: AssembledSystem,
    state: EngineState,
    name: str,
    maker: Any,
    motion: NDArray[Any],
    speed_rad_s: float,
) -> _Recovered:
    from solidwhirl.reduction.recovery.spatial_fields import in_space

    found = maker.recover(motion, speed_rad_s)
    element = system.system.rotors[name].element
    energy = float(0.5 * np.real(motion.conj() @ element.stiffness @ motion))
    kinetic = float(0.5 * np.real(motion.conj() @ element.mass @ motion))
    own = element.fixed_interface_frequencies_hz
    lowest = 2.0 * np.pi * float(own[own > 0.0].min(initial=np.inf))
    largest, at = _largest_displacement(found, spec.sectors)
    document: dict[str, Any] = {
        "speed_rpm": speed_rad_s * RPM_PER_RAD_S,
        "largest_displacement_m": largest,
        "largest_displacement_at_m": at,
        "strain_energy_j": energy,
        "strain_energy_of_field_j": found.strain_energy_j,
    }
    if "stress" in spec.quantities:
        document |= _stresses(found, maker.material_names, state.has_size)
    return _Recovered(
        body=name,
        state=state,
        space=in_space(found, spec.sectors),
        document=document,
        elastic_j=kinetic * lowest**2 if np.isfinite(lowest) else 0.0,
        energy_limit=_UNEVEN_LIMIT if maker.is_averaged else _ENERGY_LIMIT,
    )


def _largest_displacement(found: Any, sectors: int) -> tuple[float, list[float]]:
    """Largest displacement over the cycle [m] and its place."""
    from solidwhirl.reduction.recovery.spatial_fields import in_space

    space = in_space(found, sectors)
    size = cycle_length(space.displacement_m)
    at = int(size.argmax())
    return float(size[at]), space.points_m[at].tolist()


def cycle_length(vectors: NDArray[Any]) -> NDArray[np.float64]:
    """Return the largest length of Re(u e^{iφ}) over the phase, of real vectors their length.

    Parameters
    ----------
    vectors
        (p, 3).
    """
    square = (np.abs(vectors) ** 2).sum(axis=1)
    if not np.iscomplexobj(vectors):
        return np.asarray(np.sqrt(square))
    return np.asarray(np.sqrt(0.5 * (square + np.abs((vectors**2).sum(axis=1)))))


def _stresses(found: Any, materials: tuple[str, ...], has_size: bool) -> dict[str, Any]:
    """Largest von Mises stresses of the state, of the centrifugal load, and of both."""
    steady = () if found.steady is None else (found.steady,)
    out: dict[str, Any] = {
        "dynamic": _largest_stress(found, found.terms, (), materials),
        "steady": _largest_stress(found, (), steady, materials) if steady else None,
        "total": None,
    }
    if steady and has_size:
        out["total"] = _largest_stress(found, found.terms, steady, materials)
    return out


def _largest_stress(
    found: Any, terms: tuple[Any, ...], steady: tuple[Any, ...], materials: tuple[str, ...]
) -> dict[str, Any]:
    """Largest von Mises stress over the solid and the cycle; in θ it is sought finely."""
    from solidwhirl.reduction.recovery.spatial_fields import values_at
    from solidwhirl.reduction.recovery.stress_measures import peak_von_mises, principal_range

    points = found.points
    flat = points.points_m.shape[1] == 2
    coarse = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    theta = coarse if flat else np.pi * np.arange(points.copies)

    def peaks(kept: NDArray[np.int64], angles: NDArray[np.float64]) -> Any:
        moving = values_at(terms, points, angles, kept)[1].reshape(-1, 6)
        rest = values_at(steady, points, angles, kept)[1].reshape(-1, 6) if steady else None
        return peak_von_mises(moving, rest)[0].reshape(len(angles), -1), moving, rest

    everywhere = np.arange(len(points.points_m))
    stress, _, _ = peaks(everywhere, theta)
    if flat:
        kept = np.argsort(stress.max(axis=0))[-_CANDIDATES:]
        theta = np.linspace(0.0, 2.0 * np.pi, _ANGLES, endpoint=False)
    else:
        kept = np.unique(np.argsort(stress.max(axis=0))[-_CANDIDATES:])
    stress, moving, rest = peaks(kept, theta)
    # the first of equals: at θ = 0 where all angles are the same
    highest_of = int((stress >= (1.0 - _EQUAL) * stress.max()).ravel().argmax())
    j, k = np.unravel_index(highest_of, stress.shape)
    row = slice(int(j) * len(kept) + int(k), int(j) * len(kept) + int(k) + 1)
    highest, lowest = principal_range(moving[row], None if rest is None else rest[row])
    node, angle = int(kept[k]), float(theta[j])
    return {
        "largest_von_mises_pa": float(stress[j, k]),
        "at_m": _place(points.points_m[node], angle),
        "material": materials[points.point_material[node]],
        "largest_principal_pa": float(highest[0]),
        "smallest_principal_pa": float(lowest[0]),
    }


def _place(point: NDArray[np.float64], theta: float) -> list[float]:
    """Place in space of a point of a meridian at θ, or of a solid after a half turn or none."""
    if len(point) == 2:
        z, r = point
        return [float(r * np.cos(theta)), float(r * np.sin(theta)), float(z)]
    sign = -1.0 if theta > 0.0 else 1.0
    return (point * [sign, sign, 1.0]).tolist()  # type: ignore[no-any-return]


def _energy_check(spec: RecoverySpec, found: _Recovered) -> Invariant:
    """½ ∫ σ:ε of the field against ½ qᴴ K q, relative."""
    field, known = (found.document[key] for key in ("strain_energy_of_field_j", "strain_energy_j"))
    error = abs(field - known) / max(abs(known), abs(field), _SMALL * found.elastic_j, 1e-300)
    found.document["strain_energy_error"] = error
    return compared(
        _CHECK,
        f"{spec.label}, {found.state.label}, {found.body}",
        error,
        found.energy_limit,
        "the recovered displacement and stress",
    )


def _state_document(state: EngineState, bodies: dict[str, Any]) -> dict[str, Any]:
    return {
        "state": state.label,
        "source": state.source,
        "speed_rpm": state.speed_rad_s * RPM_PER_RAD_S,
        **state.facts,
        "scaled_to_m": state.scaled_to_m,
        "bodies": bodies,
    }


def _headline(documents: list[dict[str, Any]]) -> str:
    parts = []
    for state in documents:
        for name, body in state["bodies"].items():
            text = f"{state['state']}: {name} {body['largest_displacement_m']:.3g} m"
            stress = body.get("total") or body.get("dynamic")
            if stress is not None:
                text += f", {stress['largest_von_mises_pa'] / 1e6:.4g} MPa"
            parts.append(text)
    return "; ".join(parts[:4]) + ("; ..." if len(parts) > 4 else "")


def _files(spec: RecoverySpec, found: _Recovered, phases: int) -> dict[str, Write]:
    """The state itself, and where asked the frames of one period."""
    stressed = "stress" in spec.quantities
    files: dict[str, Write] = {
        _path(spec, found.body, found.state.label): partial(
            _write, partial(_write_state, found, stressed)
        )
    }
    if not phases or not np.iscomplexobj(found.space.displacement_m):
        return files
    series = []
    for k in range(phases):
        name = _path(spec, found.body, f"{found.state.label}_{k:03d}")
        series.append((k / phases, name.rpartition("/")[2]))
        frame = partial(_write_frame, found, stressed, 2.0 * np.pi * k / phases)
        files[name] = partial(_write, frame)
    series_file = _path(spec, found.body, found.state.label, "pvd")
    files[series_file] = partial(_write, partial(write_pvd, series))
    return files


def _path(spec: RecoverySpec, body: str, state: str, ending: str = "vtu") -> str:
    """File of a state in the folder of a run, which has one level of folders."""
    return f"{FOLDER}/{spec.label}_{body}_{state}.{ending}"


def _write(write: Write, path: Path) -> None:
    """Write a file whose folder may not be there yet."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write(path)


def _single(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.asarray(values, dtype=np.float32)


def _write_state(found: _Recovered, stressed: bool, path: Path) -> None:
    from solidwhirl.reduction.recovery.stress_measures import (
        peak_von_mises,
        principal_range,
        von_mises,
    )

    space, state = found.space, found.state
    moved, stress = space.displacement_m, space.stress_pa
    vibrates = np.iscomplexobj(moved)
    fields: dict[str, Any] = {}
    if vibrates:
        # Re(u e^{iφ}) at φ = 0 and 90°; every other phase is cos φ times the first plus sin φ
        # times the second
        fields["displacement_0deg"] = moved.real
        fields["displacement_90deg"] = -moved.imag
    else:
        fields["displacement"] = moved
    if space.steady_displacement_m is not None:
        fields["displacement_steady"] = space.steady_displacement_m
    if stressed:
        for angle, turn in ((0, 1.0), (90, 1j)) if vibrates else (("", 1.0),):
            name = f"stress_{angle}deg" if vibrates else "stress"
            fields[name] = (stress * turn).real
        steady = space.steady_stress_pa
        fields["von_mises_dynamic"] = peak_von_mises(stress)[0]
        if steady is not None:
            fields["stress_steady"] = steady
            fields["von_mises_steady"] = von_mises(steady)
        if steady is not None and state.has_size:
            fields["von_mises_total"] = peak_von_mises(stress, steady)[0]
        both = steady if state.has_size else None
        fields["principal_largest"], fields["principal_smallest"] = principal_range(stress, both)
    _write_grid(found, fields, path)


def _write_frame(found: _Recovered, stressed: bool, phase: float, path: Path) -> None:
    from solidwhirl.reduction.recovery.stress_measures import von_mises

    space, state = found.space, found.state
    turn = np.exp(1j * phase)
    fields = {"displacement": (space.displacement_m * turn).real}
    if stressed:
        now = (space.stress_pa * turn).real
        fields["von_mises_dynamic"] = von_mises(now)
        if space.steady_stress_pa is not None and state.has_size:
            fields["von_mises_total"] = von_mises(now + space.steady_stress_pa)
    _write_grid(found, fields, path)


def _write_grid(found: _Recovered, fields: Mapping[str, Any], path: Path) -> None:
    state, space = found.state, found.space
    numbers = {"speed_rpm": found.document["speed_rpm"]}
    numbers |= {k: v for k, v in state.facts.items() if isinstance(v, float)}
    grid = Grid(
        points_m=space.points_m,
        cells=space.cells,
        point_data={
            **{name: _single(values) for name, values in fields.items()},
            "material": space.material.astype(np.int32),
        },
        field_data={name: np.array([value]) for name, value in numbers.items()},
    )
    write_vtu(grid, path)
