"""The written files in Exudyn 1.13.6: its eigenvalues, forces and time steps against ours."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from types import SimpleNamespace

import exudyn as exu
import numpy as np
import pytest
from exudyn.FEM import ObjectFFRFreducedOrderInterface
from exudyn.itemInterface import (
    MarkerNodeCoordinate,
    NodePointGround,
    ObjectConnectorCoordinateSpringDamper,
)
from plain_run_up import run_up_newmark
from point_bodies import point_form, some_points
from python_exports import (
    HOSTILE,
    code_of,
    module_of,
    with_names,
)
from springs import on_springs, spring

from solidwhirl.rotordyn import (
    Rotor,
    SuperelementError,
    assemble,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.exchange.multibody.body_fixed import body_fixed_form
from solidwhirl.rotordyn.exchange.python.exudyn import write_exudyn
from solidwhirl.rotordyn.exchange.python.exudyn_frame import frame_arrays, write_exudyn_frame
from solidwhirl.rotordyn.exchange.python.ross import write_ross
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import ramp_and_hold
from solidwhirl.rotordyn.run_up.record import MotionState

BODIES = ["disk_shaft", "lateral_shaft", pytest.param("harmonic_rotor", marks=pytest.mark.solver)]
WRITERS = [write_exudyn, write_exudyn_frame, write_ross]
# Springs of the first and last interface; the last set is not symmetric, as in an oil film.
SPRINGS = {
    "free": None,
    "isotropic": (5e7, 3e7),
    "anisotropic": ((5e7, 2e7), (3e7, 4e7)),
    "crossed": ([[5e7, 1e7], [-1e7, 4e7]], 3e7),
}


@pytest.fixture
def body(request, tmp_path):
    """Body, its ends and its two files, imported."""
    element = request.getfixturevalue(request.param)
    ends = (element.interfaces[0].name, element.interfaces[-1].name)
    return SimpleNamespace(element=element, ends=ends, folder=tmp_path)


@pytest.fixture
def shaft(lateral_shaft, tmp_path):
    return SimpleNamespace(element=lateral_shaft, ends=("a", "b"), folder=tmp_path)


def system():
    return exu.SystemContainer().AddSystem()


def write(body, writer=write_exudyn, **options):
    return module_of(writer(body.element, body.folder / "body.py", **options).files[0])


def held(body, kind):
    return {} if SPRINGS[kind] is None else dict(zip(body.ends, SPRINGS[kind], strict=True))


@pytest.mark.parametrize("kind", SPRINGS)
@pytest.mark.parametrize("speed", [0.0, 900.0])
@pytest.mark.parametrize("body", BODIES, indirect=True)
def test_linear_frequencies(body, speed, kind):
    """Eigenvalues, growth of the unstable ones included, of all oscillating modes."""
    file, mbs = write(body), system()
    added = file.add_body(mbs, speed)
    for name, stiffness in held(body, kind).items():
        file.add_bearing(mbs, added, name, stiffness)
    theirs = file.eigenvalues(mbs)
    modes = modes_at_speed(on_springs(body.element, held(body, kind)), speed)
    ours = modes.eigenvalues[np.argsort(modes.eigenvalues.imag, kind="stable")]
    assert theirs.size == ours.size
    # Exudyn inverts M, so an error is of the size of the highest mode's square. Seen: 1e-9.
    np.testing.assert_allclose(theirs.imag, ours.imag, rtol=1e-7)
    np.testing.assert_allclose(np.sort(theirs.real), np.sort(ours.real), atol=1e-7 * 1e4)


def printed(path, *arguments):
    """What the file prints, run as a program from elsewhere; numbers by block."""
    done = subprocess.run(
        [sys.executable, "-W", "error", path, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=path.parent.parent,
    )
    assert done.returncode == 0, done.stderr
    blocks, title = {}, ""
    for line in done.stdout.splitlines():
        if line[0].isdigit():
            blocks[title].append(float(line.split()[0]))
        else:
            title = line.split(",")[0]
            blocks.setdefault(title, [])
    return blocks, done.stdout


@pytest.mark.parametrize(
    ("writer", "speed", "modes_at", "tolerance"),
    [(write_exudyn, 1000.0, 1000.0, 1e-7), (write_exudyn_frame, 300.0, 0.0, 2e-7)],
)
def test_files_run(shaft, writer, speed, modes_at, tolerance):
    """As told in their heads, under a hostile name; that of the frame prints modes at rest."""
    element, springs = with_names(shaft.element, HOSTILE), {HOSTILE: 5e7, "b": (5e7, 4e7)}
    exported = writer(element, shaft.folder / "two words.py")
    assert [f.name for f in exported.files] == ["two words.py", "two words.npz"]
    told = ("--speed", str(speed), "--spring", f"{HOSTILE}=5e7", "--spring", "b=5e7,4e7")
    blocks, text = printed(exported.files[0], *told)
    for title, held_by in (("free", {}), ("on springs", springs)):
        ours = modes_at_speed(on_springs(element, held_by), modes_at).frequency_hz[:12]
        np.testing.assert_allclose(blocks[title], ours, rtol=tolerance)
    if writer is write_exudyn_frame:
        # a free body keeps its spin; Newton's iteration stops at 1e-6
        assert abs(float(text.split()[-1])) < 1e-6
        assert any("axial" in sentence for sentence in exported.left_out)
    assert not list(shaft.folder.rglob("harm")) and not list(shaft.folder.parent.glob("harm"))


@pytest.mark.parametrize("writer", WRITERS)
def test_names_are_data(shaft, writer):
    """Python reads the same code whatever the names are: they stand in comments and numbers."""
    plain = writer(shaft.element, shaft.folder / "plain.py").files[0]
    hostile = writer(with_names(shaft.element, HOSTILE), shaft.folder / "hostile").files[0]
    assert code_of(plain) == code_of(hostile)
    assert ascii(HOSTILE) in hostile.read_text(encoding="ascii")
    imported = r"^ *(?:import|from) solidwhirl"
    assert not re.search(imported, plain.read_text(encoding="ascii"), re.MULTILINE)


@pytest.mark.parametrize("writer", WRITERS)
def test_other_endings_are_refused(shaft, writer):
    with pytest.raises(SuperelementError, match=r"ends with \.py, not with '\.h5'"):
        writer(shaft.element, shaft.folder / "body.h5")
    assert not list(shaft.folder.iterdir())


def test_ordinary_connectors(shaft):
    """Exudyn's own spring on a marker does what add_bearing does."""
    file, values = write(shaft), []
    for own in (False, True):
        mbs = system()
        body = file.add_body(mbs, 500.0)
        if own:
            ground = mbs.AddNode(NodePointGround())
            zero = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
            for component in ("ux", "uy"):
                ends = [zero, file.marker(mbs, body, "a", component)]
                mbs.AddObject(
                    ObjectConnectorCoordinateSpringDamper(markerNumbers=ends, stiffness=2e7)
                )
        else:
            file.add_bearing(mbs, body, "a", 2e7)
        values.append(file.eigenvalues(mbs).imag)
    np.testing.assert_allclose(values[0], values[1], rtol=1e-7)


