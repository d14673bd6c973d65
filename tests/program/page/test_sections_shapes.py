"""The viewer of mode shapes: its data against the superelements, itself in a browser."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from browser import complaints, look_like, open_page, wait_for
from everything import everything
from hypothesis import given
from hypothesis import strategies as st

from solidwhirl.drawing.modes import shown_modes
from solidwhirl.drawing.motion import engine_in_space, unit_factor, with_few_points
from solidwhirl.page.frame.build import page_html
from solidwhirl.page.frame.records import Section
from solidwhirl.page.frame.render import plain
from solidwhirl.page.modes import shapes
from solidwhirl.page.modes.shapes import NOTHING, packed, viewer_data
from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.superelement.surface import around_axis


def _numbers(found):
    """What `solidwhirl.array` of the page's script gives."""
    kind = {"f4": "<f4", "i4": "<i4"}[found["dtype"]]
    return np.frombuffer(base64.b64decode(found["bdata"]), kind).reshape(found["shape"])


def _unpacked(found):
    """What `unpacked` of the viewer's script gives, as complex numbers."""
    whole = _numbers(plain(found["packed"])).view("<i2").astype(float)
    return (found["scale"] * whole).view(complex)


@pytest.fixture(scope="module")
def viewed():
    run = everything()
    shown = shown_modes(run.results)
    engine = engine_in_space(run.results)
    return run, shown, engine, viewer_data(engine, shown)


def test_modes_are_those_of_the_scene_and_of_the_critical_speeds(viewed):
    run, shown, _, data = viewed
    assert [s.label for s in shown] == ["at rest", "at 9000 rpm", "at the critical speeds"]
    asked = run.document["analyses"]["mode_shapes"]["speeds"]
    for s, speed in zip(shown[:2], asked, strict=True):
        hertz = s.modes.eigenvalues.imag / (2.0 * np.pi)
        count = min(hertz.size, len(speed["frequency_hz"]))
        np.testing.assert_allclose(hertz[:count], speed["frequency_hz"][:count], rtol=1e-9)
        assert list(s.whirl[:count]) == speed["whirl"][:count]
    critical = {
        round(c["speed_rpm"], 3)
        for c in run.document["critical_speeds"]
        if not c["critically_damped"]
    }
    assert {round(float(rpm), 3) for rpm in shown[2].rpm} <= critical
    assert {b["name"]: b["ratio"] for b in data["bodies"]} == {"lp": 1.0, "fan": 0.4, "casing": 0.0}
    for mode in data["states"][2]["modes"]:
        turns = [r * mode["rpm"] / 60.0 / mode["hertz"] for r in (1.0, 0.4)]
        # at a critical speed one of the shafts turns once per period
        assert min(abs(t - 1.0) for t in turns) < 1e-6


def test_surfaces_move_as_the_superelements_do(viewed):
    """Unpacked numbers give, but for one factor, the displacement by the superelement."""
    run, shown, engine, data = viewed
    system, pieces = run.results.system, with_few_points(engine).pieces
    assert [p["kind"] for p in data["pieces"]] == [p.surface.kind for p in pieces]
    theta = 2.0 * np.pi * np.arange(8) / 8
    for s, state in zip(shown, data["states"], strict=True):
        for k, mode in enumerate(state["modes"]):
            ours, exact = [], []
            for piece, terms in zip(pieces, mode["terms"], strict=True):
                own = body_rows(system, piece.body) @ s.modes.shapes[:, k]
                exact.append(piece.surface.displacement(own, 8))
                values = _unpacked(terms).reshape(-1, len(piece.surface.points_m), 3)
                moved = np.zeros((8, len(piece.surface.points_m), 3), dtype=complex)
                for order, family, part in zip(
                    terms["order"], terms["family"], values, strict=True
                ):
                    moved += around_axis(part, order, family, theta)
                ours.append(moved.reshape(-1, 3))
            u, v = np.concatenate(ours), np.concatenate(exact)
            if not v.any():  # the casing alone, which has no surface
                assert not u.any()
                continue
            factor = np.vdot(v, u) / np.vdot(v, v)
            # sixteen bits
            np.testing.assert_allclose(u, factor * v, atol=2e-4)
            size = [np.linalg.norm((u * np.exp(1j * a)).real, axis=1).max() for a in (0.0, 0.4)]
            assert size[0] == pytest.approx(1.0, abs=0.05)  # eight angles may miss the largest
            assert max(size) < 1.01


def test_orbits_turn_as_the_mode_whirls(viewed):
    _, shown, _, data = viewed
    seen = set()
    for s, state in zip(shown, data["states"], strict=True):
        for whirl, mode in zip(s.whirl, state["modes"], strict=True):
            senses = {sense for sense in mode["sense"] if sense}
            assert mode["whirl"] == whirl
            if whirl in ("forward", "backward"):
                assert senses <= {whirl, "straight"}
                seen |= senses
    assert {"forward", "backward"} <= seen


