"""Datasets hold the numbers of their records under names and units that a reader can trust."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from everything import everything
from results_read import results_in

from solidwhirl.analyses.registry import KINDS
from solidwhirl.datasets.parts import filled, labelled, long_name_of, units_of
from solidwhirl.datasets.results import (
    analysis_dataset,
    campbell_dataset,
    critical_speed_dataset,
    critical_speed_map_dataset,
    datasets,
    ground_motion_dataset,
    modes_dataset,
    read_netcdf,
    run_up_dataset,
    unbalance_dataset,
    write_netcdf,
)
from solidwhirl.output.documents import write_results
from solidwhirl.rotordyn import (
    Bearing,
    Disk,
    End,
    Rotor,
    assemble,
    beam_superelement,
    campbell,
    campbell_errors,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.response.maps import ground_motion_map
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold

RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def system():
    wheel = Disk(name="wheel", position_m=0.2, mass_kg=12, polar_kg_m2=0.12, diametral_kg_m2=0.065)
    seats = {"a": 0.0, "wheel": 0.2, "b": 0.6}
    shaft = beam_superelement(
        "shaft", [0, 0.2, 0.4, 0.6], 0.02, 0.0, (2e11, 0.3, 7800.0), seats, [wheel]
    )
    bearings = tuple(
        Bearing(
            name=n,
            first=End(body="rotor", interface=n),
            stiffness_n_per_m=np.diag([5e7, 4e7]),
            damping_n_s_per_m=800 * np.eye(2),
        )
        for n in ("a", "b")
    )
    return assemble({"rotor": Rotor(element=shaft, speed_ratio=1.0)}, bearings)


@pytest.fixture(scope="module")
def diagram(system):
    return campbell(system, np.linspace(0, 9000, 10) * RPM, branch_count=4)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Results with every kind of analysis but recovery, and their folder."""
    results = everything().results
    return results, write_results(results, tmp_path_factory.mktemp("x") / "run", pictures=False)


def check_looks(dataset):
    """Numbers have units, everything has a name for axes."""
    for name, variable in dataset.variables.items():
        assert variable.attrs["long_name"], name
        if variable.dtype.kind in "fc":
            assert variable.attrs["units"] == units_of(name), name


UNITS = {
    **{"frequency_hz": "Hz", "stiffness_n_per_m": "N/m", "damping_n_s_per_m": "N s/m"},
    **{"inertia_kg_m2": "kg m2", "moment_kg_m": "kg m", "moment_n_m": "N m", "force_n": "N"},
    **{"speed_rad_s": "rad/s", "velocity_m_per_s": "m/s", "eigenvalue_per_s": "1/s"},
    **{"angular_velocity_rad_per_s": "rad/s", "time_s": "s", "whirl": "1", "share": "1"},
}


def test_units_are_in_the_names_and_absent_values_told():
    for name, unit in UNITS.items():
        assert units_of(name) == unit
        assert long_name_of(name)
        assert unit == "1" or not long_name_of(name).endswith(name[-3:])
    np.testing.assert_array_equal(filled([[1.0, None], [2, 3]]), [[1.0, np.nan], [2.0, 3.0]])
    assert filled(["forward", None]).tolist() == ["forward", ""]
    assert filled([True, False]).dtype == bool
    # 9000 rpm in rad/s and back is another double; along an axis it is 9000 again
    rpm = np.arange(0, 30000, 100.0)
    there = (rpm * RPM) / RPM
    assert (there != rpm).any()
    found = labelled({}, {"speed_rpm": ("speed_rpm", there)})
    assert (found.speed_rpm.values == rpm).all()
    none = analysis_dataset({"kind": "separation_margins", "margins": []})
    assert none.sizes == {"resonance": 0}
    assert none.margin.dtype == float
    assert none.margin.units == "1"
    assert analysis_dataset({"kind": "bearing_laws", "bearings": {}}).sizes == {}


