"""Journal, table and rows of a batch: what is written is there, whatever ends the writer."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import asdict, replace

import h5py
import numpy as np
import pytest
from ring_scenes import STIFFNESS, ring_scene, written

from solidwhirl.batch.journal import (
    BatchTableError,
    open_journal,
    read_journal,
    row_document,
    salvaged_rows,
)
from solidwhirl.batch.rows import failed_row, responses_of, row_of_document
from solidwhirl.batch.table import TABLE, read_batch, read_table, write_table
from solidwhirl.console.exit_handling import Terminated
from solidwhirl.core.errors import OutputError
from solidwhirl.files.run_folder import JOURNAL
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.sweep.cases import batch_cases, case_scene
from solidwhirl.sweep.records import BatchRow, distinct_warnings

NAN = float("nan")
# Rows that differ in all lengths, with texts that files may stumble over.
ROWS = (
    BatchRow(
        case="a-0001",
        scene="a",
        status="done",
        values={"k_n_per_m": 1e7, "level": "harmonic"},
        digest="ab" * 32,
        method="sobol",
        sweep_cases=8,
        seconds=1.5,
        peak_memory_gib=0.25,
        ranks=2,
        critical_speed_rpm=(1000.0, 1 / 3),
        critical_frequency_hz=(16.0, 5e-324),
        critical_whirl=("forward", ""),
        critical_error_estimate=(1e-9, NAN),
        campbell_speed_rpm=(0.0, 500.0, 1000.0),
        campbell_frequency_hz=((1.0, 2.0, NAN), (3.0, 4.0, 5.0)),
        campbell_log_decrement=((0.0, -0.1, NAN), (0.1, 0.2, 0.3)),
        responses={"unbalance.rotor.disk.peak_amplitude_m": 1e-6},
    ),
    BatchRow(
        case="a-0002",
        scene="a",
        status="failed",
        message='größer als "Ω"; Zeile 2\n日本語 \\',
        warnings=("bearings[0]: 1e13 N/m; usual is less", "5 rpm: unstable"),
        values={"k_n_per_m": -1e30, "level": "beam"},
    ),
    BatchRow(
        case="b",
        scene="b",
        status="checks_failed",
        message="check failed",
        critical_speed_rpm=(7.0,),
        critical_frequency_hz=(8.0,),
        critical_whirl=("backward",),
        critical_error_estimate=(0.5,),
        campbell_speed_rpm=(0.0,),
        campbell_frequency_hz=((9.0,), (10.0,), (11.0,)),
        campbell_log_decrement=((NAN,), (0.0,), (0.0,)),
        responses={"margins.rotor.smallest_margin": 0.2},
    ),
)


def same(first, second):
    """Equal rows; nan equals nan."""
    return repr([asdict(r) for r in first]) == repr([asdict(r) for r in second])


@pytest.fixture
def batch(tmp_path):
    """A folder with a journal, written in another order than that of the cases."""
    with open_journal(tmp_path) as journal:
        for row in ROWS[::-1]:
            journal.append(row)
    return tmp_path


def opened_again(folder):
    """The journal as a batch that goes on has it."""
    return open_journal(folder, salvaged_rows(folder)[0])


def full_disk(*arguments, **more):
    raise OSError(28, "No space left on device")


# -- journal --------------------------------------------------------------------------------------


def test_journal_holds_what_was_appended(batch):
    assert same(read_journal(batch), ROWS[::-1])
    assert same(read_batch(batch), ROWS)
    assert read_batch(batch) == read_batch(batch)  # absent numbers too
    for line in (batch / JOURNAL).read_text(encoding="utf-8").splitlines():
        assert json.loads(line)["schema"] == "solidwhirl-batch-1"


def test_each_row_is_on_the_disk_when_append_returns(tmp_path, monkeypatch):
    sizes = []
    with open_journal(tmp_path) as journal:
        monkeypatch.setattr(os, "fsync", lambda file: sizes.append(os.fstat(file).st_size))
        for count, row in enumerate(ROWS, 1):
            journal.append(row)
            assert len(sizes) == count
            assert sizes[-1] == (tmp_path / JOURNAL).stat().st_size  # nothing was left to write
            assert same(read_journal(tmp_path), ROWS[:count])


def test_last_row_of_a_case_counts(batch):
    better = replace(ROWS[1], status="done", message="")
    with opened_again(batch) as journal:
        journal.append(better)
        assert len(journal.rows) == 3
    assert same(read_batch(batch), (ROWS[0], better, ROWS[2]))


@pytest.mark.parametrize("kept", [0.0, 0.1, 0.9, 1.0, None])
def test_torn_last_line_is_ignored_and_written_over(batch, kept):
    """Cut anywhere in the last line, before its line end; None: its blocks never came."""
    path = batch / JOURNAL
    lines = path.read_bytes().splitlines(keepends=True)
    length = len(lines[-1]) - 1
    torn = bytes(length) + b"\n" if kept is None else lines[-1][: int(kept * length)]
    path.write_bytes(b"".join(lines[:-1]) + torn)
    assert same(read_journal(batch), (ROWS[2], ROWS[1]))
    with opened_again(batch) as journal:
        assert same(journal.rows, (ROWS[2], ROWS[1]))
        journal.append(ROWS[0])
    assert path.read_bytes() == b"".join(lines)


def test_damage_before_the_last_line_is_told(batch):
    path = batch / JOURNAL
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + lines[1][:20] + b"\n" + lines[2])
    with pytest.raises(BatchTableError, match=rf"^{path}: line 2: is damaged$"):
        read_batch(batch)
    assert same(salvaged_rows(batch)[0], (ROWS[2], ROWS[0]))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("schema", "solidwhirl-batch-0", r"line 2: is no row of a batch \(solidwhirl-batch-1\)"),
        ("status", "perhaps", "line 2: status: 'perhaps': Input should be 'done', 'failed' or '"),
        ("seconds", "1.5", "line 2: seconds: '1.5': Input should be a valid number"),
        ("case", 5, "line 2: case: 5: Input should be a valid string"),
        ("critical_speed_rpm", 10**400, "line 2: critical_speed_rpm: "),
        ("method", None, "line 2: method: None: Input should be a valid string"),
        ("campbell_frequency_hz", [[10**400]], "line 2: campbell_frequency_hz: "),
        ("values", [], "line 2: values: "),
    ],
)
def test_wrong_row_is_told_with_its_key(batch, key, value, message):
    path = batch / JOURNAL
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[1] = json.dumps(json.loads(lines[1]) | {key: value})
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(BatchTableError, match=message):
        read_batch(batch)


@pytest.mark.parametrize("ending", ["full", "asked"])
def test_append_that_ends_early_leaves_no_part_of_a_line(batch, monkeypatch, ending):
    """A full disk, and SIGTERM, which raises an exception wherever the program is."""

    def full(file, data, offset):
        pwrite(file, data[:50], offset)
        full_disk()

    def interrupted(file):
        raise Terminated

    pwrite, before = os.pwrite, (batch / JOURNAL).read_bytes()
    with opened_again(batch) as journal:
        if ending == "full":
            monkeypatch.setattr(os, "pwrite", full)
            refused = pytest.raises(OutputError, match=rf"{batch / JOURNAL}: .*No space left")
        else:
            monkeypatch.setattr(os, "fsync", interrupted)
            refused = pytest.raises(Terminated)
        with refused:
            journal.append(replace(ROWS[0], case="c"))
        monkeypatch.undo()
        assert (batch / JOURNAL).read_bytes() == before
        assert len(journal.rows) == 3
        journal.append(replace(ROWS[0], case="c"))
    assert len(read_batch(batch)) == 4


def test_no_batch_is_told(tmp_path):
    with pytest.raises(BatchTableError, match=f"{tmp_path}: has neither {JOURNAL} nor {TABLE}"):
        read_batch(tmp_path)
    with (
        pytest.raises(OutputError, match="No such file or directory"),
        open_journal(tmp_path / "none"),
    ):
        pass


# -- table ----------------------------------------------------------------------------------------


def test_table_is_made_from_the_journal_again_and_again(batch):
    path = write_table(batch)
    assert same(read_table(path), ROWS)
    with opened_again(batch) as journal:
        journal.append(replace(ROWS[2], status="done", message="", responses={}))
    assert same(read_table(write_table(batch)), read_batch(batch))
    path.write_bytes(b"damaged")
    rows = read_batch(batch)
    assert same(read_table(write_table(batch)), rows)
    assert sorted(p.name for p in batch.iterdir()) == [JOURNAL, TABLE]
    (batch / JOURNAL).unlink()
    assert same(read_batch(batch), rows)


def test_table_of_no_rows_and_of_rows_without_results(tmp_path):
    with open_journal(tmp_path) as journal:
        assert read_table(write_table(tmp_path)) == ()
        journal.append(ROWS[1])
        assert same(read_table(write_table(tmp_path)), ROWS[1:2])


def test_table_that_can_not_be_written_stays_as_it_was(batch, monkeypatch):
    path = write_table(batch)
    before = path.read_bytes()
    monkeypatch.setattr(h5py.File, "create_group", full_disk)
    with pytest.raises(OutputError, match=rf"{path}: can not be written: No space left"):
        write_table(batch)
    assert path.read_bytes() == before
    assert sorted(p.name for p in batch.iterdir()) == [JOURNAL, TABLE]


@pytest.mark.parametrize("damage", ["text", "schema", "missing", "status"])
def test_damaged_table_is_told(batch, damage):
    path = write_table(batch)
    (batch / JOURNAL).unlink()
    if damage == "text":
        path.write_text("no HDF5")
    else:
        with h5py.File(path, "r+") as file:
            if damage == "schema":
                file.attrs["schema"] = "else"
            elif damage == "missing":
                del file["critical_count"]
            else:
                file["status"][0] = "perhaps"
    with pytest.raises(BatchTableError, match=f"^{path}: "):
        read_batch(batch)


READER = """
import sys
import h5py
import numpy as np
with h5py.File(sys.argv[1]) as f:
    assert f.attrs["schema"] == "solidwhirl-batch-1"
    assert f["case"].asstr()[:].tolist() == ["a-0001", "a-0002", "b"]
    assert f["message"].asstr()[1].startswith('größer als "Ω"')
    assert f["status"].asstr()[:].tolist() == ["done", "failed", "checks_failed"]
    k = f["values/k_n_per_m"][:]
    assert k[0] == 1e7 and k[1] == -1e30 and np.isnan(k[2])
    assert f["value_texts/level"].asstr()[:].tolist() == ["harmonic", "beam", ""]
    np.testing.assert_array_equal(
        f["critical_speed_rpm"][:], [[1000, 1 / 3], [np.nan] * 2, [7, np.nan]]
    )
    assert f["critical_whirl"].asstr()[:].tolist() == [["forward", ""], ["", ""], ["backward", ""]]
    assert f["critical_count"][:].tolist() == [2, 0, 1]
    branches = f["campbell_frequency_hz"]
    assert branches.shape == (3, 3, 3)
    np.testing.assert_array_equal(branches[0], [[1, 2, np.nan], [3, 4, 5], [np.nan] * 3])
    assert np.isnan(branches[1]).all()
    np.testing.assert_array_equal(branches[2, :, 0], [9, 10, 11])
    peak = f["responses/unbalance.rotor.disk.peak_amplitude_m"][:]
    assert peak[0] == 1e-6 and np.isnan(peak[1:]).all()
    told = {}
    f.visititems(lambda name, node: told.update({name: dict(node.attrs)}))
    assert all(a["holds"] for a in told.values()), told
    assert told["seconds"]["unit"] == "s" and told["critical_speed_rpm"]["unit"] == "rpm"
    assert told["responses/unbalance.rotor.disk.peak_amplitude_m"]["unit"] == "m"
    assert told["case"]["unit"] == ""
    listed = []
    f.visititems(lambda name, node: listed.append(name) if isinstance(node, h5py.Dataset) else None)
