"""What a run says of the accuracy of beams by stations, and of margins judged on them."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.rotordyn.beams.elements import shear_coefficient
from solidwhirl.scene_reading.reader import parse_scene

RADIUS, E, NU, RHO = 0.02, 2e11, 0.3, 7850.0
STEEL = {"youngs_modulus_pa": E, "poissons_ratio": NU, "density_kg_per_m3": RHO}


def pinned_rpm():
    """First forward critical speed of a Timoshenko shaft of 1 m on rigid bearings.

    With the spin a cross-section adds ρI k² (1 − Ip/Id) ω² = −ρI k² ω² in synchronous whirl.
    """
    area, second = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
    shear, k = shear_coefficient(NU, 0.0) * E / (2.0 * (1.0 + NU)), np.pi
    # D = [[κGA k² − ρA ω², κGA k], [κGA k, κGA + EI k² + ρI ω²]] is singular
    g = shear * area
    roots = np.roots([
        -RHO * area * RHO * second,
        g * k**2 * RHO * second - RHO * area * (g + E * second * k**2),
        g * k**2 * E * second * k**2,
    ])  # fmt: skip
    return float(np.sqrt(roots[roots > 0.0].min()) * 30.0 / np.pi)


def run(elements, high_rpm):
    place = {"left": 0.0, "right": 1.0}
    data = {
        "name": "shaft",
        "model": {"accuracy": 0.01},
        "materials": {"plain": STEEL},
        "speeds": {"to_rpm": 8000, "count": 3},
        "campbell": {"branches": 2},
        "beams": {
            "rotor": {
                "material": "plain",
                "stations_m": np.linspace(0.0, 1.0, elements + 1).tolist(),
                "outer_radius_m": [RADIUS] * elements,
                "interfaces": place,
            }
        },
        "bearings": [
            {"name": n, "first": f"rotor.{n}", "rigid": ["ux", "uy"]} for n in place
        ],
        "operating": [{"shaft": "rotor", "from_rpm": 3000, "to_rpm": high_rpm}],
        "analyses": [{"kind": "separation_margins", "method": "percent", "percent": 8.0}],
    }  # fmt: skip
    document = results_document(run_scene(parse_scene(data)))
    return document, {a.about.split(" (")[0]: a for a in answers(document)}


def test_one_element_is_not_met_and_its_margin_not_decided():
    """The true critical speed lies inside the operating speeds."""
    exact = pinned_rpm()
    document, said = run(1, 1.005 * exact)
    (forward,) = [c for c in document["critical_speeds"] if c["whirl"] == "forward"]
    error = 1.0 - exact / forward["speed_rpm"]
    assert error > 0.09
    assert error <= forward["frequency_error_estimate"] < 2.0 * error
    assert document["accuracy"]["met"] is False and said["Accuracy"].text.startswith("NOT met")
    margins = said["Separation margins"]
    assert document["verdict"]["margins"]["passed"] and margins.good is None
    assert "not decided" in margins.text


def test_many_elements_are_met_and_their_margin_decided():
    exact = pinned_rpm()
    document, said = run(6, exact / 1.1)
    (forward,) = [c for c in document["critical_speeds"] if c["whirl"] == "forward"]
    error = 1.0 - exact / forward["speed_rpm"]
    assert 0.0 < error <= forward["frequency_error_estimate"] < 2.0 * error
    assert document["accuracy"]["met"] is True and said["Accuracy"].good
    assert said["Separation margins"].good is True
    worst = document["analyses"]["separation_margins"]["margins"][0]
    assert worst["error_estimate"] == pytest.approx(
        max(c["frequency_error_estimate"] for c in document["critical_speeds"]), rel=0.5
    )
