"""The picture of a critical speed map shows what it is given."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.plots.maps import MapCurves, map_chart
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

WHIRLS = ("forward whirl", "backward whirl")


def test_map_shows_branches_operating_speeds_and_the_chosen_stiffness(three_disk, tmp_path, drawn):
    names = ["rotor.left", "rotor.right"]
    found = critical_speed_map(three_disk(), names, np.geomspace(1e5, 1e11, 7), branch_count=2)
    curves = MapCurves(
        bearings=names,
        stiffness_n_per_m=found.stiffness_n_per_m,
        speed_rpm=found.speed_rad_s * RPM_PER_RAD_S,
        whirl=found.whirl.tolist(),
        free_rpm=found.free_rad_s * RPM_PER_RAD_S,
        rigid_rpm=found.rigid_rad_s * RPM_PER_RAD_S,
        chosen={7e7: "left", 5e7: "right", 1e12: "beyond"},
    )
    speeds = {"cruise": 4775.0, "dash": 8594.0}
    draw_charts([map_chart(curves, speeds)], tmp_path / "m.png", "Map")
    (figure,) = drawn
    (axes,) = figure.axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    lines = [line for line in axes.lines if line.get_label() in WHIRLS]
    reached = sorted(float(line.get_ydata()[-1]) for line in lines)
    np.testing.assert_allclose(reached, np.sort(curves.speed_rpm[:, -1]), rtol=1e-12)
    texts = {text.get_text() for text in axes.texts}
    told = {f"operating speed of {name}, {rpm:.0f} rpm" for name, rpm in speeds.items()}
    assert {*told, "left", "right"} <= texts and "beyond" not in texts
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {
        *WHIRLS,
        "operating speed",
        "operating speed ±15 %",
        "operating speed ±20 %",
        "stiffness as chosen",
        "without these bearings",
        "with rigid bearings",
    }
    # the bands: 15 and 20 % on both sides
    boxes = [
        patch.get_path().transformed(patch.get_patch_transform()).get_extents().intervaly
        for patch in axes.patches
        if str(patch.get_label()).startswith("operating")
    ]
    expected = np.array([0.8, 0.85, 1.15, 1.2])[:, None] * np.array([*speeds.values()])
    np.testing.assert_allclose(np.unique(np.round(boxes, 6)), np.sort(expected.ravel()), rtol=1e-6)
