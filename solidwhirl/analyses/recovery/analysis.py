"""Displacement and stress in the solid bodies in some states of the engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from solidwhirl.analyses.base import Analysis, Engine, Found, Scalars
from solidwhirl.analyses.recovery.records import MOST_STATES, RecoveryStateSpec
from solidwhirl.core.blocks import AnalysisBlock, CutBodies, Table, numbers
from solidwhirl.core.fields import MOST, Name, alike_in_files
from solidwhirl.core.outcome import Outcome, PageSection, Write
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Look

if TYPE_CHECKING:
    from solidwhirl.analyses.recovery.fields import Recovered
    from solidwhirl.analyses.recovery.states import EngineState
    from solidwhirl.rotordyn import Invariant

Document = Mapping[str, Any]
# Nearly rigid motion strains a body so little that rounding counts: this part of the energy that
# it would have at the lowest frequency of the held body is the least to compare an error with.
_SMALL = 1e-4
_CHECK = "strain energy of the recovered field"
_MPA = 1e-6
# States of bodies that a page shows in space.
_MOST_SHOWN = 6
# Loads of a stress, what they are called, and their colour.
_LOADS = (
    ("dynamic", "of the state", "@c5"),
    ("steady", "centrifugal", "@c7"),
    ("total", "both together", "@c3"),
)


class RecoverySpec(Analysis):
    """Displacement and stress in the solid bodies in some states of the engine."""

    section = PageSection(
        "recovery",
        "Stress and displacement in the bodies",
        "Fields in the solid bodies in steady spin, modes, responses and instants of run-ups.",
        110,
    )
    suffixes = ()

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
        from solidwhirl.analyses.recovery.fields import (
            Asked,
            bodies_of,
            path_of,
            state_files,
            written,
        )
        from solidwhirl.analyses.recovery.states import engine_states
        from solidwhirl.files.vtk_files import write_pvd

        wanted = Asked(self.label, self.bodies, "stress" in self.quantities, self.sectors)
        documents: list[dict[str, Any]] = []
        files: dict[str, Write] = {}
        checks: list[Invariant] = []
        for asked in self.states:
            instants: dict[str, list[tuple[float, str]]] = {}
            for state in engine_states(asked, engine.analyses, engine.system):
                bodies = {}
                for found in bodies_of(wanted, engine.system, state, engine.recoveries):
                    bodies[found.body] = found.document
                    if not state.is_spin:
                        checks.append(_energy_check(self.label, found))
                    files |= state_files(wanted, found, asked.phases)
                    if state.time_s is not None:
                        name = path_of(self.label, found.body, state.label).rpartition("/")[2]
                        instants.setdefault(found.body, []).append((state.time_s, name))
                documents.append(_state_document(state, bodies))
            for body, series in instants.items():
                if len(series) > 1:
                    files[path_of(self.label, body, asked.label, "pvd")] = partial(
                        written, partial(write_pvd, series)
                    )
        return Outcome(
            kind=self.kind,
            document={"states": documents, "checks": [asdict(check) for check in checks]},
            files=files,
            headline=_headline(documents),
        )

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """Largest stresses, states and files for ParaView."""
        states = found.document["states"]
        blocks: list[AnalysisBlock] = []
        if any(b.get(load) for s in states for b in s["bodies"].values() for load, *_ in _LOADS):
            blocks += [stress_chart(states), _stress_table(states)]
        blocks += _cut_bodies(found, states)
        blocks.append(_state_table(states))
        files = [f for f in sorted(found.outcome.files) if f.endswith((".vtu", ".pvd"))]
        if files:
            title = f"Fields as files for ParaView ({len(files)})"
            blocks.append(Table(head=["file"], rows=[[f"`{f}`"] for f in files], folded=title))
        return blocks

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> Scalars:
        """Yield the largest displacement and stresses of each body in each state."""
        for state in document["states"]:
            for body, found in state["bodies"].items():
                where = f"{state['state']}.{body}"
                yield f"{where}.largest_displacement_m", found.get("largest_displacement_m")
                for part, *_ in _LOADS:
                    stress = found.get(part) or {}
                    yield f"{where}.{part}_largest_von_mises_pa", stress.get("largest_von_mises_pa")


def _energy_check(label: str, found: Recovered) -> Invariant:
    """½ ∫ σ:ε of the field against ½ qᴴ K q, relative."""
    from solidwhirl.rotordyn.superelement.invariants import compared

    field, known = (found.document[key] for key in ("strain_energy_of_field_j", "strain_energy_j"))
    scale = max(abs(known), abs(field), _SMALL * found.elastic_j, 1e-300)
    error = abs(field - known) / scale
    found.document["strain_energy_error"] = error
    return compared(
        _CHECK,
        f"{label}, {found.state.label}, {found.body}",
        error,
        found.energy_limit + found.fields.rounding_j / scale,
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
            stress = body.get("total") or body.get("dynamic") or body.get("steady")
            if stress is not None:
                text += f", {stress['largest_von_mises_pa'] / 1e6:.4g} MPa"
            parts.append(text)
    return "; ".join(parts[:4]) + ("; ..." if len(parts) > 4 else "")


def _per_body(states: Sequence[Document]) -> list[tuple[Document, str, Document]]:
    return [(state, *own) for state in states for own in state["bodies"].items()]


def stress_chart(states: Sequence[Document]) -> Chart:
    """Return the largest von Mises stresses as bars."""
    rows = _per_body(states)
    bars = []
    for load, text, color in _LOADS:
        found = [body.get(load) for _, _, body in rows]
        if any(found):
            values = numbers([None if f is None else f["largest_von_mises_pa"] for f in found])
            texts = ["" if f is None else _where(f) for f in found]
            bars.append(Bars(values=_MPA * values, name=text, look=Look(color), texts=texts))
    return Chart(
        name="stress",
        title="Largest von Mises stress",
        caption="Over the body and the cycle: of the state alone, of the centrifugal load at its "
        "speed, and of both together. A mode without a given amplitude is scaled to 1 mm, so its "
        "stress is no stress of the engine and has no sum. At re-entrant corners without fillet it "
        "grows without limit as the mesh becomes finer.",
        alt="Bars of the largest von Mises stress of each state; the table has the numbers.",
        x=Axis(label="state and body", places=[f"{s['state']}, {body}" for s, body, _ in rows]),
        y=Axis(label="von Mises stress", unit="MPa"),
        parts=bars,
    )


def _cut_bodies(found: Found, states: Sequence[Document]) -> list[CutBodies]:
    """The first states in space, from their files."""
    from solidwhirl.analyses.recovery.fields import path_of
    from solidwhirl.files.cut_fields import cut_body

    files = found.outcome.files
    rows = [
        (write, state["state"], name)
        for state, name, _ in _per_body(states)
        if (write := files.get(path_of(found.name, name, state["state"]))) is not None
    ]
    if not rows:
        return []
    bodies = [cut_body(*row) for row in rows[:_MOST_SHOWN]]
    more = f" The first {_MOST_SHOWN} of {len(rows)} are shown." if len(rows) > _MOST_SHOWN else ""
    shown = CutBodies(
        name="cut-bodies",
        title="In the bodies",
        caption="Half of a body, cut open along its axis, not deformed; the axis is z. Drag to "
        f"turn, roll to come nearer.{more}",
        alt="; ".join(f"{b.label}: {b.quantity} up to {b.largest:.4g} {b.unit}" for b in bodies),
        bodies=bodies,
    )
    return [shown]


def _where(found: Document) -> str:
    x, y, z = (1e3 * v for v in found["at_m"])
    return f"at x {x:.1f}, y {y:.1f}, z {z:.1f} mm, {found['material']}"


def _stress_table(states: Sequence[Document]) -> Table:
    rows = [
        [
            state["state"],
            body,
            text,
            _MPA * own["largest_von_mises_pa"],
            _where(own),
            _MPA * own["largest_principal_pa"],
            _MPA * own["smallest_principal_pa"],
        ]
        for state, body, found in _per_body(states)
        for load, text, _ in _LOADS
        if (own := found.get(load)) is not None
    ]
    return Table(
        head=[
            *("state", "body", "load", "von Mises [MPa]", "where"),
            *("largest principal [MPa]", "smallest principal [MPa]"),
        ],
        rows=rows,
        folded=f"Stresses in numbers ({len(rows)})",
    )


def _state_table(states: Sequence[Document]) -> Table:
    rows = []
    for state, body, found in _per_body(states):
        hertz, instant = state.get("frequency_hz"), state.get("time_s")
        rows.append(
            [
                state["state"],
                state["source"].replace("_", "-"),
                f"{state['speed_rpm']:.1f}",
                None if hertz is None else f"{hertz:.5g}",
                None if instant is None else f"{instant:.4g}",
                body,
                1e6 * found["largest_displacement_m"],
                found["strain_energy_j"],
                found["strain_energy_error"],
            ]
        )
    return Table(
        title="States",
        head=[
            *("state", "from", "reference shaft [rpm]", "frequency [Hz]", "time [s]", "body"),
            *("largest displacement [µm]", "strain energy [J]", "error of the field's energy [1]"),
        ],
        rows=rows,
        caption="The energy of the recovered field is compared with that of the reduced body.",
    )
