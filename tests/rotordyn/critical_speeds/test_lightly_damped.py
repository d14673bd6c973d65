"""Critical speeds refined from those without damping: against branches followed from rest."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, one_rotor, steel_shaft, table_law

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.critical_speeds import lightly_damped as light
from solidwhirl.rotordyn.critical_speeds.damped import followed_to_the_line

LIMIT = 1500.0


def _system(seed, damping_s=1e-5):
    """A shaft with disks on two unlike supports; one follows a table in every second."""
    rng = np.random.default_rng(seed)
    disks = [(0.2, 12.0, 0.12, 0.07), (0.45, 8.0, rng.uniform(0.02, 0.1), 0.03)]
    element = steel_shaft("r", np.linspace(0, 0.6, 7), 0.02, {"a": 0.0, "b": 0.6}, disks)
    stiffness = [np.diag(10 ** rng.uniform(6.0, 7.5, 2)) for _ in "ab"]
    law = None
    if seed % 2:
        factors = np.array([1.0, 1.6, 0.7])[:, None, None]
        law = table_law([0.0, 600.0, 2000.0], factors * stiffness[0], factors * stiffness[0] * 2e-5)
    return one_rotor(
        element,
        [
            connect(
                f"r.{end}",
                f"rotor.{end}",
                None,
                np.zeros((2, 2)) if end == "a" and law else k,
                np.zeros((2, 2)) if end == "a" and law else damping_s * k,
                speed_law=law if end == "a" else None,
            )
            for end, k in zip("ab", stiffness, strict=True)
        ],
    )


@pytest.mark.parametrize("ratio", [1.0, 2.5])
@pytest.mark.parametrize("seed", range(6))
def test_refined_and_followed_are_the_same(seed, ratio):
    system = _system(seed)
    found = light.lightly_damped(system, ratio, LIMIT)
    assert found is not None
    followed = sorted(followed_to_the_line(system, ratio, LIMIT), key=lambda m: m.speed)
    found = sorted(found, key=lambda m: m.speed)
    assert len(found) == len(followed) > 2
    for one, other in zip(found, followed, strict=True):
        assert one.speed == pytest.approx(other.speed, rel=1e-10)
        assert one.value == pytest.approx(other.value, rel=1e-9)
    assert len(rd.critical_speeds(system, ratio, LIMIT)) == len(found)


@pytest.mark.parametrize("at", [0, 1, -1])
def test_a_root_that_is_missing_or_there_twice_is_noticed(at, monkeypatch):
    """The count is of whole spectra, and knows nothing of the roots without damping."""
    system = _system(2)
    whole = light.undamped_critical_speeds(system, 1.0, LIMIT)
    kept = np.delete(np.arange(whole[0].size), at)
    for columns in (kept, np.append(kept, kept[0])):
        some = whole[0][columns], whole[1][:, columns]
        monkeypatch.setattr(light, "undamped_critical_speeds", lambda *_, s=some: s)
        monkeypatch.setattr(light, "undamped_places", lambda *_, s=some: s[0])
        assert light.lightly_damped(system, 1.0, LIMIT) is None


def test_much_damping_is_left_to_the_branches():
    assert light.lightly_damped(_system(2, 3e-3), 1.0, LIMIT) is None