def test_campbell(system, diagram):
    errors = campbell_errors(system, diagram)
    found = campbell_dataset(diagram, errors)
    check_looks(found)
    assert found.frequency_hz.dims == ("branch", "speed_rpm")
    for k, rpm in enumerate(range(0, 10000, 1000)):
        at = found.sel(speed_rpm=rpm, branch=2)
        assert at.frequency_hz == diagram.frequency_hz[1, k]
        assert at.whirl == diagram.whirl[1, k]
        assert at.frequency_error_estimate == errors.total[1, k]
    # λ = -σ + iω: both other variables come from it
    omega = found.eigenvalue_per_s.imag
    np.testing.assert_allclose(omega / (2 * np.pi), found.frequency_hz, rtol=1e-14)
    assert set(found.error_part.values) == set(errors.parts)
    counted = found.error_parts.where(found.error_part != "interface_coupling").sum("error_part")
    np.testing.assert_allclose(counted, found.frequency_error_estimate, rtol=1e-10)


def test_modes_and_critical_speeds(system):
    modes = modes_at_speed(system, 3000 * RPM, 4)
    found = modes_dataset(modes)
    check_looks(found)
    assert found.frequency_hz.sel(mode=1) == modes.frequency_hz[0]
    assert found["shape"].shape == (system.size, modes.eigenvalues.size)
    critical = critical_speeds(system, speed_max_rad_s=2000.0)
    table = critical_speed_dataset(critical)
    check_looks(table)
    # synchronous excitation
    np.testing.assert_allclose(table.speed_rpm / 60.0, table.frequency_hz, rtol=1e-9)
    assert table.whirl.values.tolist() == [c.whirl for c in critical]
    assert critical_speed_dataset([]).sizes == {"critical_speed": 0}


def test_responses(system):
    placed = [Unbalance(body="rotor", interface="wheel", moment_kg_m=1e-4)]
    rpm = np.linspace(0, 6000, 7)
    response = unbalance_response(system, placed, rpm * RPM)
    found = unbalance_dataset(response)
    check_looks(found)
    at = found.sel(exciter="rotor", node="rotor.wheel", speed_rpm=4000)
    mine = response.exciters[0].at_node("rotor", "wheel")[4]
    np.testing.assert_array_equal(at.translation_m, mine)
    assert at.frequency_hz == pytest.approx(4000 / 60)
    # the bearing pushes the ground with what its spring and damper take, k u + iω c u
    u = found.translation_m.sel(node="rotor.a", speed_rpm=4000, direction="x").item()
    force = found.force_n.sel(bearing="a", axis="x", speed_rpm=4000).item()
    assert force == pytest.approx((5e7 + 800j * 4000 * RPM) * u, rel=1e-9)
    ground = ground_motion_map(
        system, 1e-6, "x", rpm * RPM, [100.0, 200.0], End(body="rotor", interface="b")
    )
    fall = ground_motion_dataset(ground)
    check_looks(fall)
    assert fall.amplitude_m.sel(speed_rpm=3000).values.tolist() == ground.major_m()[3].tolist()


def test_maps_and_run_up(system):
    chart = critical_speed_map(
        system, ["a", "b"], [1e6, 1e7, 1e8], branch_count=2, speed_max_rad_s=2000.0
    )
    found = critical_speed_map_dataset(chart)
    check_looks(found)
    rising = found.critical_speed_rpm.sel(branch=1)
    # a stiffer support raises every critical speed
    assert (rising.diff("stiffness_n_per_m") > 0).all()
    run = run_up(
        system,
        ramp_and_hold(200.0, 0.05, 0.0),
        [Unbalance(body="rotor", interface="wheel", moment_kg_m=1e-4)],
        step_s=1e-4,
        outputs=[End(body="rotor", interface="a")],
        bearings=["a"],
    )
    record = run_up_dataset(run)
    check_looks(record)
    motion = record.translation_m.sel(node="rotor.a", axis="y")
    np.testing.assert_array_equal(motion, run.translation_m[0, 1])
    assert record.speed_rpm.values[-1] == pytest.approx(200.0 / RPM)