def test_tied_body_and_two_bodies(shaft):
    """A casing of one piece carries the shaft: its places follow one motion, q = B r."""
    seats = {"front": (0.0, 0.0, 0.1), "rear": (0.0, 0.1, 0.4), "foot": (0.2, -0.3, 0.2)}
    casing = rigid_superelement("casing", 30.0, (0.0, 0.0, 0.2), (1.0, 1.5, 2.0), seats)
    rotor = write(shaft)
    tied = module_of(write_exudyn(casing, shaft.folder / "casing.py").files[0])
    mbs = system()
    first, second = rotor.add_body(mbs, 800.0), tied.add_body(mbs)
    assert second.M.shape == (6, 6)
    bearings = [spring(("c", "foot"), (2e7, 1e7))]
    for seat, other in zip(("a", "b"), ("front", "rear"), strict=True):
        rotor.add_bearing(mbs, first, seat, 5e7, 1e3, (second, other))
        bearings.append(spring(("r", seat), 5e7, 1e3, ("c", other)))
    tied.add_bearing(mbs, second, "foot", (2e7, 1e7))
    with pytest.raises(ValueError, match="is no coordinate of its own"):
        tied.marker(mbs, second, "foot", "ux")
    with pytest.raises(ValueError, match="there are"):
        tied.add_bearing(mbs, second, "nowhere", 1.0)
    rotors = {
        "r": Rotor(element=shaft.element, speed_ratio=1.0),
        "c": Rotor(element=casing, speed_ratio=0.0),
    }
    ours = modes_at_speed(assemble(rotors, tuple(bearings)), 800.0).eigenvalues
    theirs = rotor.eigenvalues(mbs)
    np.testing.assert_allclose(theirs.imag, ours.imag, rtol=1e-7)
    # damping of 1e3 N s/m: decay rates from 1 to 1e3
    np.testing.assert_allclose(theirs.real, ours.real, atol=1e-4)


def exudyn_run_up(file, body, springs, unbalance, top, duration, steps):
    """ux, uy of an interface at all steps."""
    spin, mbs = file.ramp(0.0, top, duration), system()
    added = file.add_body(mbs, spin)
    for name, stiffness in springs.items():
        file.add_bearing(mbs, added, name, stiffness)
    place, moment, phase = unbalance
    file.add_force(mbs, added, place, file.unbalance(moment, spin, phase))
    rows, record = added.motion(place), []

    def keep(mbs, t):
        kind = exu.OutputVariableType.Coordinates
        record.append(rows @ mbs.GetNodeOutput(added.node, kind))
        return True

    mbs.SetPostStepUserFunction(keep)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = duration
    # the equations are linear, but change with time
    settings.timeIntegration.newton.useModifiedNewton = False
    # the average acceleration of Newmark
    settings.timeIntegration.generalizedAlpha.useNewmark = True
    settings.solution.file.write = False
    mbs.SolveDynamic(settings)
    return np.array(record)