def test_rigid_disks_move_rigidly(viewed):
    """No point of a disk comes nearer to another one, to first order."""
    run, shown, engine, _ = viewed
    system = run.results.system
    rims = [p for p in engine.pieces if p.disk]
    assert {p.body for p in rims} == {"lp", "fan"}
    for piece in rims:
        points = piece.surface.faces(12).points_m
        for k in range(3):
            own = body_rows(system, piece.body) @ shown[1].modes.shapes[:, k]
            moved = piece.surface.displacement(own, 12)
            apart = points[:, None] - points[None]
            strain = np.einsum("abc,abc->ab", apart, moved[:, None] - moved[None])
            size = np.abs(moved).max() * np.linalg.norm(apart, axis=2).max()
            # the slope of a beam by differences of its nodes is rigid all the same
            assert np.abs(strain).max() < 1e-10 * size
    # a uniform disk of no thickness, 60 kg and 6 kg m²
    fan = next(p for p in rims if p.body == "fan")
    assert fan.surface.points_m[:, 1].max() == pytest.approx(np.sqrt(2 * 6.0 / 60.0))


@given(
    values=st.lists(
        st.complex_numbers(max_magnitude=1e3, allow_nan=False, allow_infinity=False),
        min_size=1,
        max_size=20,
    )
)
def test_sixteen_bits_are_enough(values):
    exact = np.array(values)
    found = _unpacked(packed(exact))
    largest = max(np.abs(exact.real).max(), np.abs(exact.imag).max())
    # half a step in each part, and seven digits of the page's numbers; less is nothing
    assert np.abs(found - exact).max(initial=0.0) <= 1.5 * largest / 32767 + NOTHING
    # a mode without motion stays still
    assert unit_factor([np.zeros((3, 3), dtype=complex)]) == 0.0
    assert unit_factor([]) == 0.0


def test_bars_are_the_shares_of_energy(viewed):
    run, _, _, _ = viewed
    found = {b.name: b for b in shapes.section(run).blocks if hasattr(b, "traces")}
    bars = found["shares-kinetic"].traces
    chosen = found["shares-kinetic"].controls[0].options[0].traces
    total = sum(bars[k]["y"] for k in chosen)
    # parts below half a percent are left out
    assert (total > 98.5).all() and (total < 100.0 + 1e-9).all()
    looks = [(bars[k]["marker"]["color"], bars[k]["marker"]["pattern"]["shape"]) for k in chosen]
    assert len({pattern for _, pattern in looks}) == len(looks)


def test_viewer_in_a_browser(driver, tmp_path, viewed):
    """Bodies, orbits and controls are there and work, with no error on the console."""
    _, shown, engine, _ = viewed
    viewer = shapes.viewer(engine, shown)
    section = Section(name="mode-shapes", title="Mode shapes", blocks=[viewer])
    path = tmp_path / "viewer.html"
    path.write_text(page_html([section], title="Viewer", name="viewer"), encoding="utf-8")
    look_like(driver, 900, 800)
    open_page(driver, path)
    wait_for(driver, "return document.getElementById('mode-viewer').dataset.drawn")
    read = driver.execute_script
    host, plot = "document.getElementById('mode-viewer')", "document.querySelector('.viewer-plot')"
    kinds = read(f"return {plot}._fullData.map(t => t.type + ' ' + (t.mode || ''))")
    # two shafts and two disks
    assert kinds.count("mesh3d ") == 4
    assert "scatter3d text" in kinds
    found = read(
        f"return {plot}._fullData.filter(t => / orbit/.test(t.name))"
        ".map(t => [t.name, t.mode === 'lines' ? t.line.dash : t.marker.symbol])"
    )
    style = {
        "forward orbit": ["solid", "circle"],
        "backward orbit": ["dash", "square-open"],
        "orbit that is a line": ["dot", "diamond-open"],
    }
    assert found and all(look in style[name] for name, look in found)

    # what plays by itself stops on a slow machine, what was asked for does not
    pressed = "document.querySelector('.viewer-play').getAttribute('aria-pressed')"
    if read(f"return {pressed}") == "true":
        read("document.querySelector('.viewer-play').click()")
    read("document.querySelector('.viewer-play').click()")
    assert read(f"return {pressed}") == "true"
    before = float(read(f"return {host}.dataset.phase || '0'"))
    wait_for(driver, f"return Number({host}.dataset.phase) > {before}")
    read("document.querySelector('.viewer-play').click()")

    read(
        "const list = document.querySelector('.viewer-mode');"
        "list.selectedIndex = list.options.length - 1;"
        "list.dispatchEvent(new Event('change'))"
    )
    label = shown[1].texts[-1]
    wait_for(driver, f"return {host}.dataset.mode === {label!r}")
    assert label in read("return document.querySelector('.viewer-facts').textContent")
    read(
        "const list = document.querySelector('.viewer-view'); list.value = 'lines';"
        "list.dispatchEvent(new Event('change'))"
    )
    wait_for(driver, f"return !{plot}._fullData.some(t => t.type === 'mesh3d')")
    assert complaints(driver) == []
