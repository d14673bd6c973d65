"""The hammer test: functions of a free beam, universal files, modes that belong together."""

from __future__ import annotations

import re

import numpy as np
import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.modal_test.assurance import assurance, pairs_by_frequency, pairs_by_shape
from solidwhirl.scene_reading.reader import parse_scene, scene_hash

# So slender that shear and rotary inertia, (k r)², are below 1e-6 in the first modes.
RADIUS, LENGTH, MODULUS, DENSITY = 2e-4, 1.0, 2e11, 7800.0
AREA, BENDING = np.pi * RADIUS**2, MODULUS * np.pi * RADIUS**4 / 4.0
MASS = DENSITY * AREA * LENGTH
PLACES = {"a": 0.0, "b": 0.3, "c": 0.55, "d": 0.7, "e": 1.0}
ENDS = [{"name": n, "kind": "section", "at_m": z} for n, z in (("left", 0.0), ("middle", 0.5))]


def beam(folder=None, **keys):
    """A free beam hit at its left end, with sensors at the places."""
    test = {
        "kind": "impact_test",
        "frequency_max_hz": 30.0,
        "frequency_count": 60,
        "hammers": [{"name": "h", "at": "shaft.left", "direction": "y", "node": 1}],
        "sensors": [
            {"name": n, "body": "shaft", "at_m": z, "direction": "-y" if n == "b" else "y",
             "node": k + 1}
            for k, (n, z) in enumerate(PLACES.items())
        ],
    }  # fmt: skip
    data = {
        "name": "beam",
        "materials": {
            "steel": {
                "density_kg_per_m3": DENSITY,
                "youngs_modulus_pa": MODULUS,
                "poissons_ratio": 0.3,
            }
        },
        "model": {"level": "beam", "accuracy": 1e-5, "estimates": "off"},
        "bodies": {
            "shaft": {
                "material": "steel",
                "sections": [
                    {"name": "rod", "start_m": 0.0, "end_m": LENGTH, "outer_radius_m": RADIUS}
                ],
                "interfaces": ENDS,
            }
        },
        "analyses": [{**test, **keys}],
    }
    return parse_scene(data, folder=folder)


def found(scene):
    outcome = run_scene(scene).analyses["impact_test"]
    return outcome, outcome.document


def functions(document, unit):
    return np.array(document[f"real_{unit}"]) + 1j * np.array(document[f"imaginary_{unit}"])


def free_beam(omega, at_m):
    """Displacement at a place for a unit force at the left end of a free Euler beam."""
    k = (omega**2 * DENSITY * AREA / BENDING) ** 0.25

    def derivative(order, x):
        turns = [np.cos(k * x + order * np.pi / 2), np.sin(k * x + order * np.pi / 2)]
        grows = [np.cosh(k * x), np.sinh(k * x)]
        return k**order * np.array([*turns, *(grows if order % 2 == 0 else grows[::-1])])

    sides = [derivative(2, 0.0), derivative(3, 0.0), derivative(2, LENGTH), derivative(3, LENGTH)]
    # EI w''' at the left end is the force there
    return derivative(0, at_m) @ np.linalg.solve(sides, [0.0, 1.0 / BENDING, 0.0, 0.0])


def test_receptance_of_a_free_beam_is_the_closed_form():
    _, document = found(beam(quantity="receptance", frequency_max_hz=8.0, frequency_count=20))
    omega = 2 * np.pi * np.array(document["frequency_hz"])
    wanted = np.array([[free_beam(w, z) for w in omega] for z in PLACES.values()])
    wanted[1] *= -1.0  # that sensor looks along -y
    given = functions(document, "m_per_n")[0]
    assert (np.abs(given - wanted) < 2e-5 * np.abs(wanted).max(axis=0)).all()
    assert wanted[0, 0] == pytest.approx(-4.0 / (MASS * omega[0] ** 2), rel=0.15)  # rigid


