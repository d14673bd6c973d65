"""Views in space: what is coloured, what moves, and what the files hold."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from types import SimpleNamespace

import imageio.v2 as imageio
import numpy as np
import pytest

from solidwhirl.core.errors import OutputError
from solidwhirl.drawing.modes import pictured_modes
from solidwhirl.drawing.motion import SECTORS
from solidwhirl.drawing.surfaces import outer_faces
from solidwhirl.pictures import animation, stills
from solidwhirl.pictures.animation import mode_frames, write_film
from solidwhirl.pictures.engine_shape import engine_shape
from solidwhirl.pictures.stills import cropped, draw_mode_still, edges_of, polydata

BLUE, ORANGE = (0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)


@pytest.fixture(scope="module")
def shapes(twin):
    return [engine_shape(twin, pictured_modes(twin, 2)[1], k) for k in range(2)]


def _near(image, color):
    return (np.abs(image.astype(int) - np.array(color)).max(axis=2) < 40).sum()


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(stills, "_PIXELS", (500, 300))
    monkeypatch.setattr(animation, "_PIXELS", (240, 160))
    monkeypatch.setattr(animation, "_DPI", 40)
    monkeypatch.setattr(animation, "_FRAMES", 2)


@pytest.mark.verify
def test_orbits_have_the_colour_of_their_whirl(shapes, small):
    """The colours of the bodies, cividis, come near neither of the two."""
    backward, forward = (stills.shape_image(shape) for shape in shapes)
    assert _near(backward, ORANGE) > 20 > _near(backward, BLUE) - _near(forward, BLUE)
    assert _near(forward, BLUE) > _near(backward, BLUE) + 20
    assert _near(forward, ORANGE) == 0


def test_still_is_written_as_print_and_as_image(shapes, small, tmp_path):
    for kind, start in (("png", b"\x89PNG"), ("pdf", b"%PDF")):
        draw_mode_still(shapes[0], tmp_path / f"m.{kind}", "Twin")
        assert (tmp_path / f"m.{kind}").read_bytes().startswith(start)


def test_surface_in_space_has_the_displacement(shapes):
    shape = shapes[0]
    for body in shape.bodies:
        surface = polydata(body, 0.3, shape.largest_m)
        moved = np.linalg.norm(np.asarray(surface.points) - body.points_m, axis=1)
        # points are in single precision
        np.testing.assert_allclose(surface["displacement"], moved / shape.largest_m, atol=1e-4)
        assert surface.n_cells == len(body.quadrangles) + len(body.triangles) + len(body.lines)


def test_edges_of_a_shaft_are_its_two_rims(geared):
    """A shaft of one radius: a rim at each end, nothing on its end faces or along it."""
    shape = engine_shape(geared, pictured_modes(geared, 1)[1], 0)
    shaft = next(body for body in shape.bodies if body.body == "slow")
    still = dataclasses.replace(shaft, motion_m=np.zeros_like(shaft.motion_m))
    edges = edges_of(polydata(still, 0.0, 1.0))
    assert edges.n_cells == 2 * SECTORS
    points = np.asarray(edges.points)
    # points are in single precision
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 0.02, rtol=1e-6)
    assert set(np.round(points[:, 2], 6)) == {0.0, 0.5}


def test_a_solid_is_drawn_by_its_outer_faces(small, tmp_path):
    """A cube of six tetrahedra around a diagonal: two triangles on each of its six sides."""
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    paths = ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1))
    cells = np.array([(0, a, b, 7) for a, b in paths])
    faces = outer_faces(cells)
    assert len(faces) == 12
    sides = points[faces]
    # each lies in a plane x, y or z = 0 or 1
    assert all((np.ptp(side, axis=0) == 0.0).any() for side in sides)
    mesh = SimpleNamespace(points=points, cells=cells)
    stills.draw_solid_mesh(mesh, tmp_path / "cube.png", "Cube")
    assert (tmp_path / "cube.png").read_bytes().startswith(b"\x89PNG")


def test_cropping_keeps_all_that_is_not_white():
    image = np.full((200, 300, 3), 255, dtype=np.uint8)
    image[80:90, 100:140] = 0
    part = cropped(image)
    assert part.shape == (34, 64, 3)
    assert (part == 0).sum() == (image == 0).sum()
    assert cropped(np.full((5, 6, 3), 255, dtype=np.uint8)).shape == (5, 6, 3)


FILM = """
import sys
from pathlib import Path

import imageio.v2 as imageio
import numpy as np

from solidwhirl.pictures.animation import write_film

folder = Path(sys.argv[1])
write_film(list(np.load(folder / "frames.npy")), folder / "m.mp4")
with imageio.get_reader(folder / "m.mp4") as film:
    data = film.get_meta_data()
    print(data["codec"], *data["size"], film.count_frames())
"""


@pytest.mark.verify
def test_film_moves_and_repeats(shapes, small, tmp_path):
    told = []
    frames = mode_frames(shapes[1], "Twin", lambda frame, count: told.append((frame, count)))
    assert told == [(k + 1, len(frames)) for k in range(len(frames))]
    first, second = frames
    assert first.shape == second.shape and (first != second).any()
    assert all(size % 16 == 0 for size in first.shape[:2])
    write_film(frames, tmp_path / "m.gif")
    assert len(imageio.mimread(tmp_path / "m.gif")) == 2
    # in a process of its own: the library copies the one that calls it to start the encoder, which
    # the system may refuse of one that has grown with all tests before
    np.save(tmp_path / "frames.npy", np.stack(frames))
    done = subprocess.run(
        [sys.executable, "-c", FILM, str(tmp_path)], check=True, capture_output=True, text=True
    )
    (tmp_path / "frames.npy").unlink()
    codec, width, height, count = done.stdout.split()
    assert codec.startswith("h264")
    assert (int(width), int(height)) == first.shape[1::-1]
    assert int(count) == 6
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.gif", "m.mp4"]
    with pytest.raises(OutputError, match=r"a film is gif or mp4, found '.avi'"):
        write_film([], tmp_path / "m.avi")


def test_of_a_pair_each_mode_is_shown_with_its_own_whirl(laval):
    """The first two critical speeds of a Laval rotor are one; unbalance excites the forward."""
    _, shown = pictured_modes(laval, 2)
    assert shown.rpm[0] == pytest.approx(shown.rpm[1], rel=1e-6)
    assert shown.whirl == ("forward", "backward")
    for k, whirl in enumerate(shown.whirl):
        shape = engine_shape(laval, shown, k)
        assert shape.whirl == whirl
        assert {orbit.whirl for orbit in shape.orbits} == {whirl}
