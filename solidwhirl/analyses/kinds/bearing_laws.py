"""Coefficients of the bearings that depend on the speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from solidwhirl.analyses.base import STABILITY, Analysis, Charts, Engine, Found
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text
from solidwhirl.core.fields import Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn.assembly.bearing_laws import RingLaw
from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes, note_lines
from solidwhirl.rotordyn.assembly.system import LawJoint
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.resonance_samples import with_knots

_SAME = 1e-9
# Where a coefficient stands in its matrix, and the dashes of its line.
_ENTRIES = {"xx": (0, 0, "solid"), "yy": (1, 1, "dot"), "xy": (0, 1, "dash"),
            "yx": (1, 0, "dashdot")}  # fmt: skip


# Keys of the stiffness of a rolling bearing begin with these.
_MEAN_AND_RANGE = ("", "least_", "most_")


class BearingLawsSpec(Analysis):
    """Stiffness and damping of the bearings that depend on the speed."""

    section = STABILITY

    kind: Literal["bearing_laws"]
    to_rpm: Positive

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return a picture for each bearing with a law."""
        return tuple(f"{self.label}_{name}.png" for name, has_law in bearings.items() if has_law)

    def work(self, size: EngineSize) -> Work:
        """Coefficients of each bearing over the speed."""
        return Work(results=100.0)

    def run(self, engine: Engine) -> Outcome:
        """Coefficients of the bearings that depend on the speed."""
        speeds = self._speeds(engine)
        documents = {
            own.bearing: {
                "law": own.law,
                "speed_of_its_rotor_rpm": own.speed_rpm.tolist(),
                "stiffness_n_per_m": [np.diag(k).tolist() for k in own.stiffness],
                "damping_n_s_per_m": [np.diag(c).tolist() for c in own.damping],
                **_ring_document(own),
            }
            for own in _laws(engine, speeds)
        }
        notes = list(note_lines(bearing_notes(engine.system, speeds[[0, -1]])))
        return Outcome(
            kind=self.kind,
            document={"bearings": documents, "notes": notes},
            headline=f"{len(documents)} bearings, {len(notes)} notes",
        )

    def _speeds(self, engine: Engine) -> FloatArray:
        speeds = np.linspace(0.0, self.to_rpm * RAD_S_PER_RPM, 401)
        return with_knots(speeds, engine.system.knots_rad_s)

    def pictures(self, found: Found) -> Mapping[str, Charts]:
        """One picture for each bearing: stiffness above damping."""
        laws = _laws(found.engine, self._speeds(found.engine))
        return {f"_{own.bearing}": partial(_law_charts, [own]) for own in laws}

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """Coefficients of all bearings together, and what is to be said of them."""
        laws = list(_laws(found.engine, self._speeds(found.engine)))
        notes = [Text(text=note, kind="warning") for note in found.document["notes"]]
        rings = [_ring_table(found.document["bearings"])] if any(law.ring for law in laws) else []
        return [*(_law_charts(laws) if laws else ()), *rings, *notes]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Direct coefficients over the speed of the rotor, bearing by bearing."""
        laws, own = document["bearings"], "speed_of_its_rotor_rpm"
        if not laws:
            return Labels({})
        keys = ("stiffness_n_per_m", "damping_n_s_per_m")
        over = ("bearing", "point", "direction")
        return Labels(
            {key: (over, [law[key] for law in laws.values()]) for key in keys},
            {
                "bearing": ("bearing", list(laws)),
                "direction": ("direction", ["x", "y"]),
                "law": ("bearing", [law["law"] for law in laws.values()]),
                own: (("bearing", "point"), [law[own] for law in laws.values()]),
            },
        )


class Law(NamedTuple):
    """Coefficients (s, 2, 2) of a bearing over the speed of its rotor, and the law's own range."""

    bearing: str
    law: str
    speed_rpm: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    range_rpm: tuple[float, float]
    #: On ux to rz, (s, 6, 6), and the law, of a rolling bearing
    whole: FloatArray
    ring: RingLaw | None = None


