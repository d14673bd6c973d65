"""Parts of a page without a browser: text, tables, arrays, meshes, comparison."""

from __future__ import annotations

import base64
import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solidwhirl.core.errors import SceneError
from solidwhirl.output.documents import compared, results_document, value_at
from solidwhirl.page.frame.build import page_html
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Chart, Run, Section, Table, Text
from solidwhirl.page.frame.render import cell_text, data_json, plain, table_html, text_html
from solidwhirl.page.run import meshes
from solidwhirl.page.run.meshes import boundary_of, edges_of
from solidwhirl.page.sections import write_report
from solidwhirl.pipeline.cached_stages import engine_part
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.scene.records import ReferenceSpec
from solidwhirl.scene_reading.reader import parse_scene, scene_hash


def _chart(name="c", **more):
    return Chart(name=name, title="T", caption="C", alt="A", traces=[], layout={}, **more)


def test_text_shows_html_as_it_is_written():
    found = text_html("a **b & c** `x < 1`\nmore <script>\n\n- one\n- two\nthen")
    assert found == (
        "<p>a <strong>b &amp; c</strong> <code>x &lt; 1</code> more &lt;script&gt;</p>"
        "<ul><li>one</li><li>two</li></ul><p>then</p>"
    )


def test_tables_put_numbers_at_the_right_and_name_what_is_absent():
    table = Table(head=("a", "b", "c"), rows=[("x", 1.23456789, None), ("y", np.nan, "2, 3")])
    found = table_html(table)
    assert found.count('<td class="number">') == 2
    assert "1.2346" in found
    assert '<td class="number">–</td>' in found
    assert "<td>2, 3</td>" in found
    assert [cell_text(v) for v in (True, np.bool_(False), 3, 1e-9)] == ["yes", "no", "3", "1e-09"]
    with pytest.raises(ValueError, match="2 cells, the head 3"):
        table_html(Table(head=("a", "b", "c"), rows=[(1, 2)]))
    # a head without words has no empty line
    assert "<thead>" not in table_html(Table(head=("", ""), rows=[("a", "b")]))
    assert "<thead>" in table_html(Table(head=("", "x"), rows=[("a", "b")]))
    # a whirl has a sign and a colour
    found = table_html(Table(head=("whirl",), rows=[("□ backward",), ("● forward",)]))
    assert 'style="color:var(--backward)">□</span> backward' in found
    assert 'style="color:var(--forward)">●</span> forward' in found


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(-1e6, 1e6, allow_nan=False), min_size=1, max_size=40),
    st.integers(1, 3),
)
def test_arrays_arrive_with_seven_digits(values, columns):
    array = np.resize(np.array(values), (len(values), columns))
    found = plain({"a": array})["a"]
    raw = np.frombuffer(base64.b64decode(found["bdata"]), dtype="<f4").reshape(found["shape"])
    # single precision has a relative spacing of 1.2e-7
    np.testing.assert_allclose(raw, array, rtol=6.1e-8, atol=1e-38)


def test_data_is_json_that_ends_no_script():
    chart = _chart()
    traces = [{"name": "</script><b>", "x": [1.0, np.nan, np.inf], "n": np.array([1, 2])}]
    text = data_json(Chart(**{**vars(chart), "traces": traces}))
    assert "</" not in text
    found = json.loads(text)["traces"][0]
    assert found["name"] == "</script><b>"
    assert found["x"] == [1.0, None, None]
    assert found["n"]["dtype"] == "i4"
    with pytest.raises(TypeError, match="can not hold set"):
        plain({"a": {1, 2}})


def test_a_page_without_charts_is_small_and_asks_for_nothing():
    sections = [Section(name="a", title="A", blocks=(_chart("a"),))]
    with pytest.raises(ValueError, match="same name: a"):
        page_html(sections, title="t", name="n")
    sections = [Section(name="a", title="A", blocks=(Text(text="words"),))]
    page = page_html(sections, title="<t>", name="n")
    assert len(page) < 40_000
    assert "<title>&lt;t&gt;</title>" in page
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?!data:|#)[\w/.]""", page.split("<script")[0])
    assert "@import" not in page and "url(" not in page


def test_a_legend_names_equal_ranges_once():
    """As operating speeds of several shafts, with other marks between them."""
    spans = [
        charts.Span(low=k, high=k + 1.0, name=name, between=(0.0, 1.0))
        for k in range(3)
        for name in ("operating speed", "asked")
    ]
    line = charts.Curve(x=np.arange(2.0), y=np.arange(2.0), name="forward")
    marks = [m for span in spans for m in (span, line)]
    axes = {key: charts.Axis(label=key) for key in "xy"}
    drawn = page_chart(charts.Chart(name="c", title="c", parts=marks, **axes))
    named = [t["name"] for t in drawn.traces if t["showlegend"] and t.get("fill")]
    assert named == ["operating speed", "asked"]


def test_edges_of_a_mesh_obey_euler():
    """vertices − edges + faces = 1 for a grid of rectangles, each of two triangles."""
    at = np.arange(6 * 4).reshape(6, 4)
    a, b, c, d = (v.ravel() for v in (at[:-1, :-1], at[1:, :-1], at[:-1, 1:], at[1:, 1:]))
    cells = np.concatenate([np.column_stack([a, b, c]), np.column_stack([b, d, c])])
    assert at.size - len(edges_of(cells)) + len(cells) == 1
    assert len(boundary_of(cells)) == 2 * (5 + 3)