def test_netcdf_gives_back_what_was_written(system, diagram, tmp_path):
    for name, found in {
        "diagram": campbell_dataset(diagram, campbell_errors(system, diagram)),
        "modes": modes_dataset(modes_at_speed(system, 100.0, 4)),
    }.items():
        path = write_netcdf(found, tmp_path / f"{name}.nc")
        back = read_netcdf(path)
        assert set(back.variables) == set(found.variables)
        for key, variable in found.variables.items():
            np.testing.assert_array_equal(back[key].values, variable.values, err_msg=key)
            assert back[key].dims == variable.dims
            assert back[key].attrs == variable.attrs
        assert [p.name for p in tmp_path.glob(".*")] == []


def test_every_kind_of_analysis_has_a_dataset_or_is_known_to_have_none():
    without = {k for k, own in KINDS.items() if not own.axes and "labels" not in vars(own)}
    # files hold what these have: h5 and mat, VTU, and of a run-up the record
    assert without == {"state_space", "recovery", "run_up"}


@pytest.mark.solver
def test_a_run_in_memory_is_that_of_its_folder(run):
    results, folder = run
    found, kept = datasets(results), datasets(folder)
    assert found.identical(kept) or xr.testing.assert_allclose(found, kept) is None
    assert set(found["analyses"].children) == {a.label for a in results.scene.analyses}
    for node in found.subtree:
        check_looks(node.to_dataset(inherit=False))
    assert found.name == "everything"


@pytest.mark.solver
def test_arrays_of_a_run_are_those_of_results_json(run):
    _, folder = run
    document = results_in(folder)
    tree = datasets(folder)
    analyses = document["analyses"]
    assert tree["campbell/frequency_hz"].sel(speed_rpm=9000, branch=3) == pytest.approx(
        document["campbell"]["frequency_hz"][2][-1]
    )
    exciter = analyses["unbalance_response"]["exciters"][1]
    found = tree["analyses/unbalance_response"].to_dataset()
    named = found.sel(exciter=exciter["bodies"][0], place="casing.mount")
    assert named.major_m.values.tolist() == exciter["places"]["casing.mount"]["major_m"]
    told = [
        (place, peak["speed_rpm"], peak["amplitude_m"])
        for e in analyses["unbalance_response"]["exciters"]
        for place, peaks in e["peaks"].items()
        for peak in peaks
    ]
    peaks = tree["peaks/unbalance_response"].to_dataset()
    assert told
    columns = [peaks[name].values.tolist() for name in ("place", "speed_rpm", "amplitude_m")]
    assert [*zip(*columns, strict=True)] == told
    fall = analyses["waterfall"]
    assert tree["analyses/waterfall/amplitude_m"].values.tolist() == fall["amplitude_m"]
    assert tree["analyses/waterfall"].attrs["observed"] == "lp.wheel"
    shapes = tree["analyses/mode_shapes"].to_dataset()
    own = analyses["mode_shapes"]["speeds"][1]
    row = own["bodies"]["lp"]["interfaces"].index("rear")
    shown = shapes.deflection.sel(speed_rpm=9000, place="lp.rear").dropna("mode")
    assert shown.values.tolist() == own["bodies"]["lp"]["interface_deflection"][row]
    # kinetic energy is shared out among the bodies; a speed with fewer modes has nan
    whole = shapes.share_of_kinetic_energy.sum("body", skipna=False).values
    np.testing.assert_allclose(whole[np.isfinite(shapes.frequency_hz.values)], 1.0, atol=1e-9)
    assert (np.isfinite(whole) == np.isfinite(shapes.frequency_hz.values)).all()
    margins = tree["analyses/separation_margins"].to_dataset()
    assert margins.margin.values.tolist() == [
        row["margin"] for row in analyses["separation_margins"]["margins"]
    ]
    record = tree["analyses/run_up/record"].to_dataset()
    assert record.mount_force_n.shape == (3, record.time_s.size)
    largest = np.hypot(*record.mount_force_n.values[:2]).max()
    assert largest == pytest.approx(analyses["run_up"]["largest_mount_force_n"], rel=1e-9)


def test_other_folders_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"no folder of a run: results\.json: no such file"):
        datasets(tmp_path)
    (tmp_path / "results.json").write_text('{"schema": "other"}')
    with pytest.raises(ValueError, match="schema is 'other', 'solidwhirl-results-1' is what"):
        datasets(tmp_path)