def _laws(engine: Engine, speeds_rad_s: FloatArray) -> Iterator[Law]:
    joints: dict[str, list[LawJoint]] = {}
    for joint in engine.system.law_joints:
        joints.setdefault(joint.bearing, []).append(joint)
    laws = {bearing.name: bearing.speed_law for bearing in engine.system.system.bearings}
    for name, own in joints.items():
        values = np.zeros((2, speeds_rad_s.size, 6, 6))
        for joint in own:
            at = slice(len(joint.rows))
            for k, speed in enumerate(speeds_rad_s.tolist()):
                found = np.array(joint.coefficients(speed))[:, at, at]
                values[:, k] += joint.rows.T @ found @ joint.rows
        low, high = own[0].law.speed_range_rad_s
        law = laws[name]
        yield Law(
            bearing=name,
            law=own[0].law.name,
            speed_rpm=np.abs(own[0].speed_ratio) * speeds_rad_s * RPM_PER_RAD_S,
            stiffness=values[0][:, :2, :2],
            damping=values[1][:, :2, :2],
            range_rpm=(low * RPM_PER_RAD_S, high * RPM_PER_RAD_S),
            whole=values[0],
            ring=law if isinstance(law, RingLaw) else None,
        )


def _ring_document(own: Law) -> dict[str, Any]:
    """What a rolling bearing has beside its lateral stiffness, and its range over positions."""
    if own.ring is None:
        return {}
    k, law = own.whole, own.ring
    speeds = law.speeds_rad_s * RPM_PER_RAD_S
    found = {
        f"{name}_stiffness_n_per_m": np.array(
            [np.interp(own.speed_rpm, speeds, column) for column in values[:, :2].T]
        ).T.tolist()
        for name, values in (("least", law.least), ("most", law.most))
        if values is not None
    }
    return found | {
        "axial_stiffness_n_per_m": k[:, 2, 2].tolist(),
        "tilt_stiffness_n_m_per_rad": np.stack((k[:, 3, 3], k[:, 4, 4]), axis=1).tolist(),
        "coupling_of_x_with_ry_n_per_rad": k[:, 0, 4].tolist(),
        "coupling_of_y_with_rx_n_per_rad": k[:, 1, 3].tolist(),
    }


