"""CSV tables of makers: units, headers, grids, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solidwhirl.bearing_tables import TableFileError, read_table
from solidwhirl.bearing_tables.csv_files import csv_text, read_csv
from solidwhirl.bearing_tables.units import UNITS

PATH = Path("pads.csv")
# One of each unit in SI, from the definitions of pound and inch: 0.45359237 kg, 9.80665 m/s².
POUND = 0.45359237 * 9.80665
IN_SI = {
    "stiffness": {"N/m": 1, "N/mm": 1e3, "N/um": 1e6, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6,
                  "lb/in": POUND / 0.0254},
    "mass": {"kg": 1, "N-s2/m": 1, "lb-s2/in": POUND / 0.0254},
    "speed": {"rpm": 2 * math.pi / 60, "r/min": 2 * math.pi / 60, "1/min": 2 * math.pi / 60,
              "rad/s": 1, "Hz": 2 * math.pi},
    "load": {"N": 1, "kN": 1e3, "MN": 1e6, "lb": POUND},
}  # fmt: skip
IN_SI["damping"] = {k.replace("/", "-s/"): v for k, v in IN_SI["stiffness"].items()}
IN_SI["frequency"] = IN_SI["speed"]
NAMES = ("kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy", "mxx", "mxy", "myx", "myy")
QUANTITY = {"k": "stiffness", "c": "damping", "m": "mass"}
AXES = {"speed": "speeds_rad_s", "frequency": "frequencies_rad_s", "load": "loads_n"}


def spellings(unit):
    """A unit as makers write it."""
    key = unit.lower().replace("-", "_").replace("/", "_per_")
    pound = unit.replace("lb", "lbf")
    out = [("{} " + f"[{unit}]", None), ("{}_" + key, None), ("{} " + f"({pound})", None)]
    return [
        *out,
        ("{}", unit),
        ("{}", unit.replace("-", "*").replace("s2", "s**2").replace("/in", "/inch")),
    ]


SPELLINGS = {
    quantity: [(*way, unit) for unit in units for way in spellings(unit)]
    for quantity, units in UNITS.items()
}


def test_factors_of_units():
    for quantity, units in UNITS.items():
        assert units.keys() == IN_SI[quantity].keys()
        for unit, factor in units.items():
            assert factor == pytest.approx(IN_SI[quantity][unit], rel=1e-12)


@given(st.data())
def test_round_trip_through_every_unit(data):
    """Random tables over any axes, written in any units, headings and order of rows."""
    axes = data.draw(st.lists(st.sampled_from(list(AXES)), max_size=3, unique=True))
    sizes = [data.draw(st.integers(1, 3)) for _ in axes]
    values = [np.cumsum(data.draw(
        st.lists(st.floats(0.5, 1e4), min_size=n, max_size=n))) for n in sizes]  # fmt: skip
    rows = [g.ravel() for g in np.meshgrid(*values, indexing="ij")] if axes else []
    count = int(np.prod(sizes))
    seed = data.draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    columns = random.normal(size=(12, count)) * 10.0 ** random.integers(-3, 9, size=(12, 1))
    heads, below, written = [], [], []
    for name, column in zip([*axes, *NAMES], [*rows, *columns], strict=True):
        quantity = QUANTITY.get(name[0]) if name in NAMES else name
        heading, under, unit = data.draw(st.sampled_from(SPELLINGS[quantity]))
        heads.append(heading.format(name.capitalize() if data.draw(st.booleans()) else name))
        below.append(under or "")
        written.append(column / IN_SI[quantity][unit])
    order = random.permutation(count)
    delimiter = data.draw(st.sampled_from(",;\t"))
    lines = [["banner"], heads, *([below] if any(below) else [])]
    lines += [[repr(float(v)) for v in row] for row in np.array(written).T[order]] + [[""]]
    text = "\n".join(delimiter.join(line) for line in lines)
    table = read_csv(PATH, text)
    for axis, expected in zip(axes, values, strict=True):
        np.testing.assert_allclose(getattr(table, AXES[axis]), expected, rtol=1e-12)
    # the rows were made in the order of `axes`, the table has its own
    place = [list(AXES).index(a) for a in axes]
    for start, part in ((0, "stiffness_n_per_m"), (4, "damping_n_s_per_m"), (8, "mass_kg")):
        made = columns[start : start + 4].T.reshape(*sizes, 4)
        ordered = np.transpose(made, (*np.argsort([(1, 2, 0)[p] for p in place]), len(axes)))
        found = getattr(table, part)
        np.testing.assert_allclose(found.reshape(ordered.shape), ordered, rtol=1e-11)
    again = read_csv(PATH, csv_text(table))
    np.testing.assert_allclose(again.stiffness_n_per_m, table.stiffness_n_per_m, rtol=1e-14)
    np.testing.assert_allclose(again.mass_kg, table.mass_kg, rtol=1e-14)


# Sheet XLUseKCM of XLTRC2 as a spreadsheet exports it; the values of both are in ROSS's examples,
# bearing_seal_us.xls and bearing_seal_si.xls.
XLTRC2 = """XLUseKCM\u2122 User Defined Support Stiffness,,,,,,,,,,,,
Bearing,,,,,,,,,,,,
Speed,Kxx,Kxy,Kyx,Kyy,Cxx,Cxy,Cyx,Cyy,Mxx,Mxy,Myx,Myy
rpm,lb/in,lb/in,lb/in,lb/in,lb-s/in,lb-s/in,lb-s/in,lb-s/in,lb-s**2/in,lb-s**2/in,lb-s**2/in,lb-s**2/in
3000,78789.2,0,0,78789.2,585.324,0,0,585.324,2,0,0,2
4000,171030,0,0,171030,727.756,0,0,727.756,2,0,0,2
,,,,,,,,,,,,
foot,,,,,,,,,,,,
"""


def test_sheet_of_xltrc2(tmp_path):
    path = tmp_path / "sheet.csv"
    path.write_text(XLTRC2, encoding="cp1252", errors="replace")
    table = read_table(path)
    assert table.speeds_rad_s == pytest.approx([100 * math.pi, 400 / 3 * math.pi])
    assert table.stiffness_n_per_m[0, 0, 0, 0, 0] == pytest.approx(1.37981e7, rel=1e-5)
    assert table.damping_n_s_per_m[0, 0, 0, 1, 1] == pytest.approx(1.02506e5, rel=1e-5)
    assert table.mass_kg[0, 1, 0].tolist() == pytest.approx(np.diag([350.2537] * 2), rel=1e-6)
    assert table.notes == ()


def test_missing_columns_and_decimal_commas():
    text = "rpm;kxx [MN/m];kxy [MN/m];cxx [kN·s/m];power [kW]\n"
    text += "1000;1,5;2;3;9\n2000;2,5;2;3;9\n\n7;7;7;7;7"
    table = read_csv(PATH, text)
    assert table.stiffness_n_per_m[0, 0, 0].tolist() == [[1.5e6, 2e6], [0.0, 1.5e6]]
    assert table.damping_n_s_per_m[0, 1, 0].tolist() == [[3e3, 0.0], [0.0, 3e3]]
    assert not table.mass_kg.any()
    assert table.notes == (
        "columns left out: power [kW]",
        "1 rows of numbers below an empty row are left out",
    )


HEAD = "speed_rpm,kxx_n_per_m,cxx_n_s_per_m\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no header with a column kxx"),
        ("speed_rpm,kxx_n_per_m\n1,1\n", "has no column cxx"),
        (HEAD, "has 0 rows of numbers"),
        (HEAD + "1,,3\n", "column 'kxx_n_per_m', row 1 of the numbers: found '', allowed is a num"),
        (HEAD + "1,nan,3\n", "found 'nan', allowed is a number"),
        (HEAD + "1,2,3\n1,2,3\n", "2 rows at speed 1 rpm (rows 1, 2 of the numbers)"),
        (HEAD + "-1,2,3\n", "speed -1 rpm; allowed is 0 and more"),
        ("kxx_n_per_m,cxx_n_s_per_m\n1,2\n3,4\n", "no column of speed, frequency or load"),
        ("speed_rpm,load_n,kxx [N/m],cxx_n_s_per_m\n1,1,1,1\n2,2,1,1\n", "every combination"),
        (HEAD.replace("cxx_n_s", "cxx_kg"), "'cxx_kg_per_m': no unit 'kg_per_m' of damping"),
        ("speed,kxx,cxx\n1,2,3\n", "column 'speed' has no unit; allowed is one behind its name"),
        ("speed,kxx,cxx\nrpm,N/m,N/m\n1,2,3\n", "column 'cxx': no unit 'N/m' of damping; allowed"),
        ("speed,kxx,cxx\nrpm,mN/m,N-s/m\n1,2,3\n", "no unit 'mN/m' of stiffness; allowed are N/m,"),
        ("speed,kxx,cxx\nrpm,lbs/in,lbs/in\n1,2,3\n", "no unit 'lbs/in' of damping"),
        (HEAD.strip() + ",Kxx [N/m]\n1,2,3,4\n", "kxx stands in two columns"),
        ('"a\n', "is no CSV file"),
    ],
)  # fmt: skip
def test_refusals(text, said):
    with pytest.raises(TableFileError) as error:
        read_csv(PATH, text)
    assert str(error.value).startswith("pads.csv: ")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_files_of_other_kinds(tmp_path):
    for name, said in (("a.xls", "save the sheet of coefficients as CSV"), ("a.dat", "known are")):
        with pytest.raises(TableFileError, match=said):
            read_table(tmp_path / name)
    with pytest.raises(TableFileError, match="no such file"):
        read_table(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("header", "speed", "kxy"),
    [
        ("omega [rad/s],kxx [N/m],kxy [N/m],cxx [N s/m]", 1000.0, 7.0),
        ("Omega (rad/s),K11 [N/m],K12 [N/m],C11 [N s/m]", 1000.0, 7.0),
        ("n [rpm],K_11 [N/m],K_12 [N/m],C_11 [N s/m]", 1000.0 * math.pi / 30.0, 7.0),
        ("rotational speed [Hz],K_{xx} [N/m],K_{xy} [N/m],C_{xx} [N s/m]", 2e3 * math.pi, 7.0),
    ],
)
def test_columns_as_others_call_them(header, speed, kxy):
    table = read_csv(PATH, f"{header}\n1000,5,7,3\n2000,6,7,3\n")
    assert table.speeds_rad_s == pytest.approx([speed, 2.0 * speed])
    assert table.stiffness_n_per_m[0, 0, 0].tolist() == [[5.0, kxy], [0.0, 5.0]]
    if "1" in header.split(",")[1]:
        assert any("is taken as kxy" in note for note in table.notes)


def test_symbols_head_axes_with_a_unit_alone():
    """Numbers of rows and pads, which some programs head with n, are none."""
    table = read_csv(PATH, "n,n_pads," + HEAD + "1,5,1000,2,3\n2,5,2000,2,3\n")
    assert table.speeds_rad_s == pytest.approx([1000 * math.pi / 30, 2000 * math.pi / 30])
    assert table.notes == ("columns left out: n, n_pads",)


def test_what_is_not_given_is_told():
    only = read_csv(PATH, HEAD + "1000,2,3\n2000,2,3\n")
    assert only.assumed == (
        "no column kyy, cyy: taken as kxx, cxx, the same in x and y",
        "no column kxy, kyx, cxy, cyx: taken as 0",
    )
    names = ",".join(f"{k}{end}" for k in "kc" for end in ("xx", "xy", "yx", "yy"))
    units = ",".join(["N/m"] * 4 + ["N s/m"] * 4)
    assert read_csv(PATH, f"rpm,{names}\nrpm,{units}\n" + "1,2,3,4,5,6,7,8,9\n").assumed == ()


@pytest.mark.parametrize(
    ("row", "numbers"),
    [
        ('"1,000","1,500,000","2.5"', (1000.0, 1.5e6, 2.5)),
        ("1,000;1,500,000;2,000", (1000.0, 1.5e6, 2000.0)),
        ("1,000;2,000.5;3", (1000.0, 2000.5, 3.0)),
        ("1,000;0,500;3", (1.0, 0.5, 3.0)),
        ("1,000;1,5e6;3", (1.0, 1.5e6, 3.0)),
        ("1 000;1'500'000;2,5", (1000.0, 1.5e6, 2.5)),
        ("1\u202f000;12\u00a0000;2.5", (1000.0, 12e3, 2.5)),
    ],
)
def test_commas_blanks_and_apostrophes_in_numbers(row, numbers):
    heads = HEAD if row.startswith('"') else HEAD.replace(",", ";")
    table = read_csv(PATH, heads + row + "\n")
    assert table.speeds_rad_s * 30.0 / math.pi == pytest.approx(numbers[:1])
    assert table.stiffness_n_per_m[0, 0, 0, 0, 0] == pytest.approx(numbers[1])
    assert table.damping_n_s_per_m[0, 0, 0, 0, 0] == pytest.approx(numbers[2])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD.replace(",", ";") + "1,000;2,000;3\n", "'1,000', which may be 1000 or 1.000"),
        (HEAD.replace(",", ";") + "1,000,000;2,5;3\n", "'1,000,000' and '2,5'"),
        (HEAD + "1,000,2e6,3\n2,000,2e6,3\n", "row 1 of the numbers has 4 cells for 3 columns"),
        (HEAD.replace("rpm", "hz") + "5,2,3\n6,2,3\n5,2,3\n", "at speed 5 hz (rows 1, 3 of"),
        ("omega [rad/s]," + HEAD + "1,1,2,3\n", "speed stands in two columns"),
    ],
)
def test_numbers_that_may_mean_two_things_are_refused(text, said):
    with pytest.raises(TableFileError) as refused:
        read_csv(PATH, text)
    assert said in str(refused.value)