print(sorted(m for m in sys.modules if m.startswith("solidwhirl")), *listed)
"""


def test_h5py_and_numpy_alone_read_the_table(batch, root):
    """In a process that knows nothing of the program; and the page lists every dataset."""
    done = subprocess.run(
        [sys.executable, "-I", "-c", READER, str(write_table(batch))],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    imported, *listed = done.stdout.split()
    assert imported == "[]"
    page = (root / "docs" / "batch.md").read_text(encoding="utf-8")
    for name in listed:
        group = name.split("/")[0]
        shown = f"{group}/<" if "/" in name else f"`{name}`"
        assert shown in page, name


# -- rows -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rigid_case(tmp_path_factory):
    """A rigid, turning ring on two equal bearings, each case with another mass and stiffness."""
    mass = {"name": "m", "places": ["rigid_bodies.ring.mass_kg"], "values": [5, 4]}
    data = ring_scene(
        {"method": "list", "parameters": [{**STIFFNESS, "name": "k", "values": [1e5, 4e5]}, mass]},
        analyses=[
            {"kind": "stability", "to_rpm": 6000, "count": 5},
            {
                "name": "margins",
                "kind": "separation_margins",
                "operating": [{"shaft": "ring", "from_rpm": 2500, "to_rpm": 3000}],
            },
        ],
    )
    return batch_cases([written(tmp_path_factory.mktemp("ring"), data)])


@pytest.mark.solver
@pytest.mark.parametrize("number", [0, 1])
def test_row_of_a_rigid_body_on_springs_in_closed_form(rigid_case, number):
    """Translation at sqrt(2 k / m); tilt, with c = 2 k a^2: Id w^2 -+ Ip W w - c = 0.

    At W = w backward tilt is met where (Id + Ip) W^2 = c, forward never: Ip > Id.
    """
    case = rigid_case[number]
    row = row_of_document(case, results_document(run_scene(case_scene(case))), 2.5, 3)
    k, m = case.values["k"], case.values["m"]
    level = np.sqrt(2 * k / m)
    tilt, inertia, polar = 2 * k * 0.1**2, 0.2, 0.3
    backward = np.sqrt(tilt / (inertia + polar))
    half = 0.5 * polar * np.linspace(0.0, 6000.0, 4) * np.pi / 30
    root = np.sqrt(half**2 + inertia * tilt)
    expected = [(root - half) / inertia, (root + half) / inertia, *[0 * half + level] * 2]
    found = 2 * np.pi * np.sort(row.campbell_frequency_hz, axis=0)
    # the same matrices in other coordinates: round-off alone
    np.testing.assert_allclose(found, np.sort(expected, axis=0), rtol=1e-9)
    wanted = sorted([(level, "backward"), (level, "forward"), (backward, "backward")])
    speeds = np.array([speed for speed, _ in wanted])
    np.testing.assert_allclose(row.critical_speed_rpm, speeds * 30 / np.pi, rtol=1e-9)
    np.testing.assert_allclose(row.critical_frequency_hz, speeds / 2 / np.pi, rtol=1e-9)
    assert sorted(row.critical_whirl) == sorted(w for _, w in wanted)
    np.testing.assert_allclose(row.campbell_speed_rpm, [0, 2000, 4000, 6000], rtol=1e-12)
    assert np.abs(row.campbell_log_decrement).max() < 1e-9
    assert (row.status, row.message, row.seconds, row.ranks) == ("done", "", 2.5, 3)
    assert (row.case, row.scene, row.digest) == (f"ring-000{number + 1}", "ring", case.digest)
    # only the forward one is excited by unbalance; search ends at 1.3 times 3000 rpm
    rpm = level * 30 / np.pi
    off = 1 - rpm / 2500 if rpm < 2500 else np.nan  # one case is below, the other beyond the search
    smallest = row.responses.get("margins.ring.smallest_margin", np.nan)
    assert smallest == pytest.approx(off, rel=1e-7, nan_ok=True)
    assert row.responses["stability.smallest_log_decrement"] == 0.0
    assert row.responses["verdict.stable"] == 1.0
    assert row.responses["verdict.first_forward_log_decrement"] == 0.0
    assert "stability.threshold_speed_rpm" not in row.responses


DOCUMENT = {
    "critical_speeds": [
        {"speed_rpm": 900.0, "frequency_hz": 15.0, "whirl": "forward", "kind": "lateral"},
        {
            "speed_rpm": 600.0,
            "frequency_hz": 10.0,
            "whirl": None,
            "kind": "torsional",
            "frequency_error_estimate": 1e-3,
        },
    ],
    "campbell": {"speed_rpm": [0.0], "frequency_hz": [[None]], "log_decrement": [[None]]},
    "invariants": [
        {"name": "mass symmetric", "where": "rotor", "passed": False},
        {"name": "open", "where": "rotor", "passed": None},
    ],
    "analyses": {},
    "verdict": {
        "stable": False,
        "unstable_from_rpm": 700.0,
        "at_operating": [
            {"first_forward": {"log_decrement": 0.2, "frequency_hz": 9.0}},
            {"first_forward": {"log_decrement": -0.1, "frequency_hz": 9.0}},
        ],
        "margins": {"passed": None, "decided": None},
        "accuracy": {"met": None, "not_estimated": ["rotor"]},
        "vibration": [
            {"at_operating": {"peak_to_peak_um": 30.0}},
            {"at_operating": None},
        ],
    },
    "doubts": [{"message": "700 rpm: unstable"}, {"message": "700 rpm:\nunstable"}],
    "accuracy": {"met": False, "largest_error_estimate": 0.02, "asked": 0.01, "rounds": []},
    "bearing_notes": ["film: used beyond its table"] * 2,
    "peak_memory_gib": None,
}


def test_row_of_a_document_with_nulls_and_a_failed_check(rigid_case):
    row = row_of_document(rigid_case[0], DOCUMENT, 1.0, 1)
    said = "check failed: rotor: mass symmetric; not estimated: rotor"
    assert (row.status, row.message) == ("checks_failed", said)
    # each once, and each in one line
    film = "film: used beyond its table"
    missed = "accuracy not met: estimated error 2 %, asked 1 %"
    assert row.warnings == ("700 rpm: unstable", "700 rpm:\\nunstable", film, missed)
    assert row.responses == {
        "verdict.stable": 0.0,
        "verdict.unstable_from_rpm": 700.0,
        "verdict.first_forward_log_decrement": -0.1,
        "verdict.largest_vibration_um": 30.0,
    }
    assert row.critical_speed_rpm == (600.0, 900.0)
    assert row.critical_whirl == ("", "forward")
    assert row.critical_kind == ("torsional", "lateral")
    np.testing.assert_array_equal(row.critical_error_estimate, [1e-3, NAN])
    np.testing.assert_array_equal(row.campbell_frequency_hz, [[NAN]])
    assert np.isnan(row.peak_memory_gib)


def test_warning_of_many_cases_is_one_with_the_first_and_their_number():
    """Numbers that stand alone differ between the cases of a sweep; those in names do not."""

    def warned(case, *texts):
        return BatchRow(case=case, scene="s", status="done", warnings=texts)

    rows = (
        warned("s-0010", "bearings[0]: 2.5e+13 N/m", "'disk1' is off"),
        warned("s-0002", "bearings[0]: 1e13 N/m", "bearings[1]: 1e13 N/m"),
        warned("s-0001"),
        warned("s-0011", "'disk2' is off", "hp-2 at -3.5 rpm", "hp-2 at 40 rpm"),
    )
    assert distinct_warnings(rows) == [
        "bearings[0]: 1e13 N/m [2 cases, first s-0002]",
        "bearings[1]: 1e13 N/m [s-0002]",
        "'disk1' is off [s-0010]",
        "'disk2' is off [s-0011]",
        "hp-2 at -3.5 rpm [s-0011]",
    ]
    assert distinct_warnings(ROWS[:1]) == []


def test_row_of_a_failure(rigid_case, tmp_path):
    said = ["warning: mass in t?", "mesh rotor", "warning: 3 rpm"]
    row = failed_row(rigid_case[1], "no\x00t \x1b[31mred\nsecond line", 3.0, 2, 0.5, said=said)
    assert row.warnings == ("mass in t?", "3 rpm")
    assert row.status == "failed"
    assert row.message == "no\\x00t \\x1b[31mred\nsecond line"
    assert (row.values, row.seconds, row.ranks) == ({"k": 4e5, "m": 4}, 3.0, 2)
    with open_journal(tmp_path) as journal:
        journal.append(row)
        journal.append(replace(row, case="raw", message="nul \x00 and \udcff"))
    assert same(read_table(write_table(tmp_path)), read_batch(tmp_path))
    assert json.loads(json.dumps(row_document(row)))["message"] == row.message


PEAK = {"frequency_hz": 10.0, "speed_rpm": 600.0, "amplitude_m": 2e-6, "amplification": None}
PEAKS = [{**PEAK, "amplitude_m": 1e-6, "speed_rpm": 300.0}, PEAK]
EXCITER = {
    "places": {"r.d": {"major_m": [None, 1e-6, 3e-6]}},
    "peaks": {"r.d": PEAKS},
    "bearing_force_n": {"front": [1.0, 5.0, None]},
}
EXCITED = {
    "r.d.largest_amplitude_m": 3e-6,
    "r.d.peak_amplitude_m": 2e-6,
    "r.d.peak_speed_rpm": 600.0,
    "front.largest_force_n": 5.0,
}
MARGIN = {"shaft": "r", "margin": -0.3, "required_api_617": 0.1, "verdict_api_617": "ok"}
MARGIN |= {"exciters": ["unbalance"]}
INSIDE = {"required_api_617": None, "verdict_api_617": "inside margin"}
STRESSED = {"largest_displacement_m": 1e-3, "steady": None}
STRESSED |= {"dynamic": {"largest_von_mises_pa": 1e6}, "total": {"largest_von_mises_pa": 2e6}}
CHOSEN = {"chosen_stiffness_n_per_m": 1e7, "chosen_amplitude_m": 1e-5}
# Documents as docs/scene.md describes them, and what stands in the row.
RESPONSES = [
    ("unbalance_response", {"exciters": [{"bodies": ["r"], **EXCITER}]}, EXCITED),
    (
        "unbalance_response",
        {"exciters": [{"bodies": [body], **EXCITER} for body in "rs"]},
        {f"{body}.{key}": value for body in "rs" for key, value in EXCITED.items()},
    ),
    (
        "place_map",
        {
            "places": ["r.a", "r.b"],
            "amplitude_m": [[1.0, 2.0], [3.0, None]],
            "peaks": {"r.a": [PEAK], "r.b": []},
        },
        {
            "r.a.largest_amplitude_m": 2.0,
            "r.a.peak_amplitude_m": 2e-6,
            "r.a.peak_speed_rpm": 600.0,
            "r.b.largest_amplitude_m": 3.0,
        },
    ),
    (
        "waterfall",
        {"observed": "r.a", "highest_m": [[1.0, None], [4.0, 2.0]]},
        {"r.a.largest_amplitude_m": 4.0},
    ),
    ("stiffness_study", CHOSEN, CHOSEN),
    (
        "separation_margins",
        {
            "operating": [{"shaft": "r"}, {"shaft": "s"}, {"shaft": "t"}],
            "verdict": {"passed": False},
            "margins": [
                MARGIN,
                # no unbalance excites this one, which is the nearest
                MARGIN | {"margin": 0.01, "verdict_api_617": "inside margin", "exciters": []},
                MARGIN | {"shaft": "s", "margin": 0.0} | INSIDE,
                MARGIN | {"margin": 0.15, "required_api_617": 0.2},
            ],
        },
        {
            "passed": 0.0,
            "r.smallest_margin": 0.15,
            "r.missed_margins_api_617": 0.0,
            "r.smallest_excess_api_617": pytest.approx(-0.05),
            "s.smallest_margin": 0.0,
            "s.missed_margins_api_617": 1.0,
            "t.missed_margins_api_617": 0.0,
        },
    ),
    (
        "stability",
        {
            "smallest_log_decrement": [0.1, -0.2],
            "frequency_hz": [10.0, 10.0],
            "largest_growth_rate_per_s": [-1.0, 2.0],
            "threshold": {"speed_rpm": 5000.0},
        },
        {
            "smallest_log_decrement": -0.2,
            "largest_growth_rate_per_s": 2.0,
            "threshold_speed_rpm": 5000.0,
        },
    ),
    ("run_up", {"mount": "front", "largest_mount_force_n": 7.0}, {"front.largest_force_n": 7.0}),
    (
        "recovery",
        {"states": [{"state": "mode 1/x", "bodies": {"r": STRESSED}}]},
        {
            "mode 1_x.r.largest_displacement_m": 1e-3,
            "mode 1_x.r.dynamic_largest_von_mises_pa": 1e6,
            "mode 1_x.r.total_largest_von_mises_pa": 2e6,
        },
    ),
    ("mode_shapes", {"speeds": []}, {}),
]


@pytest.mark.parametrize(("kind", "document", "expected"), RESPONSES)
def test_responses_of_all_kinds(kind, document, expected):
    found = responses_of({"label": {"kind": kind, **document}})
    assert found == {f"label.{key}": value for key, value in expected.items()}