def _ring_table(bearings: Mapping[str, Mapping[str, Any]]) -> Table:
    """Stiffness of rolling bearings at rest, half way and at the highest speed."""
    rows: list[list[Any]] = []
    for name, own in bearings.items():
        if "axial_stiffness_n_per_m" not in own:
            continue
        speeds = own["speed_of_its_rotor_rpm"]
        for k in dict.fromkeys((0, len(speeds) // 2, len(speeds) - 1)):
            row = [name, own["law"], f"{speeds[k]:.0f}"]
            for at in (0, 1):
                ends = [own[f"{key}stiffness_n_per_m"][k][at] * 1e-6 for key in _MEAN_AND_RANGE]
                row += [f"{ends[0]:.4g}", f"{ends[1]:.4g} to {ends[2]:.4g}"]
            row.append(f"{1e-6 * own['axial_stiffness_n_per_m'][k]:.4g}")
            row += [f"{1e-3 * value:.4g}" for value in own["tilt_stiffness_n_m_per_rad"][k]]
            row.append(f"{1e-6 * own['coupling_of_x_with_ry_n_per_rad'][k]:.3g}")
            rows.append(row)
    return Table(
        title="Rolling bearings",
        head=[
            *("bearing", "law", "its rotor [rpm]", "x [N/µm]", "over positions", "y [N/µm]"),
            *("over positions", "z [N/µm]", "rx [N m/mrad]", "ry [N m/mrad]", "x with ry [N/µrad]"),
        ],
        rows=rows,
        caption="Means over the positions of the balls or rollers, which lie anywhere as the shaft "
        "turns; least and most over these positions beside them.",
    )


def _law_charts(laws: Sequence[Law]) -> list[charts.Chart]:
    return [
        law_chart([(law, getattr(law, quantity)) for law in laws], quantity.capitalize(), unit)
        for quantity, unit in (("stiffness", "N/m"), ("damping", "N s/m"))
    ]


def law_chart(found: Sequence[tuple[Law, FloatArray]], quantity: str, unit: str) -> charts.Chart:
    """Return one coefficient (s, 2, 2) of bearings with a law; equal curves are drawn once."""
    prefixed, factor = charts.metric(max(float(np.nanmax(np.abs(m))) for _, m in found), unit)
    curves = [
        charts.Curve(
            x=law.speed_rpm,
            y=factor * values,
            name=f"{', '.join(names)} ({law.law})",
            look=charts.Look(charts.series_look(number).color, _dash(names[-1])),
        )
        for number, (names, law, values) in enumerate(_curves(found))
    ]
    last = max(float(law.speed_rpm.max()) for law, _ in found)
    spans = {span.name: span for law, matrices in found for span in _spans(law, matrices)}
    parts: list[charts.Part] = [*(spans.values() if len(found) == 1 else ()), *curves]
    return charts.Chart(
        name=f"law-{quantity.lower()}",
        title=f"{quantity} of bearings with a speed law",
        caption="Over the speed of the rotor that the bearing carries. Along y alone lines are "
        "dotted, cross coefficients are broken; bearings with the same curve share it. A reference "
        "shaft that is not the rotor turns at another speed.",
        alt=f"{quantity} of {', '.join(law.bearing for law, _ in found)} over the speed.",
        x=charts.speed_axis(0.0, last, "speed of the rotor itself"),
        y=charts.Axis(label=quantity.lower(), unit=prefixed, digits=".4g"),
        parts=parts,
        height_px=340,
    )


def _dash(name: str) -> str:
    return "solid" if name.endswith("xx and yy") else _ENTRIES[name[-2:]][2]


def _curves(
    found: Sequence[tuple[Law, FloatArray]],
) -> list[tuple[list[str], Law, FloatArray]]:
    """Curves that differ, with the bearings and directions that have them."""
    out: list[tuple[list[str], Law, FloatArray]] = []
    for law, matrices in found:
        curves = {name: matrices[:, i, j] for name, (i, j, _) in _ENTRIES.items()}
        if np.allclose(curves["xx"], curves["yy"], rtol=_SAME, atol=0.0):
            curves = {"xx and yy": curves["xx"], "xy": curves["xy"], "yx": curves["yx"]}
        for name, values in curves.items():
            if name in ("xy", "yx") and not values.any():
                continue
            own = law, values
            names = next((n for n, other, others in out if _is_same(own, (other, others))), None)
            if names is None:
                out.append(([f"{law.bearing} {name}"], law, values))
            else:
                names.append(f"{law.bearing} {name}")
    return out


def _is_same(first: tuple[Law, FloatArray], second: tuple[Law, FloatArray]) -> bool:
    """Whether one curve would lie on the other."""
    (law, values), (other, others) = first, second
    return (
        law.law == other.law
        and np.array_equal(law.speed_rpm, other.speed_rpm)
        and np.allclose(values, others, rtol=_SAME, atol=0.0)
    )


def _spans(law: Law, matrices: FloatArray) -> Iterator[charts.Span]:
    """The range that a law was made for, and where its damping has a negative eigenvalue."""
    rpm = law.speed_rpm
    low, high = max(law.range_rpm[0], float(rpm[0])), min(law.range_rpm[1], float(rpm[-1]))
    yield charts.Span(low=low, high=high, name=f"range of {law.law}", look=charts.Look("@good", ""))
    if matrices is not law.damping:
        return
    lowest = np.linalg.eigvalsh(0.5 * (matrices + matrices.transpose(0, 2, 1)))[:, 0]
    negative = lowest < -1e-12 * np.abs(matrices).max(initial=0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], negative.astype(int), [0]))))
    for k, (a, b) in enumerate(edges.reshape(-1, 2)):
        name = "negative damping" + " " * k
        yield charts.Span(low=float(rpm[a]), high=float(rpm[b - 1]), name=name, is_hatched=True)
