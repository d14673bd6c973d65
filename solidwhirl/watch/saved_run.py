"""The bodies of a run, from the files in its folder: nothing is reduced again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from solidwhirl.beams.scene_bodies import BeamBodies
from solidwhirl.bodies.reduction import Clock
from solidwhirl.cache.files import MemoryStore
from solidwhirl.core.errors import KeyPath, SceneError, UserError
from solidwhirl.core.stages import silent
from solidwhirl.files.run_folder import SCENE
from solidwhirl.identify.scene import scene_text
from solidwhirl.model.bodies import build_bodies
from solidwhirl.pipeline.body_stages import Job
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.run import ReducedBodies
from solidwhirl.reduced_scene import ReducedScene, plan_of
from solidwhirl.rotordyn import read_superelement
from solidwhirl.rotordyn.core.foreign import ForeignError, json_data, regular_bytes
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.paths import with_entries
from solidwhirl.scene_reading.reader import parse_scene, scene_hash
from solidwhirl.watch.session import RESTS, Session, Shown, remarks_on

_ANEW = "run the scene again"
_WITHOUT_BANDS = (
    "Bodies come from the files of the run, which hold nothing to estimate errors from: there are "
    "no error bands."
)


class SavedRun:
    """The folder of a run; numbers go into a new scene file beside the one who started this.

    `data`: content of its scene; `reduced`: its bodies, on its supports.
    """

    writes_new_file = True

    def __init__(self, folder: Path, data: Mapping[str, Any], reduced: ReducedScene) -> None:
        self.path = folder
        self._data, self.reduced = data, reduced

    def start(self, session: Session) -> None:
        """Show the run in a session."""
        levels = dict.fromkeys(e.level for e in self.reduced.reduced.elements.values())
        session.show(
            Shown(
                reduced=self.reduced,
                data=self._data,
                level=f"{', '.join(levels)}, from files",
                remarks=remarks_on(self.reduced, _WITHOUT_BANDS),
            )
        )

    def write(self, numbers: Mapping[KeyPath, float], name: str) -> str:
        """Write a new scene file with other numbers; returns what was done.

        Raises UserError, OSError: a name that can not be, a file that is there already.
        """
        path = Path(name.strip())
        if path.suffix != ".toml" or len(path.parts) != 1 or not path.name.isprintable():
            raise UserError(f"{name!r}: a name that ends with .toml, without a folder, is wanted")
        header = (f"The scene of {self.path} with other supports or operating speeds.",)
        text = scene_text(with_entries(self._data, dict(numbers)), {}, header)
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError as error:
            raise UserError(f"{path}: is there already; choose another name") from error
        return f"written: {path.absolute()}"

    def end(self, patience_s: float) -> bool:
        """Return True: nothing works here."""
        return True


def read_run(folder: Path) -> SavedRun:
    """Read the scene and the superelements of a run from its folder.

    Raises UserError: the folder lacks what is needed, or holds what does not belong together.
    """
    data, document = _json(folder / SCENE), _json(folder / "results.json")
    scene = parse_scene(dict(data), folder / SCENE)
    told = document.get("scene")
    if not isinstance(told, dict) or scene_hash(scene) != told.get("sha256"):
        raise SceneError(folder, [f"{SCENE} is not the scene of results.json; {_ANEW}"])
    lean = _lean(data)
    return SavedRun(folder, lean, _reduced(folder, scene, document))


def _json(path: Path) -> dict[str, Any]:
    try:
        found = json_data(regular_bytes(path))
    except ForeignError as error:
        raise UserError(f"{path}: {error}; {_ANEW}, of which this folder is made") from error
    if not isinstance(found, dict):
        raise UserError(f"{path}: is no table; {_ANEW}")
    return found


def _reduced(folder: Path, scene: Scene, document: Mapping[str, Any]) -> ReducedScene:
    """The bodies of the files in a scene, without what estimates errors."""
    scene = scene.model_copy(update={"model": scene.model.model_copy(update={"estimates": "off"})})
    elements = {}
    for name in scene.speed_ratios():
        path = folder / "bodies" / f"{name}.h5"
        if not path.is_file():
            raise UserError(f"{path}: is missing; {_ANEW}")
        elements[name] = read_superelement(path)
    geometry = build_bodies(scene)
    job = Job(
        scene=scene,
        plan=plan_of(scene, geometry, elements),
        comm=None,
        clock=Clock(),
        stage_cache=StageCache(store=MemoryStore(most=RESTS), progress=silent),
    )
    return ReducedScene(
        reduced=ReducedBodies(
            job=job,
            geometry=geometry,
            bodies={},
            elements=elements,
            beams=BeamBodies(elements={}, variants=(), finer={}),
        )
    )


def _lean(data: Mapping[str, Any]) -> dict[str, Any]:
    """The content of a scene with matrices as short as a file may say them."""
    bearings = [
        {key: _short(value) if _is_matrix(value) else value for key, value in bearing.items()}
        for bearing in data.get("bearings", [])
    ]
    return {**data, "bearings": bearings} if bearings else dict(data)


def _is_matrix(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(v, list) for v in value)


def _short(matrix: list[list[float]]) -> Any:
    (xx, xy), (yx, yy) = matrix
    if xy or yx:
        return matrix
    return xx if xx == yy else [xx, yy]
