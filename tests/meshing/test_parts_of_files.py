"""What INP and BDF files hold beside solid elements: taken, or refused by name, count and line."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_makers import BDF, INP, request

from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_from_file
from solidwhirl.meshing.imported.formats.files import read_mesh_file
from solidwhirl.meshing.imported.masses import carried_masses, mass_unit_kg
from solidwhirl.meshing.imported.records import MeshInterface


def inp(more):
    return INP.replace("*SOLID SECTION", f"{more}*SOLID SECTION", 1)


def bdf(more):
    return BDF.replace("CQUAD4         9", f"{more}CQUAD4         9", 1)


# What is put into the file of two bricks, and what is said of it.
REFUSED = {
    "springs.inp": (
        "*ELEMENT, TYPE=SPRINGA, ELSET=SP\n50, 1, 11\n51, 2, 12\n*SPRING, ELSET=SP\n\n1e6\n",
        r"found \*SPRING \(1, the first in line 34\).*, \*ELEMENT, TYPE=SPRINGA "
        r"\(2, the first in line 31\), whose .* \[\[bearings\]\]",
    ),
    "dashpot.inp": ("*ELEMENT, TYPE=DASHPOTA\n50, 1, 11\n", r"TYPE=DASHPOTA \(1, .* line 31"),
    "beams.inp": ("*ELEMENT, TYPE=B31, ELSET=B\n50, 1, 11\n51, 2, 12\n", r"TYPE=B31 \(2,"),
    "trusses.inp": (
        "*ELEMENT, TYPE=T3D2, ELSET=T\n50, 1, 11\n*SOLID SECTION, ELSET=T, MATERIAL=S\n1.\n",
        r"\*SOLIDSECTION of line elements \(1, the first in line 33",
    ),
    "shells.inp": (
        "*ELEMENT, TYPE=S4, ELSET=SH\n50, 1, 2, 3, 4\n*SHELL SECTION, ELSET=SH, MATERIAL=S\n1.\n",
        r"\*SHELLSECTION of quad elements \(1, .*, whose .* name surfaces alone",
    ),
    "equation.inp": ("*EQUATION\n2\n1,1,1.,2,1,-1.\n", r"\*EQUATION \(1, the first in line 31"),
    "mpc.inp": ("*MPC\nBEAM, 1, 11\n*MPC\nBEAM, 2, 12\n", r"\*MPC \(2, the first in line 31"),
    "tie.inp": ("*TIE, NAME=T\nROOF, WALL\n", r"\*TIE \(1,"),
    "matrix.inp": ("*MATRIX INPUT, NAME=K, INPUT=k.mtx\n", r"\*MATRIXINPUT \(1,"),
    "connector.inp": ("*ELEMENT, TYPE=CONN3D2\n50, 1, 11\n", r"TYPE=CONN3D2 \(1,"),
    "no mass.inp": (
        "*ELEMENT, TYPE=MASS, ELSET=M\n50, 1\n51, 2\n",
        r"MASS 50 \(line 31\): no \*MASS or \*ROTARY INERTIA says how much it is, nor of 1 other",
    ),
    "lateral.inp": (
        "*COUPLING, REF NODE=1, SURFACE=ROOF, CONSTRAINT NAME=C\n*KINEMATIC\n1, 2\n",
        r"line 32: \*KINEMATIC: couples motions \[1, 2\] alone",
    ),
    "CBAR.bdf": (
        "CBAR,30,1,1,2,0.,0.,1.\nCBAR,31,1,1,3,0.,0.,1.\n",
        r"CBAR \(2, the first in line 23 of",
    ),
    "CELAS2.bdf": ("CELAS2,30,1.+6,1,1\n", r"CELAS2 \(1, .* \[\[bearings\]\]"),
    "CBUSH.bdf": ("CBUSH   30      1       1       11\n", r"CBUSH \(1,"),
    "CMASS2.bdf": ("CMASS2,30,1.,1,1\n", r"CMASS2 \(1, .* give the mass as point masses"),
    "PSHELL.bdf": ("PSHELL,40,1,.01\n", r"CQUAD4 of property 40 \(1, the first in line 24"),
    "RBAR.bdf": ("RBAR,30,1,11,123456\n", r"RBAR \(1, .* reference node"),
    "MPC.bdf": ("MPC,1,1,1,1.,2,1,-1.\n", r"MPC \(1,"),
    "CHEXA8.bdf": ("CHEXA8,30,1\n", r"CHEXA8 \(1, .* mesh the part with CTETRA"),
    "twice.bdf": ("GRID,24,,0.,1.,2.\n", "GRID 24 is defined twice, again in line"),
    "offset.bdf": ("CONM2,30,1,,2.,.1,0.,0.\n", r"CONM2 30 \(line 23 .* has no rotation"),
    "alone.bdf": ("GRID,99,,5.,5.,5.\nCONM2,30,99,,2.\n", r"CONM2 30 .* nothing carries it"),
    "lateral.bdf": ("GRID,99,,5.,5.,5.\nRBE2,30,99,12,1,2,3\n", "RBE2: couples motions '12' alone"),
    "weights.bdf": (
        "GRID,99,,5.,5.,5.\nRBE3,30,,99,123456,1.,123,1,2,+\n+,2.,123,3,4\n",
        "weighs its nodes differently",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_stiff_or_heavy_and_not_taken_is_refused(tmp_path, name):
    more, message = REFUSED[name]
    (tmp_path / name).write_text(inp(more) if name.endswith("inp") else bdf(more))
    with pytest.raises(MeshingError, match=message):
        mesh_from_file(request(tmp_path / name), "block")


def test_what_does_no_harm_is_passed_over_and_the_rest_told(tmp_path):
    more = "*CONTACT PAIR, INTERACTION=I\nROOF, WALL\n*OUTPUT, FIELD\n*AMPLITUDE, NAME=A\n0,0\n"
    (tmp_path / "a.inp").write_text(inp(more * 2))
    (told,) = read_mesh_file(tmp_path / "a.inp").remarks
    assert told.startswith("*CONTACTPAIR (2, the first in line 31) is not known here")
    (tmp_path / "a.bdf").write_text(bdf("SPC1,1,123,4\nXYZ,1\nMAT1,1,2.1+11,,.3,7800.\n"))
    (told,) = read_mesh_file(tmp_path / "a.bdf").remarks
    assert told.startswith("XYZ (1, the first in line 24 of a.bdf)")


INP_MASS = """*ELEMENT, TYPE=MASS, ELSET=HEAVY
50, 12
51, 23
*MASS, ELSET=heavy
3.
"""
BDF_MASS = (
    "CONM2,30,12,,3.\nCONM2*                51              23               0             3.\n"
)


@pytest.mark.parametrize(("name", "text"), [("a.inp", inp(INP_MASS)), ("a.bdf", bdf(BDF_MASS))])
@pytest.mark.parametrize("unit_m", [1.0, 1e-3])
def test_point_masses_are_on_their_nodes(tmp_path, name, text, unit_m):
    """Mass, centre and inertia of two bricks of steel and two masses, by hand; with mm in t."""
    (tmp_path / name).write_text(text)
    asked = request(tmp_path / name, unit_m=unit_m)
    mass = body_of_mesh("block", asked, mesh_from_file(asked, "block")).mass
    bricks, heavy = asked.material.density_kg_per_m3 * 2.0 * unit_m**3, 3.0 / unit_m
    assert mass.mass_kg == pytest.approx(bricks + 2.0 * heavy, rel=1e-13)
    places = unit_m * np.array([[1.0, 0.0, 1.0], [1.0, 1.0, 2.0], [0.5, 0.5, 1.0]])
    weight = np.array([heavy, heavy, bricks])
    centre = weight @ places / weight.sum()
    assert mass.center_of_gravity_m == pytest.approx(tuple(centre), rel=1e-12)
    polar = bricks / 12.0 * 2.0 * unit_m**2 + weight @ ((places - centre)[:, :2] ** 2).sum(axis=1)
    assert mass.inertia_kg_m2[2][2] == pytest.approx(polar, rel=1e-12)


def test_unit_of_mass(tmp_path):
    """Densities of the file tell a unit that can not be; WTMASS turns weights into masses."""
    (tmp_path / "a.inp").write_text(inp(INP_MASS + "*MATERIAL, NAME=M\n*DENSITY\n7.85e-6\n"))
    found = read_mesh_file(tmp_path / "a.inp")
    with pytest.raises(
        MeshingError, match=r"7.85e-06 .* would be 7.85e\+06 kg/m³ .* say mass_unit"
    ):
        mass_unit_kg(found, 1e-3, None)
    assert mass_unit_kg(found, 1e-3, 1.0) == 1.0
    (tmp_path / "a.bdf").write_text(bdf(BDF_MASS + "PARAM,WTMASS,.002588\nMAT1,1,3.+7,,.3,.284\n"))
    # pounds: 0.284 lb/in³ is steel; one lbf s²/in is 386.09 lb
    found = read_mesh_file(tmp_path / "a.bdf")
    assert mass_unit_kg(found, 0.0254, None) == pytest.approx(0.45359237, rel=1e-3)


REFERENCE = {
    "a.inp": inp(
        "*NODE, NSET=REF\n99, .5, .5, 2.75\n"
        "*COUPLING, CONSTRAINT NAME=Hub, REF NODE=REF,\n  SURFACE=roof\n*DISTRIBUTING\n"
        "*ELEMENT, TYPE=MASS, ELSET=M\n50, 99\n*MASS, ELSET=M\n4.,\n"
        "*ELEMENT, TYPE=ROTARYI, ELSET=R\n51, 99\n"
        "*ROTARY INERTIA, ELSET=R\n.2, .2, .3, 0., 0., 0.\n"
    ),
    "a.bdf": bdf(
        "GRID,99,,.5,.5,2.5\nRBE3,7,,99,123456,1.,123,21,22,+\n+,23,24\n"
        "CONM2,30,99,,4.,0.,0.,.25,,+\n+,.2,0.,.2,0.,0.,.3\n"
    ),
    "absolute.bdf": bdf(
        "GRID,99,,.5,.5,2.5\nRBE2,7,99,123456,21,THRU,24\n"
        "CONM2,30,99,-1,4.,.5,.5,2.75,,+\n+,.2,0.,.2,0.,0.,.3\n"
    ),
    "matrix.bdf": bdf(
        "GRID,99,,.5,.5,2.75\nRBE2,7,99,123456,21,22,23,24\n"
        "CONM1,30,99,,4.,,4.,,,+\n+,4.,,,,.2,,,,+\n+,,.2,,,,,,.3\n"
    ),
}


@pytest.mark.parametrize("name", REFERENCE)
def test_masses_on_reference_nodes_are_disks(tmp_path, name):
    (tmp_path / name).write_text(REFERENCE[name])
    asked = request(tmp_path / name, origin=(0.5, 0.5, 0.0), shape="round")
    found = read_mesh_file(tmp_path / name)
    total = [0.0] * 3
    for mass in carried_masses(found, asked):
        node = found.points[mass.coupling.node]
        for k, own in enumerate((mass.mass_kg, mass.polar_kg_m2, mass.diametral_kg_m2)):
            total[k] += own
        if mass.mass_kg:
            assert node[2] + mass.offset_m == pytest.approx(2.75)
    assert total == pytest.approx([4.0, 0.3, 0.2])
    (coupling,) = found.couplings
    rigid = {"absolute.bdf", "matrix.bdf"}
    assert coupling.coupling == ("rigid" if name in rigid else "distributing")
    assert coupling.name == (
        "Hub" if name == "a.inp" else "rbe3_7" if name == "a.bdf" else "rbe2_7"
    )
    seat = MeshInterface(name="seat", coupling="rigid", group=coupling.name, node="centroid")
    made = mesh_from_file(request(tmp_path / name, interfaces=(seat,)), "block")
    assert len(made.interfaces["seat"]) == 2
    beside = request(tmp_path / name, origin=(0.4, 0.5, 0.0), shape="round")
    with pytest.raises(MeshingError, match=r"lies 0.1 m off the axis"):
        carried_masses(found, beside)


CAE = """*Heading
*Part, name=Block
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*Element, type=C3D8R
1, 1, 2, 3, 4, 5, 6, 7, 8
*Elset, elset=Set-1, generate
1, 400000000, 1
*Solid Section, elset=Set-1, material=Steel
*End Part
*Part, name=Unused
*Node
1, 7., 7., 7.
*End Part
*Assembly, name=Assembly
*Instance, name=Block-1, part=Block
{place}
*End Instance
*Node
1, 0.5, 0.5, 9.
*Nset, nset=RP, internal
1,
*Nset, nset=Foot, instance=BLOCK-1
1, 2, 3, 4
*Elset, elset=_Top_S2, internal,
 instance=Block-1