def test_damped_accelerance_is_the_modal_sum():
    """Bending modes from the closed form, rigid motions with them, each with its own damping."""
    ratios = [0.01, 0.03]
    _, document = found(beam(damping_ratio=ratios, frequency_max_hz=12.0))
    omega = 2 * np.pi * np.array(document["frequency_hz"])
    roots = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671])
    roots = np.append(roots, (2 * np.arange(4, 40) + 1) * np.pi / 2)
    scale = np.sqrt(BENDING / (DENSITY * AREA)) / LENGTH**2
    places = np.array([*PLACES.values()])

    def shape(b, x):  # written without differences of large numbers
        s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b)) if b < 30 else 1.0
        grow = (1 - s) / 2 * np.exp(b * x) if b < 30 else -np.sin(b) * np.exp(b * (x - 1))
        return grow + (1 + s) / 2 * np.exp(-b * x) + np.cos(b * x) - s * np.sin(b * x)

    wanted = np.add.outer(1.0 + 12.0 * (0.5 - places) * 0.5, 0 * omega) / (-MASS * omega**2)
    wanted = wanted.astype(complex)
    for k, b in enumerate(roots):
        own, zeta = scale * b**2, ratios[min(k, 1)]
        below = own**2 - omega**2 + 2j * zeta * own * omega
        wanted += np.outer(shape(b, places) * shape(b, 0.0), 1.0 / below) / MASS
    wanted[1] *= -1.0
    given = functions(document, "m_per_s2_n")[0]
    difference = np.abs(given + omega**2 * wanted).max(axis=1)
    assert (difference < 2e-3 * np.abs(given).max(axis=1)).all()
    assert document["modes"]["damping_ratio"][:3] == [0.01, 0.03, 0.03]
    hertz = np.array(document["modes"]["frequency_hz"])
    assert hertz[:3] == pytest.approx(scale * roots[:3] ** 2 / (2 * np.pi), rel=1e-5)
    assert set(document["modes"]["count"]) == {2}


def test_axial_receptance_of_a_free_rod_is_the_closed_form():
    """u = −cos k(L − z)/(EA k sin kL); of the modes the axial ones alone, the first c/2L."""
    ends = [{"name": n, "at": f"shaft.{n}", "direction": "-z"} for n in ("left", "middle")]
    keys = {"hammers": [{**ends[0], "direction": "z"}], "sensors": ends, "quantity": "receptance",
            "frequency_max_hz": 1500.0, "measured": {"frequencies_hz": [2500.0]}}  # fmt: skip
    _, document = found(beam(**keys))
    k = 2 * np.pi * np.array(document["frequency_hz"]) * np.sqrt(DENSITY / MODULUS)
    wanted = np.cos(k * (LENGTH - np.array([[0.0], [0.5]]))) / (MODULUS * AREA * k * np.sin(k))
    given = functions(document, "m_per_n")[0]
    assert (np.abs(given - wanted) < 1e-3 * np.abs(wanted).max(axis=0)).all()
    (paired,) = document["measured"]["modes"]
    assert paired["computed"] == 1
    assert paired["computed_hz"] == pytest.approx(np.sqrt(MODULUS / DENSITY) / 2, rel=1e-3)
    with pytest.raises(SceneError, match="axial motion is known at interfaces alone"):
        beam(sensors=[{"name": "a", "body": "shaft", "at_m": 0.2, "direction": "z"}])


def turning_drum(folder=None, **keys):
    """A stiff drum on two springs at its ends that are alike in x and y."""
    corner = [("left", 0.0), ("right", 0.3)]
    sensors = [
        {"name": f"{n}_{d}", "at": f"drum.{n}", "direction": d, "node": k + 1}
        for k, (n, _) in enumerate(corner)
        for d in ("x", "y")
    ]
    test = {"kind": "impact_test", "frequency_max_hz": 300.0, "frequency_count": 40,
            "hammers": sensors[1:2], "sensors": sensors, "quantity": "receptance",
            "speed_rpm": 12000.0, **keys}  # fmt: skip
    steel = {"density_kg_per_m3": 7800.0, "youngs_modulus_pa": 2e15, "poissons_ratio": 0.3}
    data = {
        "name": "drum",
        "materials": {"stiff": steel},
        "model": {"level": "beam", "estimates": "off"},
        "bodies": {
            "drum": {
                "material": "stiff",
                "sections": [
                    {"name": "drum", "start_m": 0.0, "end_m": 0.3, "outer_radius_m": 0.15}
                ],
                "interfaces": [{"name": n, "kind": "section", "at_m": z} for n, z in corner],
            }
        },
        "bearings": [
            {"name": n, "first": f"drum.{n}", "stiffness_n_per_m": 1e7, "damping_n_s_per_m": c}
            for (n, _), c in zip(corner, (2000.0, 4000.0), strict=True)
        ],
        "analyses": [test],
    }
    return parse_scene(data, folder=folder)


