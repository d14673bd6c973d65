"""All sections about physics: charts that plotly knows, with units, words and known colours."""

from __future__ import annotations

import re
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from everything import everything

from solidwhirl.analyses.recovery import analysis as recovery
from solidwhirl.analyses.registry import KINDS
from solidwhirl.files.vtk_files import Grid, write_vtu
from solidwhirl.page.frame.plotly_chart import page_chart, slug
from solidwhirl.page.frame.records import (
    COLOR_TOKENS,
    Chart,
    Choice,
    ModeViewer,
    Section,
    Text,
    Toggle,
)
from solidwhirl.page.sections import sections_of
from solidwhirl.rotordyn.plots.chart import metric

# Sections about the run itself and the drawing; all others are about physics.
OTHERS = {"summary", "engine", "comparison", "inputs", "masses", "meshes", "accuracy", "checks",
          "provenance"}  # fmt: skip
# What stands at an axis without a unit: names, and numbers of modes.
UNITLESS = {"unbalance of", "shaft", "mode", "quantity", "state and body", "unbalance at"}


def _stress(pascals):
    return {
        "largest_von_mises_pa": pascals,
        "at_m": [0.01, 0.0, 0.1],
        "material": "steel",
        "largest_principal_pa": pascals,
        "smallest_principal_pa": -pascals,
    }


def recovered():
    """States of a recovery: one mode, whose stress has no sum, and one response."""
    states = []
    for state, source, rpm, hertz, dynamic, total in (
        ("first", "mode", 3000.0, 50.0, 3e6, None),
        ("peak", "response", 3100.0, 51.0, 4e6, 7e6),
    ):
        rotor = {"largest_displacement_m": 2e-5, "strain_energy_j": 1.0}
        rotor |= {"strain_energy_error": 1e-12, "total": total and _stress(total)}
        rotor |= {"dynamic": _stress(dynamic), "steady": _stress(5e6)}
        found = {"state": state, "source": source, "speed_rpm": rpm, "frequency_hz": hertz}
        states.append(found | {"bodies": {"rotor": rotor}})
    return states


@cache
def sections() -> list[Section]:
    found = [s for s in sections_of(everything()) if s.name not in OTHERS]
    stress = page_chart(recovery.stress_chart(recovered()), "stress")
    return [*found, Section(name="recovery", title="Recovery", blocks=[stress])]


def charts() -> list[Chart]:
    return [b for s in sections() for b in s.blocks if isinstance(b, Chart)]


def test_every_kind_of_analysis_is_shown():
    run = everything()
    asked = {spec.kind: spec.label for spec in run.results.scene.analyses}
    # the scene of these tests has no meshed body, none that is asymmetric, no magnets
    assert set(asked) == set(KINDS) - {
        *("recovery", "nodal_diameters", "asymmetric_response", "level_comparison", "sensitivity")
    }
    names = " ".join(c.name for c in charts())
    texts = " ".join(b.text for s in sections() for b in s.blocks if isinstance(b, Text))
    for kind, label in asked.items():
        # modes are shown whether an analysis asks for them or not
        shown = kind == "mode_shapes" or slug(label) in names
        # torsion of this scene is undamped: its decrement of zero has no curve
        assert shown or (kind == "stability" and "motion that nothing damps" in texts), kind


def test_blocks_have_one_name_each_and_words():
    drawn = [b for s in sections() for b in s.blocks if isinstance(b, Chart | ModeViewer)]
    names = [b.name for b in drawn] + [s.name for s in sections()]
    assert len(names) == len(set(names))
    for block in drawn:
        assert re.fullmatch(r"[A-Za-z0-9-]+", block.name)
        assert block.title
        assert len(block.caption) > 40 and block.caption.endswith(".")
        assert len(block.alt) > 20


def test_axes_have_units():
    for chart in charts():
        layout = chart.layout
        axes = layout.get("scene", layout)
        wanted = [k for k in axes if re.fullmatch(r"[xyz]axis\d*", k)]
        assert len(wanted) >= 2, chart.name
        titles = [axes[k]["title"]["text"] for k in wanted]
        for control in chart.controls:
            for option in getattr(control, "options", ()):
                titles += [v for k, v in option.layout.items() if k.endswith("title.text")]
        for title in titles:
            plain = chart.name.startswith("orbits-") and title in "xy"
            assert title in UNITLESS or plain or re.search(r"\[.+\]", title), (chart.name, title)


