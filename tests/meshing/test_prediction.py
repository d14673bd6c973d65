"""The prediction of a solid mesh's size against the mesh that is made."""

from __future__ import annotations

import pytest

from solidwhirl.meshing import MeshSize, mesh_solid, predict_unknowns


@pytest.mark.parametrize(("corner", "growth"), [(8e-3, 0.8), (3e-3, 0.6), (1.5e-3, 0.6)])
def test_prediction_within_a_factor_of_two(reference_rotor, corner, growth):
    size = MeshSize(
        size_m=0.1, corner_size_m=corner, growth=growth, through_thickness=1.2, around=12
    )
    made = 3 * len(mesh_solid(reference_rotor, size).points)
    assert 0.5 < predict_unknowns(reference_rotor, size) / made < 2.0
