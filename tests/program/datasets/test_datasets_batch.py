"""The table of a batch, and peaks of responses, as datasets: every number at its place."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.batch.journal import BatchTableError, open_journal
from solidwhirl.batch.table import write_table
from solidwhirl.datasets.results import datasets, peaks_dataset
from solidwhirl.sweep.records import BatchRow


def row(number, **changes):
    values = {
        "critical_speed_rpm": (1000.0, 2000.0 + number),
        "critical_frequency_hz": (16.0, 33.0),
        "critical_whirl": ("backward", "forward"),
        "critical_error_estimate": (1e-3, float("nan")),
        "campbell_speed_rpm": (0.0, 500.0, 1000.0),
        "campbell_frequency_hz": ((1.0, 2.0, 3.0 + number),),
        "campbell_log_decrement": ((0.1, 0.2, 0.3),),
        "responses": {"unbalance.rotor.disk.peak_amplitude_m": 1e-6 * number},
        "values": {"k_n_per_m": 1e7 * number, "level": "beam"},
        "seconds": 2.0,
    }
    return BatchRow(case=f"s-000{number}", scene="s", status="done", **{**values, **changes})


ROWS = (
    row(1),
    BatchRow(case="s-0002", scene="s", status="failed", message="no", values={"k_n_per_m": 2e7}),
    row(3, critical_speed_rpm=(900.0,), critical_frequency_hz=(15.0,), critical_whirl=("forward",),
        critical_error_estimate=(0.5,)),
)  # fmt: skip


def folder_of(path, rows):
    with open_journal(path) as journal:
        for one in rows:
            journal.append(one)
    write_table(path)
    return path


@pytest.mark.parametrize("kept", ["batch.jsonl", "table.h5"])
def test_a_batch_has_cases_and_parameters(tmp_path, kept):
    folder = folder_of(tmp_path, ROWS)
    for name in {"batch.jsonl", "table.h5"} - {kept}:
        (folder / name).unlink()
    tree = datasets(folder)
    assert tree.name == tmp_path.name
    assert tree["status"].values.tolist() == ["done", "failed", "done"]
    assert tree["message"].sel(case="s-0002") == "no"
    critical = tree["critical_speeds"].to_dataset()
    assert critical.speed_rpm.dims == ("case", "critical_speed")
    assert critical.speed_rpm.sel(case="s-0001", critical_speed=2) == 2001.0
    assert np.isnan(critical.speed_rpm.sel(case="s-0002")).all()
    assert critical.whirl.sel(case="s-0003").values.tolist() == ["forward", ""]
    assert critical.k_n_per_m.values.tolist() == [1e7, 2e7, 3e7]
    assert critical.k_n_per_m.units == "N/m"
    assert critical.level.values.tolist() == ["beam", "", "beam"]
    diagram = tree["campbell"].to_dataset()
    assert diagram.frequency_hz.sel(case="s-0003", branch=1, speed_rpm=1000) == 6.0
    assert np.isnan(diagram.log_decrement.sel(case="s-0002")).all()
    peak = tree["responses"].to_dataset()["unbalance.rotor.disk.peak_amplitude_m"]
    assert peak.units == "m"
    np.testing.assert_array_equal(peak.values, [1e-6, np.nan, 3e-6])


def test_diagrams_of_other_speeds_keep_their_own(tmp_path):
    other = row(4, campbell_speed_rpm=(0.0, 700.0), campbell_frequency_hz=((5.0, 6.0),),
                campbell_log_decrement=((0.0, 0.0),), values={"speed_rpm": 3.0})  # fmt: skip
    diagram = datasets(folder_of(tmp_path, [ROWS[0], other]))["campbell"].to_dataset()
    assert diagram.frequency_hz.dims == ("case", "branch", "speed")
    np.testing.assert_array_equal(diagram.speed_rpm.sel(case="s-0004"), [0.0, 700.0, np.nan])
    # the name of a parameter that is taken
    np.testing.assert_array_equal(diagram.parameter_speed_rpm, [np.nan, 3.0])


def test_a_damaged_batch_is_told(tmp_path):
    (tmp_path / "table.h5").write_bytes(b"no")
    with pytest.raises(BatchTableError, match="is no table of a batch"):
        datasets(tmp_path)


def peak(speed_rpm, amplitude_m, **more):
    return {
        **{"speed_rpm": speed_rpm, "frequency_hz": speed_rpm / 60.0, "amplitude_m": amplitude_m},
        **{"amplification": None, **more},
    }


def test_peaks_of_a_response_are_rows():
    error = {"frequency_error_estimate": 1e-4, "amplitude_error_estimate": None}
    document = {
        "kind": "unbalance_response",
        "exciters": [
            {"bodies": ["a", "b"], "peaks": {"a.x": [peak(600.0, 1e-6, **error)], "b.y": []}},
            {"bodies": ["c"], "peaks": {"a.x": [], "b.y": [peak(900.0, 2e-6, **error)]}},
        ],
    }
    found = peaks_dataset(document)
    assert found.place.values.tolist() == ["a.x", "b.y"]
    assert found.exciter.values.tolist() == ["a, b", "c"]
    assert found.speed_rpm.values.tolist() == [600.0, 900.0]
    units = {name: found[name].units for name in ("speed_rpm", "frequency_hz", "amplitude_m")}
    assert units == {"speed_rpm": "rpm", "frequency_hz": "Hz", "amplitude_m": "m"}
    assert found.frequency_error_estimate.values.tolist() == [1e-4, 1e-4]
    assert np.isnan(found.amplification).all()
    none = peaks_dataset({"kind": "place_map", "peaks": {"a.x": []}})
    assert none.sizes == {"peak": 0}
    assert peaks_dataset({"kind": "stability"}) is None
