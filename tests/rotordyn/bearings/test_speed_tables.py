"""Tables over the speed: as close as they say, between rows too."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError, TableLaw
from solidwhirl.rotordyn.bearings.short_bearing import journal_state
from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.bearings.speed_tables import tabulate

OIL = ShortFilm(diameter_m=0.1, length_m=0.03, radial_clearance_m=1e-4, viscosity_pa_s=0.1)


def film_at(speed):
    return journal_state(OIL, (300.0, -525.0), speed)[3:]


def test_law_of_a_table_is_the_bearing_at_speeds_between_its_rows():
    table = tabulate(film_at, 30.0, 600.0)
    law, zero = TableLaw(name="film", **table._asdict()), np.zeros((2, 2))
    for speed in np.random.default_rng(1).uniform(30.0, 600.0, 60):
        for found, exact in zip(law.coefficients(speed, zero, zero), film_at(speed), strict=True):
            assert np.abs(found - exact).max() < 1e-4 * np.abs(exact).max()
    assert table.speeds_rad_s.size < 400


def test_empty_range():
    with pytest.raises(AnalysisError, match="0 <= low < high"):
        tabulate(film_at, 5.0, 5.0)