@pytest.mark.solver
def test_meridians_are_drawn_alike_on_page_and_paper(small_scene, tmp_path):
    results = run_scene(parse_scene(small_scene()))
    run = Run(results=results, document=results_document(results))
    chart, table = meshes.section(run).blocks
    mesh = results.bodies["rotor"].mesh
    lines = {trace["name"]: trace for trace in chart.traces}
    assert set(lines) == {f"steel, {len(mesh.cells)} elements", "outline", "interfaces"}
    assert set(lines["interfaces"]["text"]) >= {"rotor.left", "rotor.right"}
    assert table.rows[0][2] == len(mesh.cells)
    for most, shown in ((10_000, True), (10, False)):
        record = meshes.plane_chart({"rotor": mesh}, most)
        assert any("elements" in mark.name for mark in record.marks()) is shown
        assert ("outline alone" in record.caption) is not shown
    draw_charts([record], tmp_path / "m.svg", "Mesh")
    assert "interfaces" in (tmp_path / "m.svg").read_text("utf-8")


DOCUMENT = {
    "critical_speeds": [{"speed_rpm": 100.0, "frequency_hz": 51.0, "whirl": "forward"}],
    "bodies": {"rotor": {"mass_kg": 2.0, "flag": True}},
}


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("critical_speeds[0].frequency_hz", 51.0),
        ("bodies.rotor.mass_kg", 2.0),
        ("critical_speeds[1].frequency_hz", None),
        ("critical_speeds[0].whirl", None),
        ("bodies.rotor", None),
        ("bodies.rotor.flag", None),
        ("bodies.other.mass_kg", None),
        ("bodies[0].mass_kg", None),
    ],
)
def test_values_are_found_by_their_place(place, value):
    assert value_at(DOCUMENT, place) == value


def _reference(**more):
    base = {"quantity": "critical_speeds[0].frequency_hz", "value": 50.0, "source": "a book"}
    return ReferenceSpec(**{**base, **more})


def test_differences_are_over_the_reference():
    found = compared(
        [
            _reference(),
            _reference(tolerance=0.03),
            _reference(tolerance=0.01),
            _reference(quantity="bodies.none.mass_kg", tolerance=0.5),
            _reference(value=-50.0),
        ],
        DOCUMENT,
    )
    assert [e["met"] for e in found] == [None, True, False, False, None]
    assert found[0]["relative_difference"] == pytest.approx(0.02, rel=1e-12)
    assert found[3]["result"] is None
    assert found[4]["relative_difference"] == pytest.approx(101.0 / 50.0, rel=1e-12)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"quantity": "speeds[0]"}, "begins with"),
        ({"quantity": "bodies"}, "begins with"),
        ({"quantity": "bodies..mass_kg"}, "begins with"),
        ({"quantity": "bodies.rotor.mass_kg", "value": 0.0, "tolerance": 0.1}, "leave it out"),
        ({"source": ""}, "source"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"found": 1.0}, "unknown key"),
    ],
)
def test_references_that_say_nothing_are_refused(small_scene, table, said):
    entry = {"quantity": "bodies.rotor.mass_kg", "value": 1.0, "source": "s", **table}
    with pytest.raises(SceneError, match=said):
        parse_scene({**small_scene(), "references": [entry]})


def test_references_change_no_number(small_scene):
    plain_scene = parse_scene(small_scene())
    entry = {"quantity": "bodies.rotor.mass_kg", "value": 1.0, "source": "s"}
    with_one = parse_scene({**small_scene(), "references": [entry]})
    assert engine_part(plain_scene) == engine_part(with_one)
    assert scene_hash(plain_scene) != scene_hash(with_one)


@pytest.mark.solver
def test_the_page_holds_what_the_run_has(laval, tmp_path):
    path = tmp_path / "report.html"
    write_report(laval, path)
    text = path.read_text(encoding="utf-8")
    assert len(text) < 8e6
    words = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    for entry in laval.document["critical_speeds"]:
        assert f"{entry['speed_rpm']:.1f}" in words
    for effect in laval.document["plan"]["effects"]:
        assert effect["name"].replace("_", " ") in words
    for body in laval.document["bodies"].values():
        assert f"{body['mass_kg']:.5g}" in words
    assert laval.document["scene"]["sha256"] in words
    assert "solidwhirl run scenes/laval.toml --level beam" in words
    assert "density is 1 kg/m³" in words
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.solver
def test_references_are_shown_beside_the_results(laval):
    from solidwhirl.page.run.comparison import section

    speeds = laval.document["critical_speeds"]
    assert section(laval) is None
    place = "critical_speeds[0].frequency_hz"
    near = _reference(quantity=place, value=speeds[0]["frequency_hz"] * 1.01, tolerance=0.02)
    far = _reference(quantity=place, value=speeds[0]["frequency_hz"] * 0.9, tolerance=0.02)
    document = {**laval.document, "references": compared([near, far], laval.document)}
    found = section(Run(results=laval.results, document=document))
    warning, chart, table = found.blocks
    assert warning.kind == "warning"
    assert "+11.11 %" in warning.text
    allowed, *dots = chart.traces
    assert allowed["base"][0] == -2.0 and allowed["x"][0] == 4.0
    # 1/1.01 − 1 and 1/0.9 − 1
    assert [t["x"][0] for t in dots] == pytest.approx([-100 / 101, 100 / 9], rel=1e-9)
    assert [t["marker"]["symbol"] for t in dots] == ["circle", "x"]
    assert [row[6] for row in table.rows] == ["met", "**missed**"]
