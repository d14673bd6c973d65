"""Sag, bearing loads and slopes under weight, given forces and the torques of gears."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, numbers
from solidwhirl.core.fields import MOST, Finite, Name, NotNegative, Place, Record
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem, Bearing, End, FrequencyTableLaw, TableLaw
from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes, note_lines
from solidwhirl.rotordyn.asymmetric import standing_at
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.estimates.static_errors import static_errors
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.static import Arrow, LoadedLine, LoadedState, static_chart
from solidwhirl.rotordyn.response.static import (
    DOWN,
    STANDARD_GRAVITY,
    PointLoad,
    StaticResponse,
    static_response,
)
from solidwhirl.rotordyn.superelement.validation import MOTIONS

Vector = tuple[Finite, Finite, Finite]
_ZERO = (0.0, 0.0, 0.0)
# Loads and motions below this fraction of the largest have no direction.
_ROUNDING = 1e-9
# Loads that differ by less are told as one.
_SAME_LOAD = 1e-6


class StaticForceSpec(Record):
    """A constant force and moment on an interface."""

    at: Place
    force_n: Vector = _ZERO
    moment_n_m: Vector = _ZERO

    @model_validator(mode="after")
    def _some(self) -> StaticForceSpec:
        if not any((*self.force_n, *self.moment_n_m)):
            raise ValueError("has neither force_n nor moment_n_m")
        return self

    @property
    def motions(self) -> tuple[str, ...]:
        """Motions, "ux" to "rz", that it pushes along."""
        return tuple(
            m for m, v in zip(MOTIONS, (*self.force_n, *self.moment_n_m), strict=True) if v
        )


class GearTorqueSpec(Record):
    """A torque that a gear of the scene transmits."""

    gear: Name
    torque_n_m: Finite


class StaticSpec(base.Analysis):
    """Sag of the shafts and loads of the bearings under weight, forces and torques of gears."""

    section = PageSection(
        "static",
        "Static loads",
        "Deflection and bearing loads under weight and other constant loads.",
        40,
    )

    of_bodies = "any"

    kind: Literal["static"]
    gravity_m_per_s2: Vector = DOWN
    speeds_rpm: Annotated[
        tuple[NotNegative, ...], Field(min_length=1, max_length=base.MOST_SPEEDS)
    ] = (0.0,)
    angles_deg: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=base.MOST_SPEEDS)] = (
        0.0,
    )
    forces: Annotated[tuple[StaticForceSpec, ...], Field(max_length=MOST)] = ()
    gears: Annotated[tuple[GearTorqueSpec, ...], Field(max_length=MOST)] = ()

    @model_validator(mode="after")
    def _loaded(self) -> StaticSpec:
        if not (any(self.gravity_m_per_s2) or self.forces or self.gears):
            raise ValueError("gravity_m_per_s2 is zero, and there are no forces and no gears")
        for key in ("speeds_rpm", "angles_deg"):
            if len(set(getattr(self, key))) < len(getattr(self, key)):
                raise ValueError(f"{key} has a value twice")
        names = [one.gear for one in self.gears]
        if len(set(names)) < len(names):
            raise ValueError("gears names a gear twice")
        return self

    def work(self, size: EngineSize) -> Work:
        """A solution at each speed, of the engine as it stands."""
        speeds = len(self.speeds_rpm) * len(self.angles_deg)
        return Work(solves=float(speeds), results=2.0 * speeds)

    @property
    def points(self) -> tuple[PointLoad, ...]:
        """Given forces and moments."""
        return tuple(
            PointLoad(at=end_of(f.at), force_n=f.force_n, moment_n_m=f.moment_n_m)
            for f in self.forces
        )

    def response(self, system: AssembledSystem, speed_rad_s: float) -> StaticResponse:
        """Return the response of a system to the loads at a speed of the reference shaft."""
        torques = {one.gear: one.torque_n_m for one in self.gears}
        return static_response(system, self.gravity_m_per_s2, self.points, torques, speed_rad_s)

    def run(self, engine: base.Engine) -> Outcome:
        """Static response at each speed, or each angle of asymmetric bodies."""
        documents = []
        for state, system in self._states(engine):
            found = self.response(system, state["speed_rpm"] * RAD_S_PER_RPM)
            errors = static_errors(system, self.gravity_m_per_s2, found)
            documents.append(
                {
                    **state,
                    **_response_document(system, found),
                    "error_estimate": None if errors.bodies_without_estimate else errors.total,
                    "error_parts": dict(errors.parts),
                    "bodies_without_estimate": list(errors.bodies_without_estimate),
                }
            )
        ends = np.array([min(self.speeds_rpm), max(self.speeds_rpm)]) * RAD_S_PER_RPM
        return Outcome(
            kind=self.kind,
            document={
                "gravity_m_per_s2": list(self.gravity_m_per_s2),
                "forces": [force.model_dump() for force in self.forces],
                "gears": [gear.model_dump() for gear in self.gears],
                "speeds": documents,
                "law_loads": _law_loads(engine.system),
                "notes": list(note_lines(bearing_notes(engine.system, ends))),
            },
            headline=_headline(documents),
        )

    def _states(self, engine: base.Engine) -> Iterator[tuple[dict[str, float], AssembledSystem]]:
        """Yield what is solved: its keys in the document, and the system."""
        if engine.rotating is None:
            yield from (({"speed_rpm": rpm}, engine.system) for rpm in self.speeds_rpm)
            return
        rotors = engine.rotating.system.rotors
        for angle in self.angles_deg:
            system = standing_at(engine.system, rotors, float(np.radians(angle)))
            yield {"speed_rpm": 0.0, "angle_deg": angle}, system

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return one picture, or one for each of several speeds or angles."""
        return tuple(f"{self.label}{ending}.png" for ending in self._endings)

    @property
    def _endings(self) -> list[str]:
        """What the picture of each state has after the name."""
        if len(self.angles_deg) > 1:
            return [f"_{base.number_text(angle)}deg" for angle in self.angles_deg]
        if len(self.speeds_rpm) > 1:
            return [f"_{base.number_text(rpm)}rpm" for rpm in self.speeds_rpm]
        return [""]

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Deflections and forces along x and y, at each speed."""
        return {
            ending: partial(_charts, found.document, [state])
            for ending, state in zip(self._endings, found.document["speeds"], strict=True)
            if _directions([state])
        }

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Deflections with forces, loads of bearings, sag of bodies, and how exact they are."""
        document = found.document
        notes = [Text(text=note, kind="warning") for note in document["notes"]]
        tables = [_bearing_table(document), _body_table(document)]
        tables += [_law_table(document)] if document["law_loads"] else []
        return [*_charts(document, document["speeds"]), *tables, _balance_text(document), *notes]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Loads of the bearings and deflections of the bodies over the speed."""
        speeds = document["speeds"]
        bearings, bodies = list(speeds[0]["bearings"]), speeds[0]["bodies"]
        own = {
            key: [[s["bearings"][name][key] for name in bearings] for s in speeds]
            for key in ("load_n", "force_n", "moment_n_m")
        }
        along = "angle_deg" if "angle_deg" in speeds[0] else "speed_rpm"
        over = (along, "bearing")
        variables: dict[str, Any] = {}
        if bearings:
            variables = {key: ((*over, "axis"), own[key]) for key in ("force_n", "moment_n_m")}
            variables["load_n"] = (over, own["load_n"])
        variables["deflection_m"] = (
            (along, "point", "direction"),
            [[p for name in bodies for p in s["bodies"][name]["deflection_m"]] for s in speeds],
        )
        return Labels(
            variables,
            {
                along: (along, [s[along] for s in speeds]),
                "direction": ("direction", ["x", "y"]),
                **({"bearing": ("bearing", bearings), "axis": ("axis", [*"xyz"])} if own else {}),
                "body": ("point", [n for n, body in bodies.items() for _ in body["axial_m"]]),
                "axial_m": ("point", [z for body in bodies.values() for z in body["axial_m"]]),
            },
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest sag of each body and the largest load of each bearing."""
        speeds = document["speeds"]
        for body in speeds[0]["bodies"]:
            yield (
                f"{body}.largest_sag_m",
                base.largest_of(s["bodies"][body]["sag_m"] for s in speeds),
            )
        for name in speeds[0]["bearings"]:
            loads = (s["bearings"][name]["load_n"] for s in speeds)
            yield f"{name}.largest_load_n", base.largest_of(loads)