def test_turning_rigid_body_is_the_closed_form(tmp_path):
    """Four degrees of freedom by hand: functions, damped whirl; its own file is the same mode."""
    outcome, document = found(turning_drum())
    mass = 7800.0 * np.pi * 0.15**2 * 0.3
    polar, tilt = mass * 0.15**2 / 2, mass * (0.15**2 / 4 + 0.3**2 / 12)
    omega = 2 * np.pi * np.array(document["frequency_hz"])
    # of z = x + iy and its slope along the axis: M q'' + (C − iΩG) q' + K q = f
    arm = np.array([[1.0, -0.15], [1.0, 0.15]])
    m, k = np.diag([mass, tilt]), 1e7 * arm.T @ arm
    c = arm.T @ np.diag([2000.0, 4000.0]) @ arm - 1j * 400 * np.pi * np.diag([0, polar])

    def circle(w):  # at the ends, of a force e^{iwt} at the left one
        return arm @ np.linalg.solve(k + 1j * w * c - w**2 * m, arm[0])

    # y = cos ωt: half a forward and half a backward circle, i (e^{iωt} + e^{−iωt})/2
    ahead, back = (1j / 2 * np.array([circle(s * w) for w in omega]) for s in (1, -1))
    x, y = ahead + back.conj(), -1j * (ahead - back.conj())
    wanted = np.stack([x[:, 0], y[:, 0], x[:, 1], y[:, 1]])
    given = functions(document, "m_per_n")[0]
    assert (np.abs(given - wanted) < 1e-5 * np.abs(wanted).max()).all()
    below = -np.linalg.solve(m, np.hstack([k, c]))
    rates = np.linalg.eigvals(np.vstack([np.eye(2, 4, 2), below]))
    modes = document["modes"]
    rates = rates[np.argsort(np.abs(rates.imag))][: len(modes["frequency_hz"])]
    assert modes["frequency_hz"] == pytest.approx(np.abs(rates.imag) / 2 / np.pi, rel=1e-5)
    assert modes["damping_ratio"] == pytest.approx(-rates.real / np.abs(rates), rel=1e-4)
    outcome.files["impact_test.unv"](tmp_path / "own.unv")
    measured = {"functions": "own.unv", "modes": "own.unv"}
    _, document = found(turning_drum(tmp_path, measured=measured))
    back = document["measured"]["modes"]
    assert [mode["computed"] for mode in back] == [1, 2, 3, 4][: len(rates)]
    assert [mode["mac"] for mode in back] == pytest.approx(np.ones(len(rates)), abs=1e-9)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Functions and modes of the beam as a universal file, and its results."""
    folder = tmp_path_factory.mktemp("test")
    outcome, document = found(beam(damping_ratio=0.02))
    outcome.files["impact_test.unv"](folder / "own.unv")
    return folder, document


def test_universal_file_comes_back(written):
    folder, own = written
    measured = {"functions": "own.unv", "modes": "own.unv"}
    scene = beam(folder, damping_ratio=0.02, quantity="mobility", measured=measured)
    _, document = found(scene)
    back = document["measured"]
    wanted = functions(own, "m_per_s2_n")[0]
    assert [f["sensor"] for f in back["functions"]] == list(PLACES)
    for function, values in zip(back["functions"], wanted, strict=True):
        hertz = np.array(function["frequency_hz"])
        np.testing.assert_allclose(hertz, own["frequency_hz"], rtol=1e-5)
        given = np.array(function["real"]) + 1j * np.array(function["imaginary"])
        np.testing.assert_allclose(given * 2j * np.pi * hertz, values, rtol=1e-10)
    assert [mode["computed"] for mode in back["modes"]] == [1, 2, 3, 4, 5, 6][: len(back["modes"])]
    np.testing.assert_allclose(
        [mode["relative_difference"] for mode in back["modes"]], 0, atol=1e-5
    )
    np.testing.assert_allclose(np.diag(back["mac"]), 1.0, atol=1e-9)
    assert back["modes"][0]["damping_ratio"] == pytest.approx(0.02)
    assert "dataset 164" in back["notes"][0]
    (folder / "moved").mkdir(exist_ok=True)
    (folder / "moved" / "own.unv").write_bytes((folder / "own.unv").read_bytes())
    moved = beam(folder / "moved", damping_ratio=0.02, quantity="mobility", measured=measured)
    assert scene_hash(moved) == scene_hash(scene)


def test_own_modes_are_identity_where_sensors_tell_them_apart():
    """Orthogonal motions; of two planes any combination is the same mode."""
    basis = np.linalg.qr(np.random.default_rng(1).normal(size=(8, 6)))[0]
    families = [basis[:, :2], basis[:, 2:3], basis[:, 3:5]]
    measured = np.stack([basis[:, 0] + 2j * basis[:, 1], basis[:, 2], basis[:, 4] * -3j], axis=1)
    mac = assurance(measured, families)
    np.testing.assert_allclose(mac, np.eye(3), atol=1e-12)
    order = [2, 0, 1]
    pairs = pairs_by_shape(
        mac[order], np.array([30.0, 10.0, 20.0]), np.array([10.0, 20.0, 30.0]), np.array([2, 1, 2])
    )
    assert [p.computed for p in pairs] == order
    near = pairs_by_frequency(np.array([9.0, 21.0, 90.0]), np.array([10.0, 15.0, 20.0]))
    assert [p.computed for p in near] == [0, 2, None]


def changed(folder, name, change):
    text = change((folder / "own.unv").read_text())
    (folder / name).write_text(text)
    return name


def _without_units(text):
    bare = re.sub(r"    -1\n   (?:164| 15)\b.*?    -1\n", "", text, flags=re.DOTALL)
    return bare.replace("m/s^2", "NONE ")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text[: len(text) // 2], "broken"),
        (lambda text: text.replace("\n        60 ", "\n        61 ", 1).replace(
            "         6        60", "         6        61", 1), "61 values are announced"),
        (lambda text: text.replace("+00", "oops", 40), "broken"),
        (lambda text: text.replace("m/s^2", "mm/s2", 1), "labels say mm/s2 per N"),
        (lambda text: text.replace("1.0000000000000000D+00", "1.0000000000000000D+03", 1),
         "units code 1"),
        (lambda text: "nothing", "no universal file"),
        (lambda text: text.replace("1.00000E+00", "1.00000E+03").replace(
            "1.00000e+00", "1.00000e+03"), "m apart"),
    ],
)  # fmt: skip
def test_broken_universal_files_are_refused(written, change, said):
    folder, _ = written
    name = changed(folder, "broken.unv", change)
    with pytest.raises(SceneError, match=r"analyses\[0\].measured: broken.unv: ") as error:
        run_scene(beam(folder, measured={"functions": name}))
    assert said in str(error.value)


@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")  # pyuff's
def test_binary_functions_and_headers(written):
    """Binary numbers, which end no line before the end of their block, are those of the text."""
    import pyuff

    folder, own = written
    sets = pyuff.UFF(str(folder / "own.unv")).read_sets()
    binary = [s | {"binary": 1} if s["type"] == 58 else s for s in sets if s["type"] != 55]
    pyuff.UFF(str(folder / "binary.unv")).write_sets(binary, "overwrite")
    header = b"    -1\n   151\nmodel\n    -1\n"
    (folder / "headed.unv").write_bytes(header + (folder / "binary.unv").read_bytes())
    _, document = found(beam(folder, measured={"functions": "headed.unv"}))
    given = document["measured"]["functions"][0]["real"]
    np.testing.assert_allclose(given, np.array(own["real_m_per_s2_n"])[0, 0], rtol=1e-5)
    assert document["measured"]["notes"][1] == "datasets that are not read are passed over: 151"


def test_missing_units_are_told_and_can_be_given(written):
    folder, own = written
    name = changed(folder, "bare.unv", _without_units)
    with pytest.raises(SceneError, match="no units: the file has no dataset 164"):
        run_scene(beam(folder, measured={"functions": name}))
    _, document = found(beam(folder, measured={"functions": name, "units": "mm_n"}))
    given = document["measured"]["functions"][0]["real"]
    np.testing.assert_allclose(given, 1e-3 * np.array(own["real_m_per_s2_n"])[0, 0], rtol=1e-9)


def test_points_off_the_body_and_without_node_are_refused(written):
    folder, _ = written
    off = [{"name": "a", "body": "shaft", "at_m": 1.2, "direction": "x"}]
    with pytest.raises(SceneError, match=r"sensors\[0\].at_m: 1.2 lies off 'shaft'.* 0 to 1"):
        run_scene(beam(sensors=off))
    bare = [{"name": "a", "body": "shaft", "at_m": 0.2, "direction": "x"}]
    with pytest.raises(SceneError, match="'a' has no node"):
        run_scene(beam(folder, sensors=bare, measured={"functions": "own.unv"}))
    with pytest.raises(SceneError, match=r"none.csv: no such file"):
        beam(folder, measured={"modes": "none.csv"})


def test_csv_files(tmp_path):
    rows = ["mode,frequency_hz,uncertainty_hz,sensor,real"]
    rows += [f"1,1.8,0.01,{n},{s}" for n, s in (("a", 2.0), ("b", 0.3), ("c", -1.2), ("e", 2.0))]
    (tmp_path / "modes.csv").write_text("\n".join(rows))
    (tmp_path / "frf.csv").write_text(
        "hammer,sensor,frequency_hz,real_m_per_n,imaginary_m_per_n\nh,a,1.0,2.0,3.0\nh,a,2.0,1.0,0"
    )
    measured = {"functions": "frf.csv", "modes": "modes.csv"}
    outcome, document = found(beam(tmp_path, measured=measured))
    assert document["measured"]["modes"][0]["mac"] > 0.9
    w = 2 * np.pi
    assert document["measured"]["functions"][0]["real"] == pytest.approx(
        [-2 * w**2, -((2 * w) ** 2)]
    )
    heads = [b.title for b in outcome.blocks()] if outcome.blocks else []
    assert {"Accelerance", "Frequencies side by side", "Modal assurance criterion"} <= set(heads)
    (tmp_path / "frf.csv").write_text("hammer,sensor,frequency_hz,real_m_per_n\nh,a,1.0,2.0\n")
    with pytest.raises(SceneError, match="no column 'imaginary_m_per_n'"):
        run_scene(beam(tmp_path, measured=measured))


def _modes_alone(text):
    """The blocks of modes of a universal file, from their first line to their last."""
    return re.findall(r"    -1\n    55.*?    -1\n", text, flags=re.DOTALL)


@pytest.mark.parametrize(
    "write",
    [
        lambda line: line.ljust(80),
        lambda line: line + "  \t",
        lambda line: line.replace("e+", "D+").replace("E+", "D+").ljust(80),
    ],
)
def test_modes_as_other_programs_end_their_lines(written, write):
    """Blanks up to column 80 and Fortran's exponents say the same."""
    from solidwhirl.analyses.measured.universal_files import read_universal

    folder, _ = written
    text = (folder / "own.unv").read_text()
    for block in _modes_alone(text):
        _, *lines, _, _ = block.split("\n")
        text = text.replace(block, "\n".join(["    -1", *map(write, lines), "    -1", ""]))
    (folder / "padded.unv").write_text(text)
    plain, padded = (read_universal(folder / f"{name}.unv", None) for name in ("own", "padded"))
    assert len(plain.modes) > 3
    for one, other in zip(plain.modes, padded.modes, strict=True):
        assert (one.frequency_hz, one.damping_ratio) == (other.frequency_hz, other.damping_ratio)
        assert one.motion.keys() == other.motion.keys()
        for node, motion in one.motion.items():
            np.testing.assert_array_equal(motion, other.motion[node])


def test_functions_of_type_general_are_named(written):
    """Of function type 0 and ordinates of no type nothing says what they are but the scene."""
    from solidwhirl.analyses.measured.universal_files import read_universal

    folder, _ = written
    text = (folder / "own.unv").read_text()
    head = re.compile(r"^(    58.*\n(?:.*\n){5}) {4}4", re.MULTILINE)
    general = head.sub(r"\g<1>    0", text)
    assert general != text
    (folder / "general.unv").write_text(general)
    plain = read_universal(folder / "own.unv", None)
    left_out = read_universal(folder / "general.unv", None)
    assert not left_out.functions and "quantity says what they are" in left_out.notes[-1]
    with pytest.raises(SceneError, match="quantity says what they are"):
        run_scene(beam(folder, measured={"functions": "general.unv"}))
    named = read_universal(folder / "general.unv", None, "accelerance")
    for one, other in zip(plain.functions, named.functions, strict=True):
        assert (one.response, one.quantity) == (other.response, other.quantity)
        np.testing.assert_array_equal(one.values, other.values)