def _colored(value):
    """The same with tokens as colours, and a list of the tokens."""
    if isinstance(value, str) and value.startswith("@"):
        name = value.split("/")[0]
        assert name in COLOR_TOKENS, value
        return "#123456"
    if isinstance(value, dict):
        return {k: _colored(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_colored(v) for v in value]
    return value


def test_plotly_accepts_every_trace_and_layout():
    import plotly.graph_objects as go

    for chart in charts():
        go.Figure(data=_colored(list(chart.traces)), layout=_colored(dict(chart.layout)))
    # what it does not know it refuses: else nothing could fail here
    with pytest.raises(ValueError, match="fillpatern"):
        go.Figure(data=[{"type": "scatter", "fillpatern": {}}])


def test_controls_name_traces_that_exist():
    for chart in charts():
        everywhere = set(range(len(chart.traces)))
        for control in chart.controls:
            if isinstance(control, Toggle):
                assert set(control.traces) <= everywhere and control.traces, chart.name
            else:
                assert isinstance(control, Choice) and control.options
                assert {t for o in control.options for t in o.traces} <= everywhere
                labels = [o.label for o in control.options]
                assert len(labels) == len(set(labels)), chart.name


def test_nothing_is_told_by_colour_alone():
    """Curves of one chart that show together differ in dashes, marks, patterns or place."""
    for chart in charts():
        choices = [c for c in chart.controls if isinstance(c, Choice)]
        for option in [o for c in choices for o in c.options] or [None]:
            hidden = {t for c in choices for o in c.options for t in o.traces}
            shown = [
                t
                for k, t in enumerate(chart.traces)
                if t["type"] == "scatter"
                and t.get("mode") == "lines"
                and "fill" not in t
                and t.get("showlegend") is not False
                and (option is None or k in option.traces or k not in hidden)
            ]
            if len(shown) < 2 or len({t["line"]["color"] for t in shown}) < 2:
                continue
            if any(t.get("mode") == "markers+text" for t in chart.traces):
                continue  # each curve has its name beside it
            dashes = [t["line"]["dash"] for t in shown]
            assert len(set(dashes)) > 1, chart.name


def halved_cube(path):
    """A cube of five tetrahedra from -1 to 1, its stress 2 MPa and 1 MPa/m along x."""
    points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    tetrahedra = np.array([[0, 1, 2, 4], [3, 1, 2, 7], [5, 1, 4, 7], [6, 2, 4, 7], [1, 2, 4, 7]])
    fields = {"displacement": 0.0 * points, "von_mises_total": 1e6 * (2.0 + points[:, 0])}
    write_vtu(Grid(points_m=points, cells=((10, tetrahedra),), point_data=fields), path)


def test_a_recovery_tells_stresses_states_and_files():
    state = {"mode": 1, "speed_rpm": 3000.0}
    spec = recovery.RecoverySpec(kind="recovery", bodies=["rotor"], states=[state])
    files = {"recovery/s_rotor_first.vtu": halved_cube, "notes.txt": None}
    document = {"states": recovered()}
    found = SimpleNamespace(name="s", document=document, outcome=SimpleNamespace(files=files))
    chart, stresses, cut, states, listed = spec.blocks(found)
    (body,) = cut.bodies  # of the other state there is no file
    assert (body.label, body.unit, body.largest) == ("first, rotor", "MPa", 3.0)
    # values are linear from -1 to 1 m: 2 MPa on the cut face
    at_cut = np.abs(body.points_m[:, 0]) < 1e-9
    np.testing.assert_allclose(body.values, 2.0 + body.points_m[:, 0])
    assert at_cut.any() and body.points_m[:, 0].min() == 0.0 and body.points_m[:, 0].max() == 1.0
    bars = {t["name"]: t["y"] for t in page_chart(chart).traces}
    np.testing.assert_allclose(bars["of the state"], [3.0, 4.0])  # MPa
    np.testing.assert_allclose(bars["both together"], [np.nan, 7.0])
    assert chart.x.places == ["first, rotor", "peak, rotor"]
    # a mode without amplitude has no sum of the loads
    assert [row[2] for row in stresses.rows if row[0] == "first"] == ["of the state", "centrifugal"]
    assert [row[:4] for row in states.rows] == [
        ["first", "mode", "3000.0", "50"], ["peak", "response", "3100.0", "51"]
    ]  # fmt: skip
    assert listed.rows == [["`recovery/s_rotor_first.vtu`"]] and listed.folded.endswith("(1)")
    told = dict(recovery.RecoverySpec.scalars(document))
    assert told["peak.rotor.total_largest_von_mises_pa"] == 7e6
    assert told["first.rotor.total_largest_von_mises_pa"] is None


@pytest.mark.parametrize(
    ("size", "unit", "number"),
    [
        (2.5e-5, "µm", 25.0),
        (3e-3, "mm", 3.0),
        (0.0, "µm", 0.0),
        (4e-11, "pm", 40.0),
        (2e4, "km", 20),
    ],
)
def test_units_make_numbers_of_few_digits(size, unit, number):
    found, factor = metric(size, "m")
    assert found == unit
    assert size * factor == pytest.approx(number)


def test_identifiers_of_two_names_differ():
    names = ["a b", "a_b", "a-b", "a.b", "ä b", "A b"]
    assert len({slug(n) for n in names}) >= 5
    assert all(re.fullmatch(r"[A-Za-z0-9-]+", slug(n)) for n in names)