@pytest.mark.parametrize("body", BODIES[1:], indirect=True)
def test_run_up(body):
    """Through the first resonance in 0.3 s, by the same method step by step."""
    springs, top, duration, steps = held(body, "anisotropic"), 900.0, 0.3, 300
    place, moment, phase = body.ends[0], 1e-4, 0.3
    theirs = exudyn_run_up(write(body), body, springs, (place, moment, phase), top, duration, steps)
    assembled, profile = on_springs(body.element, springs), ramp_and_hold(top, duration)
    unbalance = Unbalance(body="r", interface=place, moment_kg_m=moment, phase_rad=phase)
    rest = MotionState(displacement=np.zeros(assembled.size), velocity=np.zeros(assembled.size))
    same = run_up_newmark(assembled, profile, [unbalance], duration / steps, rest).displacement
    rows = [interface_row(assembled, "r", place, component) for component in ("ux", "uy")]
    # Seen: 3e-12.
    size = np.abs(theirs).max()
    np.testing.assert_allclose(theirs, same @ np.transpose(rows), rtol=0, atol=1e-9 * size)


@pytest.mark.parametrize("body", BODIES, indirect=True)
def test_frame_at_rest(body):
    """Free and on springs; with fewer modes the free ones stay."""
    file = write(body, write_exudyn_frame)
    for kind, tolerance in (("free", 1e-9), ("isotropic", 2e-7), ("anisotropic", 2e-7)):
        # Exudyn takes the springs' stiffness by differences of forces: seen 6e-9 to 3e-8
        mbs = system()
        added = file.add_body(mbs)
        for name, stiffness in held(body, kind).items():
            file.add_bearing(mbs, added, name, stiffness)
        ours = modes_at_speed(on_springs(body.element, held(body, kind)), 0.0).frequency_hz
        theirs = file.frequencies(mbs)
        np.testing.assert_allclose(theirs[-ours.size :], ours, rtol=tolerance)
    few = write(body, write_exudyn_frame, modes=6)
    mbs = system()
    few.add_body(mbs)
    free = file.frequencies(mbs)[6:]
    expected = body_fixed_form(body.element).frequencies_hz[:6]
    np.testing.assert_allclose(free[:6], expected, rtol=1e-9)


class Equations:
    """Mass matrix and forces of an assembled system whose first body is a floating-frame one."""

    def __init__(self, mbs):
        self.mbs, self.solver = mbs, exu.MainSolverImplicitSecondOrder()
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        self.solver.InitializeSolver(mbs, settings)
        self.size = self.solver.GetODE2size()

    def at(self, coordinates, rates):
        """M and f at Exudyn's coordinates (from their reference) and rates."""
        self.mbs.systemData.SetODE2Coordinates(coordinates, exu.ConfigurationType.Current)
        self.mbs.systemData.SetODE2Coordinates_t(rates, exu.ConfigurationType.Current)
        self.solver.ComputeMassMatrix(self.mbs)
        mass = self.solver.GetSystemMassMatrix()[: self.size, : self.size]
        self.solver.ComputeODE2RHS(self.mbs)
        return mass, self.solver.GetSystemResidual()[: self.size]


@pytest.mark.parametrize("stiffened_at", [None, 0.0, 700.0])
@pytest.mark.parametrize("body", BODIES, indirect=True)
def test_frame_forces(body, stiffened_at):
    """Forces on the modes of a body that spins, at any amplitude: the formulas of the moments.

    add_body takes another spin for the stiffening than that of the file.

    f = −K q − 2 Ω n·I5 q' + Ω² (∂J/∂q)_zz / 2, with J = J0 + Σ (I8 + I8ᵀ) q − Σ Σ I9 q q.
    """
    speed, of_file = 400.0, 300.0
    file = write(body, write_exudyn_frame, speed_rad_s=of_file)
    form, mbs = body_fixed_form(body.element), system()
    file.add_body(mbs, stiffened_at=stiffened_at)
    mbs.Assemble()
    equations = Equations(mbs)
    m, stiffened = form.frequencies_hz.size, of_file if stiffened_at is None else stiffened_at
    random = np.random.default_rng(7)
    # each mode with the same energy, so that no force drowns in that of the highest mode
    q = random.normal(size=m) * 1e-3 * form.frequencies_hz[0] / form.frequencies_hz
    rate = random.normal(size=m)
    coordinates, velocities = np.zeros((2, 7 + m))
    coordinates[7:], velocities[7:] = q, rate
    velocities[6] = speed / 2.0  # of the Euler parameter of z
    _, force = equations.at(coordinates, velocities)
    elastic = -form.stiffness @ q - stiffened**2 * form.stress_stiffening @ q
    coriolis = -2.0 * speed * form.I5[2].T @ rate
    centrifugal = speed**2 * (form.I8[2, 2] - form.I9[2, 2] @ q)
    size = np.abs(coriolis).max()
    np.testing.assert_allclose(
        force[7:], elastic + coriolis + centrifugal, rtol=0, atol=1e-9 * size
    )


