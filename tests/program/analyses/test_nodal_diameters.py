"""Nodal-diameter modes of scenes: documents, pages, datasets, and what is refused."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from solidwhirl.analyses.nodal_diameters.analysis import NodalDiametersSpec
from solidwhirl.core.blocks import Table, TurningModes
from solidwhirl.core.errors import SceneError
from solidwhirl.meshing import Sector
from solidwhirl.page.modes.shapes import turning_viewer
from solidwhirl.pipeline.cyclic_bodies import cyclic_source
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver

ALL = ["ux", "uy", "uz", "rx", "ry", "rz"]
BLADES = {
    "name": "row", "on": "ring", "count": 5, "length_m": 0.08,
    "chord_m": 0.01, "thickness_m": 0.003, "stagger_deg": 30,
}  # fmt: skip


def _data(blades=(), **asked):
    """A plate, or a ring with blades, its bore clamped; it turns twice as fast as the engine."""
    radii, length = ((0.03, 0.05), 0.02) if blades else ((0.1, 0.2), 0.01)
    rotor = {
        "material": "steel",
        "speed_ratio": 2.0,
        "sections": [
            {
                "name": "ring", "start_m": 0.0, "end_m": length,
                "inner_radius_m": radii[0], "outer_radius_m": radii[1],
            }
        ],
        "interfaces": [
            {"name": "bore", "kind": "inner", "coupling": "rigid", "start_m": 0.0, "end_m": length}
        ],
    }  # fmt: skip
    if blades:
        rotor["blades"] = [*blades]
    analysis = {"kind": "nodal_diameters", "body": "rotor", "held": ["bore"], "to_rpm": 3000.0}
    return {
        "name": "plate",
        "materials": {
            "steel": {
                "density_kg_per_m3": 7800.0, "youngs_modulus_pa": 2e11, "poissons_ratio": 0.3,
            }
        },
        "model": {
            "size_m": 0.02, "corner_size_m": 0.012, "modes": 6,
            "estimates": "off" if blades else "on",
        },
        "speeds": {"list_rpm": [0.0, 3000.0]},
        "campbell": {"branches": 2},
        "bodies": {"rotor": rotor},
        "bearings": [{"name": "clamp", "first": "rotor.bore", "rigid": ALL}],
        "operating": [{"shaft": "rotor", "from_rpm": 5000.0, "to_rpm": 5500.0}],
        "analyses": [analysis | {"count": 4, "modes": 2} | asked],
    }  # fmt: skip


def _run(*args, **asked):
    return run_scene(parse_scene(_data(*args, **asked)))


@pytest.fixture(scope="module")
def plate():
    return _run(nodal_diameters=[0, 2, 3], engine_orders=[2, 3, 50], probe="on")


@pytest.fixture(scope="module")
def bladed():
    asked = {"engine_order": 4, "standard_deviation": 0.02, "samples": 25}
    return _run((BLADES,), mistuning=asked, engine_orders=[4, 6])


def _told(results):
    return results.analyses["nodal_diameters"].blocks()


def test_frequencies_of_a_plate_by_direction(plate):
    """At rest both directions are one; turning, an observer at rest sees them f ∓ hΩ apart."""
    found = plate.analyses["nodal_diameters"].document
    assert found["nodal_diameter"] == [0, 2, 3] and found["standing"] == [True, False, False]
    np.testing.assert_allclose(found["speed_rpm"], [0.0, 1000.0, 2000.0, 3000.0])
    np.testing.assert_allclose(found["body_speed_rpm"], 2.0 * np.array(found["speed_rpm"]))
    assert found["sectors"] is None and found["root_stress"] is None
    backward, forward = (np.array(found["frequency_hz"][d]) for d in ("backward", "forward"))
    assert backward.shape == (3, 4, 2)
    np.testing.assert_allclose(backward[:, 0], forward[:, 0], rtol=1e-9)
    assert (backward[1:, 1:] > forward[1:, 1:]).any() and (backward[0] == forward[0]).all()
    errors = np.array(found["frequency_error_estimate"]["backward"])
    assert (errors > 0.0).all() and (errors < 0.2).all()
    seen = found["fixed_frame_hz"]
    assert seen["k"] == [0]
    turn = np.array(found["body_speed_rpm"])[None, :, None] / 60.0
    waves = np.array([0, 2, 3])[:, None, None]
    np.testing.assert_allclose(seen["backward"][0], np.abs(backward - waves * turn), rtol=1e-12)
    np.testing.assert_allclose(seen["forward"][0], forward + waves * turn, rtol=1e-12)


def test_crossings_lie_on_their_engine_orders(bladed):
    """A crossing has the frequency of the order, and of the branch between its samples."""
    found = bladed.analyses["nodal_diameters"].document
    assert found["sectors"] == 5 and found["nodal_diameter"] == [0, 1, 2]
    assert found["crossings"]
    for c in found["crossings"]:
        assert c["nodal_diameter"] == 1
        assert c["direction"] == {4: "forward", 6: "backward"}[c["engine_order"]]
        assert c["frequency_hz"] == pytest.approx(c["engine_order"] * c["body_speed_rpm"] / 60.0)
        branch = np.array(found["frequency_hz"][c["direction"]])[1, :, c["mode"] - 1]
        between = np.interp(c["speed_rpm"], found["speed_rpm"], branch)
        # a parabola between samples, of which stiffening makes some percent
        assert c["frequency_hz"] == pytest.approx(between, rel=0.02)
        low, high = 2500.0, 2750.0  # of the reference shaft
        nearer = min(max(c["speed_rpm"], low), high)
        assert c["margin"] == pytest.approx((c["speed_rpm"] - nearer) / nearer)


def test_mistuned_blades_and_root_stress(bladed):
    found = bladed.analyses["nodal_diameters"].document
    mistuning = found["mistuning"]
    assert mistuning["bound"] == pytest.approx(0.5 * (1.0 + np.sqrt(5.0)))
    factors = np.array(mistuning["amplification"]["factors"])
    assert len(factors) == 25 and (factors > 0.99).all() and (factors < mistuning["bound"]).all()
    assert len(mistuning["tuned_hz"]) == 5
    nominal = np.array(found["root_stress"]["nominal_pa_per_m"]["forward"])[:, 0, 0]
    # a slender blade that is clamped; the ring gives way and lowers the moment by some percent
    np.testing.assert_allclose(nominal, 3.516 * 2e11 * 0.0015 / 0.08**2, rtol=0.15)


def test_page(plate, bladed):
    for results, count in ((plate, 3), (bladed, 3)):
        told = _told(results)
        names = [block.name for block in told if isinstance(block, Chart)]
        assert names[:2] == ["blade-campbell", "interference"]
        assert ("blade-campbell-fixed" in names) == (results is plate)
        (shown,) = (block for block in told if isinstance(block, TurningModes))
        assert len(shown.states) == 2 * count
        viewer = turning_viewer(shown)
        assert viewer.data["pieces"][0]["kind"] == ("meridian" if results is plate else "sector")
        table = next(b for b in told if isinstance(b, Table) and "first and the last" in b.folded)
        assert ("root stress, nominal [MPa/mm]" in table.head) == (results is bladed)


def test_shapes_on_the_page_are_waves_of_unit_size(bladed):
    """The largest displacement is 1; both cut faces of the sector have the same points."""
    (shown,) = (block for block in _told(bladed) if isinstance(block, TurningModes))
    piece = turning_viewer(shown).data["pieces"][0]
    angle = 2.0 * np.pi / 5
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    edges = np.sort(
        np.concatenate([piece["cells"][:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    )
    found, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    outer = piece["points"][np.unique(found[count == 1])]
    gap = np.linalg.norm(outer[:, None] @ turn.T - outer, axis=2).min(axis=0)
    assert (gap < 1e-9).sum() * 2 == len(outer) > 8
    for _, modes in shown.states:
        for mode in modes:
            squares = (np.abs(mode.displacement) ** 2).sum(axis=1)
            turning = np.abs((mode.displacement**2).sum(axis=1))
            # single precision in the file
            assert np.sqrt(0.5 * (squares + turning)).max() == pytest.approx(1.0, rel=1e-5)
            assert mode.order <= 0 if mode.whirl == "forward" else mode.order >= 0


def test_datasets_and_scalars(plate, bladed):
    document = plate.analyses["nodal_diameters"].document
    labels = NodalDiametersSpec.labels(document)
    dims, values = labels.variables["frequency_hz"]
    assert dims == ("direction", "nodal_diameter", "speed_rpm", "mode")
    assert np.shape(values) == (2, 3, 4, 2)
    assert labels.coordinates["direction"][1] == ["backward", "forward"]
    assert np.shape(labels.variables["fixed_frame_hz"][1]) == (2, 1, 3, 4, 2)
    scalars = dict(NodalDiametersSpec.scalars(bladed.analyses["nodal_diameters"].document))
    lowest = np.min(bladed.analyses["nodal_diameters"].document["frequency_hz"]["backward"])
    assert scalars["lowest_frequency_hz"] == pytest.approx(lowest)
    assert 1.0 <= scalars["amplification_factor"] < 1.62
    assert (
        "root_nominal_pa_per_m"
        in NodalDiametersSpec.labels(bladed.analyses["nodal_diameters"].document).variables
    )


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"body": "stator"}, "stator"),
        ({"held": ["rim"]}, r"held\[0\].*'rim'.*bore"),
        ({"held": [], "nodal_diameters": [1]}, "1 moves the body as a whole"),
        ({"probe": True}, "probe"),
        ({"mistuning": {"engine_order": 4}}, "neither found"),
        (
            {"mistuning": {"engine_order": 4, "mode": 3, "standard_deviation": 0.01}},
            "mode = 3 is not among modes = 2",
        ),
        ({"mistuning": {"engine_order": 4, "blade_deviations": [0.0, 0.5, 0.0]}}, "at most 0.2"),
        ({"engine_orders": [0]}, "engine_orders"),
    ],
)
def test_bad_scenes_are_refused(asked, message):
    with pytest.raises(SceneError, match=message):
        parse_scene(_data(**asked))


@pytest.mark.parametrize(
    ("blades", "asked", "message"),
    [
        ((), {"mistuning": {"engine_order": 4, "standard_deviation": 0.01}}, "has no blades"),
        ([BLADES], {"nodal_diameters": [3]}, "3, but a body of 5 sectors has 0 to 2"),
        (
            [BLADES],
            {"mistuning": {"engine_order": 4, "blade_deviations": [0.01] * 4}},
            "blade_deviations: 4 given, but 'rotor' has 5 sectors",
        ),
    ],
)
def test_what_a_body_can_not_be_asked(blades, asked, message):
    """Before anything is meshed."""
    with pytest.raises(SceneError, match=message):
        parse_scene(_data(blades, **asked))


def test_stages_without_a_common_sector_are_refused():
    sectors = tuple(Sector(count=n, mirrored=True) for n in (24, 31, 37))
    mesh = SimpleNamespace(parts=SimpleNamespace(sectors=sectors), dimension=3, sector=sectors[0])
    with pytest.raises(AnalysisError, match="'drum' is made of parts with 24, 31, 37 sectors"):
        cyclic_source(None, {"drum": SimpleNamespace(mesh=mesh)}, "drum")