def _response_document(system: AssembledSystem, found: StaticResponse) -> dict[str, Any]:
    bodies = {}
    for name, line in found.lines.items():
        sag, place = line.sag
        bodies[name] = {
            "weight_kg": system.system.rotors[name].element.mass_kg,
            "sag_m": sag,
            "sag_at_m": place,
            "axial_m": line.axial_m.tolist(),
            "deflection_m": line.deflection_m.tolist(),
            "slope_rad": line.slope_rad.tolist(),
        }
    return {
        "bodies": bodies,
        "bearings": {b.name: _bearing_document(system, found, b) for b in system.system.bearings},
        "gear_forces_n": dict(found.gear_forces_n),
        "loads": [
            {
                "at": load.at.label,
                "axial_m": _axial(system, load.at),
                "force_n": list(load.force_n),
                "moment_n_m": list(load.moment_n_m),
            }
            for load in found.points
        ],
        "balance": {
            "relative_residual": found.relative_residual,
            "bodies": {
                name: {"force_n": total[:3].tolist(), "moment_n_m": total[3:].tolist()}
                for name, total in found.balance.items()
            },
        },
    }


def _law_loads(system: AssembledSystem) -> dict[str, Any]:
    """Loads that the laws of bearings are of, at the speeds of their rows."""
    found = {}
    for bearing in system.system.bearings:
        law = bearing.speed_law
        if isinstance(law, TableLaw | FrequencyTableLaw) and law.static_loads_n is not None:
            found[bearing.name] = {
                "law": law.name,
                "speed_of_its_rotor_rpm": (law.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "load_n": law.static_loads_n.tolist(),
            }
    return found


def _axial(system: AssembledSystem, end: End) -> float:
    """Place of an interface along the axis, m."""
    return float(system.system.rotors[end.body].element.interface_node(end.interface).position_m[2])


def _headline(states: Sequence[Mapping[str, Any]]) -> str:
    state = states[0]
    sags = {name: body["sag_m"] for name, body in state["bodies"].items()}
    most = max(sags, key=sags.__getitem__)
    loads = {name: bearing["load_n"] for name, bearing in state["bearings"].items()}
    least = _ROUNDING * max(loads.values(), default=0.0)
    said = ", ".join(f"{n} {load:.4g} N" for n, load in loads.items() if load > least) or "none"
    every = [1e6 * own["bodies"][most]["sag_m"] for own in states]
    span = f"{every[0]:.4g}"
    if "angle_deg" in state and len(every) > 1:
        span = f"{min(every):.4g} to {max(every):.4g}"
    return f"largest sag {span} µm ({most}); bearing loads {said}"


def _state_text(state: Mapping[str, Any]) -> str:
    """The speed of a state, or the angle of asymmetric bodies in it."""
    angle = state.get("angle_deg")
    speed = f"{state['speed_rpm']:.6g} rpm"
    return speed if angle is None else f"at rest, {base.number_text(angle)}°"


def _bearing_document(
    system: AssembledSystem, found: StaticResponse, bearing: Bearing
) -> dict[str, Any]:
    load, motion = found.bearing_loads[bearing.name], found.bearing_motions[bearing.name]
    loads = [np.hypot(*one[:2]) for one in found.bearing_loads.values()]
    way = _direction_deg(load[:2], max(loads))
    largest = max((line.sag[0] for line in found.lines.values()), default=0.0)
    moved = _direction_deg(motion[:2], largest)
    attitude = None if way is None or moved is None else (moved - way + 180.0) % 360.0 - 180.0
    return {
        "at": bearing.first.label,
        "axial_m": _axial(system, bearing.first),
        "force_n": load[:3].tolist(),
        "moment_n_m": load[3:].tolist(),
        "load_n": float(np.hypot(*load[:2])),
        "load_kg": float(np.hypot(*load[:2])) / STANDARD_GRAVITY,
        "direction_deg": way,
        "motion_m": motion[:2].tolist(),
        "attitude_deg": attitude,
        "slope_rad": found.slopes_rad[bearing.name].tolist(),
    }


def _direction_deg(vector: FloatArray, largest: float) -> float | None:
    """Direction from +x towards +y; None of what is rounding beside the largest."""
    if not np.hypot(*vector) > _ROUNDING * largest:
        return None
    return float(np.degrees(np.arctan2(vector[1], vector[0])))


def _directions(states: Sequence[Mapping[str, Any]]) -> list[int]:
    """Directions along which something moves, y first."""
    size = np.zeros(2)
    for state in states:
        for body in state["bodies"].values():
            moved = np.abs(numbers(body["deflection_m"]).reshape(-1, 2))
            size = np.maximum(size, moved.max(axis=0, initial=0.0))
    return [k for k in (1, 0) if size[k] > _ROUNDING * size.max()]


def _charts(document: Mapping[str, Any], states: Sequence[Mapping[str, Any]]) -> list[Chart]:
    return [
        static_chart("xy"[k], [_loaded(document, state, k) for state in states])
        for k in _directions(states)
    ]


def _loaded(document: Mapping[str, Any], state: Mapping[str, Any], k: int) -> LoadedState:
    """What is drawn along one direction."""
    lines = {
        name: LoadedLine(
            name=name,
            axial_m=numbers(body["axial_m"]),
            deflection_m=numbers(body["deflection_m"]).reshape(-1, 2)[:, k],
        )
        for name, body in state["bodies"].items()
    }
    arrows = [
        Arrow(
            name=name,
            axial_m=bearing["axial_m"],
            deflection_m=_at(lines[bearing["at"].partition(".")[0]], bearing["axial_m"]),
            force_n=-bearing["force_n"][k],
        )
        for name, bearing in state["bearings"].items()
    ]
    arrows += [
        Arrow(
            name=load["at"],
            axial_m=load["axial_m"],
            deflection_m=_at(lines[load["at"].partition(".")[0]], load["axial_m"]),
            force_n=load["force_n"][k],
            of_support=False,
        )
        for load in state["loads"]
    ]
    acting = [*state["bearings"].values(), *state["loads"]]
    return LoadedState(
        label=_state_text(state),
        lines=list(lines.values()),
        arrows=arrows,
        largest_n=max((float(np.hypot(*own["force_n"][:2])) for own in acting), default=0.0),
    )


def _at(line: LoadedLine, place: float) -> float:
    return float(np.interp(place, line.axial_m, line.deflection_m)) if line.axial_m.size else 0.0


def _bearing_table(document: Mapping[str, Any]) -> Table:
    rows = [
        [
            name,
            _state_text(state),
            *(float(v) for v in bearing["force_n"]),
            float(bearing["load_n"]),
            float(bearing["load_kg"]),
            _degrees(bearing["direction_deg"]),
            _degrees(bearing["attitude_deg"]),
            *(1e3 * v for v in bearing["slope_rad"]),
        ]
        for state in document["speeds"]
        for name, bearing in state["bearings"].items()
    ]
    return Table(
        title="Loads of the bearings",
        head=[
            *("bearing", "at", "Fx [N]", "Fy [N]", "Fz [N]", "load [N]", "load [kg]"),
            *("direction [°]", "attitude [°]", "slope in x [mrad]", "slope in y [mrad]"),
        ],
        rows=rows,
        caption="Force of the first side on the second, which is the ground where none is named. "
        "Load: across the axis, and as a mass at 9.80665 m/s². Direction: from +x towards +y. "
        "Attitude: from the load to the motion in the bearing, by its stiffness. Slopes are those "
        "of the journal.",
    )


def _law_table(document: Mapping[str, Any]) -> Table:
    rows = []
    for name, own in document["law_loads"].items():
        speeds, loads = own["speed_of_its_rotor_rpm"], own["load_n"]
        for low, high in _runs(loads):
            span = [f"{rpm:.6g}" for rpm in dict.fromkeys((speeds[low], speeds[high]))]
            rows.append([name, own["law"], " to ".join(span), float(loads[low])])
    return Table(
        title="Loads that tables over the load are read at",
        head=["bearing", "law", "speed of its rotor [rpm]", "load [N]"],
        rows=rows,
        caption="Every analysis takes the coefficients of these loads, which are in equilibrium "
        "with them.",
    )


def _runs(loads: Sequence[float]) -> list[tuple[int, int]]:
    """First and last place of neighbours that are one load but for rounding."""
    found = [(0, 0)]
    for k in range(1, len(loads)):
        low = found[-1][0]
        if abs(loads[k] - loads[low]) <= _SAME_LOAD * abs(loads[low]):
            found[-1] = (low, k)
        else:
            found.append((k, k))
    return found


def _degrees(value: float | None) -> str | None:
    return None if value is None else f"{value:.2f}"


def _body_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Sag",
        head=["body", "at", "weight [kg]", "largest deflection [µm]", "at z [m]"],
        rows=[
            [
                name,
                _state_text(state),
                float(body["weight_kg"]),
                1e6 * body["sag_m"],
                f"{body['sag_at_m']:.5g}",
            ]
            for state in document["speeds"]
            for name, body in state["bodies"].items()
        ],
    )


def _balance_text(document: Mapping[str, Any]) -> Text:
    worst = max(state["balance"]["relative_residual"] for state in document["speeds"])
    estimates = [state["error_estimate"] for state in document["speeds"]]
    known = [value for value in estimates if value is not None]
    said = f"Forces and moments on every body are in balance to {worst:.1e} of the largest."
    if known:
        said += (
            f" Estimated error of the deflection, weighted with the load: {100.0 * max(known):.2g} "
            "%."
        )
    return Text(text=said)