def test_frame_of_mass_points(tmp_path):
    """Kinetic energy and forces at any state, against Newton's law of six points.

    Every array is at work here: elastic modes of a free body leave some of them zero.
    """
    random, stiffness = np.random.default_rng(3), np.diag([1.0, 2.0, 3.0, 4.0])
    points = some_points(4, count=6, seed=3)
    masses, places, modes, _ = points
    form = dataclasses.replace(
        point_form(points, shown=0), stiffness=stiffness, points_m=places, point_modes=modes
    )
    np.savez(tmp_path / "points.npz", **frame_arrays(form, 0.0, 1.0))
    body, mbs = ObjectFFRFreducedOrderInterface(), system()
    body.LoadFromFile(str(tmp_path / "points.npz"), mode="NPZ")
    body.AddObjectFFRFreducedOrder(mbs)
    mbs.Assemble()
    equations = Equations(mbs)
    for _ in range(5):
        q, rate = random.normal(size=(2, 4))
        travel, spin = random.normal(size=(2, 3))
        s, relative = places + modes @ q, modes @ rate
        coordinates = np.concatenate([np.zeros(7), q])
        # Euler parameters at no turn: their rates are half the spin
        velocities = np.concatenate([travel, [0.0], spin / 2.0, rate])
        mass, force = equations.at(coordinates, velocities)
        velocity = travel + np.cross(spin, s) + relative
        energy = 0.5 * masses @ (velocity**2).sum(axis=1)
        assert 0.5 * velocities @ mass @ velocities == pytest.approx(energy, rel=1e-12)
        # forces of inertia while spin, travel and rates keep their values
        inertia = -masses[:, None] * (
            np.cross(spin, np.cross(spin, s)) + 2.0 * np.cross(spin, relative)
        )
        expected = np.concatenate(
            [
                inertia.sum(axis=0),
                [0.0],
                2.0 * np.cross(s, inertia).sum(axis=0),
                np.einsum("paj,pa->j", modes, inertia) - stiffness @ q,
            ]
        )
        np.testing.assert_allclose(force, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_frame_rings(disk_shaft, tmp_path):
    """Three points more than an axis: a rigid marker turns as the interface does."""
    file = module_of(write_exudyn_frame(disk_shaft, tmp_path / "ring.py").files[0])
    form, mbs = body_fixed_form(disk_shaft), system()
    added = file.add_body(mbs)
    markers = [file.interface_marker(mbs, added, node.name) for node in form.nodes]
    mbs.Assemble()
    amplitude = 1e-6
    for mode in range(4):
        coordinates = np.zeros(7 + form.frequencies_hz.size)
        coordinates[7 + mode] = amplitude
        mbs.systemData.SetODE2Coordinates(coordinates, exu.ConfigurationType.Current)
        for marker, node in zip(markers, form.nodes, strict=True):
            place = mbs.GetMarkerOutput(marker, exu.OutputVariableType.Position)
            turn = mbs.GetMarkerOutput(marker, exu.OutputVariableType.RotationMatrix)
            turn = np.asarray(turn).reshape(3, 3)
            moved = (np.asarray(place) - node.position_m) / amplitude
            turned = np.array([turn[2, 1], turn[0, 2], turn[1, 0]]) / amplitude
            # differences of places of 1 m, taken 1e6 times: 1e-10 of rounding
            np.testing.assert_allclose(moved, node.translations[:, mode], rtol=0, atol=1e-8)
            scale = np.abs(node.rotations[:, :4]).max()
            np.testing.assert_allclose(turned, node.rotations[:, mode], rtol=0, atol=1e-7 * scale)


def test_frame_refusals(shaft):
    with pytest.raises(SuperelementError, match="speed_rad_s is nan"):
        write_exudyn_frame(shaft.element, shaft.folder / "f.py", speed_rad_s=np.nan)
    with pytest.raises(SuperelementError, match="allowed is up to 1500 rad/s"):
        limited = dataclasses.replace(shaft.element, maximum_speed_rad_s=1500.0)
        write_exudyn_frame(limited, shaft.folder / "f.py", speed_rad_s=1501.0)
    assert not list(shaft.folder.iterdir())