1,
*Surface, type=ELEMENT, name=Top
_TOP_S2, S2
*Surface, type=NODE, name=Low
Block-1.1,
Block-1.2,
foot, 1.
*End Assembly
"""
PLACES = {
    "in place": ("** nothing", np.eye(3), (0.0, 0.0, 0.0)),
    "moved by zero": ("0., 0., 0.", np.eye(3), (0.0, 0.0, 0.0)),
    "moved": ("1., 2., 3.", np.eye(3), (1.0, 2.0, 3.0)),
    # first moved, then turned by 90° about the line through (0, 0, 0) along x
    "turned": (
        "1., 2., 3.\n0., 0., 0., 5., 0., 0., 90.",
        np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
        (1.0, -3.0, 2.0),
    ),
}


@pytest.mark.parametrize("case", PLACES)
def test_assemblies_of_one_part(tmp_path, case):
    """Reference points, parts without instance, other capitals, a line that goes on."""
    place, turn, shift = PLACES[case]
    (tmp_path / "cae.inp").write_text(CAE.format(place=place))
    found = read_mesh_file(tmp_path / "cae.inp")
    own = [row for row in range(len(found.points)) if row in found.blocks[0].nodes]
    corners = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    assert found.points[own] == pytest.approx(corners @ turn.T + np.array(shift), abs=1e-15)
    assert set(found.node_groups["Foot"]) == set(found.node_groups["Low"]) == set(own[:4])
    assert set(found.face_groups["Top"][0].ravel()) == set(own[4:])
    assert found.element_groups["Set-1"][0].tolist() == [0]
    (told,) = found.remarks
    assert told.startswith("*PART UNUSED (1, the first in line 19) is in no *INSTANCE")


def test_names_in_other_capitals_are_found(tmp_path):
    (tmp_path / "a.inp").write_text(INP)
    seats = [MeshInterface(name=n, coupling="rigid", group=n) for n in ("roof", "Foot")]
    asked = request(
        tmp_path / "a.inp", materials=(("low", request("").material),), interfaces=tuple(seats)
    )
    mesh = mesh_from_file(asked, "block")
    assert [len(mesh.interfaces[n]) for n in ("roof", "Foot")] == [2, 2]


def test_sets_that_double_stay_small(tmp_path):
    """Forty sets, each of the one before twice: 2^40 entries if repeats were kept."""
    sets = "*ELSET, ELSET=S0\n5, 6\n" + "".join(
        f"*ELSET, ELSET=S{k + 1}\nS{k}, S{k}\n" for k in range(40)
    )
    (tmp_path / "a.inp").write_text(inp(sets))
    assert len(read_mesh_file(tmp_path / "a.inp").element_groups["S40"][0]) == 2


SYSTEMS = {
    "basic": "CORD2R,3,,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n",
    "turned": "CORD2R,3,,1.,0.,0.,1.,0.,1.,+\n+,1.,1.,0.\n",
    "cylinder": "CORD2C,3,4,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n"
    "CORD2R,4,0,1.,0.,0.,1.,0.,1.,+\n+,1.,1.,0.\n",
    "by grids": "GRID,71,,1.,0.,0.\nGRID,72,,1.,0.,1.\nGRID,73,,1.,1.,0.\nCORD1R,3,71,72,73\n",
    "sphere": "CORD2S,3,,1.,0.,0.,1.,0.,1.,+\n+,1.,1.,0.\n",
}
# Corner 24 = (0, 1, 2) in them: x' = y, y' = 1 - x in the turned one about (1, 0, 0).
COORDINATES = {
    "basic": "0.,1.,2.",
    "turned": "1.,1.,2.",
    "cylinder": f"{2.0**0.5:.14f},45.,2.",
    "by grids": "1.,1.,2.",
    "sphere": f"{6.0**0.5:.14f},{np.degrees(np.arctan(0.5**0.5)):.12f},45.",
}


@pytest.mark.parametrize("case", SYSTEMS)
def test_coordinate_systems(tmp_path, case):
    text = BDF.replace("GRID,24,,0.,1.,2.", f"GRID,24,3,{COORDINATES[case]}")
    text = text.replace("CQUAD4         9", f"{SYSTEMS[case]}CQUAD4         9", 1)
    (tmp_path / "a.bdf").write_text(text)
    (tmp_path / "b.bdf").write_text(BDF)
    with_system, plain = (read_mesh_file(tmp_path / f"{n}.bdf") for n in "ab")
    count = len(plain.points)
    assert with_system.points[:count] == pytest.approx(plain.points, abs=1e-11)


def test_files_in_several_pieces(tmp_path):
    head, tail = BDF.split("GRID,21")
    (tmp_path / "nodes.txt").write_text("GRID,21" + tail.split("CHEXA")[0])
    rest = "CHEXA" + tail.split("CHEXA", 1)[1]
    (tmp_path / "a.bdf").write_text(f"{head}INCLUDE 'nodes.txt'\n{rest}")
    found = read_mesh_file(tmp_path / "a.bdf")
    assert [f.name for f in found.files] == ["a.bdf", "nodes.txt"]
    assert len(found.points) == 12
    (tmp_path / "more.inp").write_text("21, 0., 0., 2.\n22, 1., 0., 2.\n")
    text = INP.replace("21, 0., 0., 2.\n22, 1., 0., 2.\n", "")
    (tmp_path / "more.inp").write_text("*NODE\n21, 0., 0., 2.\n22, 1., 0., 2.\n")
    (tmp_path / "a.inp").write_text(
        text.replace("*ELEMENT", "*INCLUDE, INPUT=more.inp\n*ELEMENT", 1)
    )
    found = read_mesh_file(tmp_path / "a.inp")
    assert [f.name for f in found.files] == ["a.inp", "more.inp"]
