"""What the analyses of a scene ask for and can not have, found before anything is meshed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.analyses.base import OperatingSpec
from solidwhirl.analyses.registry import AnalysisSpec
from solidwhirl.core.errors import unknown
from solidwhirl.geometry.features import MOST
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.magnetic_bearings import MagneticLawSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import EFFECT_OF, acting_on, is_off_axis
from solidwhirl.scene_checks.operating import conflicts, running_speeds
from solidwhirl.scene_checks.recovery_references import no_common_sector, no_solid, sectors_of

if TYPE_CHECKING:
    from solidwhirl.analyses.api617.analysis import Api617Spec
    from solidwhirl.analyses.kinds.critical_speed_map import CriticalSpeedMapSpec
    from solidwhirl.analyses.kinds.stiffness_study import StiffnessStudySpec
    from solidwhirl.analyses.nodal_diameters.analysis import NodalDiametersSpec
    from solidwhirl.analyses.responses.asymmetric_response import AsymmetricResponseSpec
    from solidwhirl.analyses.responses.nonlinear_response import NonlinearResponseSpec
    from solidwhirl.analyses.responses.run_up import RunUpSpec
    from solidwhirl.analyses.responses.static import StaticSpec

# Keys of analyses by what they name.
_PLACES = (
    *("at", "observe", "excite", "places", "inputs", "outputs", "drives", "applied_at"),
    "first",
)
_BODIES = ("bodies", "body", "excited_by", "shaft", "compare_flexible")
_BEARINGS = ("bearings", "bearing", "journals", "mount")
# What a run-up must record and step per turn of an unbalance.
_RECORDS_PER_TURN = 2.5
_LARGEST_ANGLE_RAD = 1.0


def analysis_problems(scene: Scene) -> list[str]:
    """What the analyses name and can not have: one line each, which begins with the key."""
    places = scene.places()
    problems = []
    for k, analysis in enumerate(scene.analyses):
        found = [*_name_problems(scene, analysis, places)]
        if not found:
            found = [*_turning_problems(scene, analysis), *_further_problems(scene, analysis)]
        problems += [f"analyses[{k}]{'' if text[0] == ':' else '.'}{text}" for text in found]
    return [*problems, *_operating_problems(scene), *_file_problems(scene)]


def _operating_problems(scene: Scene) -> Iterator[str]:
    """Operating speeds of shafts that are not there or stand still."""
    ratios = scene.speed_ratios()
    for k, own in enumerate(scene.operating):
        if own.shaft not in ratios:
            yield f"operating[{k}].shaft: {unknown('body', own.shaft, list(ratios))}"
        elif ratios[own.shaft] == 0.0:
            yield f"operating[{k}].shaft: {own.shaft!r} does not turn; it has no operating speed"
    yield from _conflicts(scene, "operating", scene.operating)
    for k, analysis in enumerate(scene.analyses):
        yield from _conflicts(scene, f"analyses[{k}].operating", [*analysis.operating_named()])


def _conflicts(scene: Scene, where: str, entries: Sequence[OperatingSpec]) -> Iterator[str]:
    """Speeds of two shafts that turn at another ratio than they do."""
    ratios = scene.speed_ratios()
    seats = {end.partition(".")[0] for gear in scene.gears for end in (gear.first, gear.second)}
    if all(ratios.get(name) for name in {*seats, *(o.shaft for o in entries)}):
        yield from (f"{where}[{k}]: {text}" for k, text in conflicts(scene, entries))


def _name_problems(scene: Scene, spec: AnalysisSpec, places: list[str]) -> Iterator[str]:
    bodies = list(scene.interface_names())
    bearings = [b.name for b in scene.bearings]
    for key, value in _named(spec):
        kind = _last(key)
        if kind in _PLACES and value not in places:
            yield f"{key}: {unknown('interface', value, places)}"
        elif kind == "second" and value not in [*places, "ground"]:
            yield f"{key}: {unknown('interface', value, [*places, 'ground'])}"
        elif kind in _BODIES and value not in bodies:
            yield f"{key}: {unknown('body', value, bodies)}"
        elif kind in _BEARINGS and value not in bearings:
            yield f"{key}: {unknown('bearing', value, bearings)}"


def _turning_problems(scene: Scene, spec: AnalysisSpec) -> Iterator[str]:
    reasons = spec.turning
    for key, value in _named(spec):
        body = value.partition(".")[0]
        if _last(key) in reasons and scene.speed_ratio(body) == 0.0:
            yield f"{key}: {body!r} does not turn; {reasons[_last(key)]}"


def _further_problems(scene: Scene, spec: AnalysisSpec) -> Iterator[str]:
    if spec.kind == "critical_speed_map" or spec.kind == "stiffness_study":
        yield from _support_problems(scene, spec)
    if spec.kind == "run_up":
        yield from _run_up_problems(scene, spec)
    if spec.kind == "static":
        yield from _static_problems(scene, spec)
    if spec.kind == "nodal_diameters":
        yield from _nodal_problems(scene, spec)
    if spec.kind == "nonlinear_response":
        yield from _nonlinear_problems(scene, spec)
    if spec.kind == "asymmetric_response":
        yield from _bow_problems(scene, spec)
    if spec.kind == "impact_test":
        yield from spec.problems(_ends_m(scene))
        if spec.axial_places and scene.effects.axial == "off":
            yield "direction: hammers or sensors along z, and the effect axial is off"
    if spec.kind == "api617":
        yield from _api617_problems(scene, spec)
    if spec.kind == "sensitivity" and not any(
        isinstance(scene.law_of(b), MagneticLawSpec) for b in scene.bearings
    ):
        yield "kind: sensitivity is that of magnetic bearings; no bearing has a law of that kind"
    if spec.kind == "separation_margins" and not (spec.operating or scene.operating):
        yield "operating: missing; give it here or as [[operating]] of the scene"


def _ends_m(scene: Scene) -> dict[str, tuple[float, float]]:
    """Lowest and highest place of beams, and of bodies that sections alone draw."""
    beams = {name: (min(b.stations_m), max(b.stations_m)) for name, b in scene.beams.items()}
    return beams | {
        name: (min(s.start_m for s in body.sections), max(s.end_m for s in body.sections))
        for name, body in scene.bodies.items()
        if body.sections and not body.stage_groups
    }


def _api617_problems(scene: Scene, spec: Api617Spec) -> Iterator[str]:
    """A shaft or speeds that are not told, and places and journals of other bodies."""
    running = running_speeds(scene)
    missing = spec.missing(running)
    if missing is not None:
        yield missing
        return
    shaft = spec.machine(running, lambda name: abs(scene.speed_ratio(name))).shaft
    ratios = scene.speed_ratios()
    own = [name for name, ratio in ratios.items() if ratio == ratios[shaft]]
    for key, value in _named(spec):
        if _last(key) in _PLACES and value.partition(".")[0] not in own:
            yield f"{key}: {value!r} does not turn with {shaft!r}; bodies that do are {own}"
    holding = {
        b.name
        for b in scene.bearings
        if sum(end.partition(".")[0] in own for end in (b.first, b.second) if end) == 1
    }
    for key, value in _named(spec):
        if _last(key) in ("journals", "bearing") and value not in holding:
            yield f"{key}: {value!r} does not hold {shaft!r} against anything else"
    used = [(k, name) for k, source in enumerate(spec.level_2) for name in source.bearings or ()]
    for k, name in used:
        if [other for _, other in used].count(name) > 1:
            yield f"level_2[{k}].bearings: {name!r} stands in more than one group"
    known = [stage.at for stage in spec.stages]
    staged = [(k, at) for k, source in enumerate(spec.level_2) for at in source.stages]
    for k, at in staged:
        if at not in known:
            yield f"level_2[{k}].stages: {unknown('place of stages', at, known)}"
        elif known.count(at) > 1 or [other for _, other in staged].count(at) > 1:
            yield f"level_2[{k}].stages: {at!r} is the place of several stages or groups"


def _nodal_problems(scene: Scene, spec: NodalDiametersSpec) -> Iterator[str]:
    """A body without a mesh, and interfaces that it has not."""
    why = no_solid(scene, spec.body)
    if why:
        yield f"body: {why}"
        return
    why = no_common_sector(scene, spec.body)
    if why:
        yield (
            f"body: {why}; nodal diameters are those of equal sectors: give counts with a common "
            "divisor of 3 or more, or describe each stage as a body of its own, held where it "
            "joins the others"
        )
    sectors = sectors_of(scene, spec.body)
    if sectors is None or sectors <= MOST:  # geometry refuses more with its own reason
        try:
            spec.indices(sectors)
        except AnalysisError as error:
            yield str(error)
    known = list(scene.interface_names()[spec.body])
    for k, name in enumerate(spec.held):
        if name not in known:
            yield f"held[{k}]: {unknown(f'interface of {spec.body!r}', name, known)}"
    whole = sorted({0, 1} & set(spec.nodal_diameters or ()))
    if whole and not spec.held:
        yield (
            f"nodal_diameters: {whole[0]} moves the body as a whole where held names no interface; "
            "allowed are 2 and more, or name interfaces"
        )


def _bow_problems(scene: Scene, spec: AsymmetricResponseSpec) -> Iterator[str]:
    """Bows whose three interfaces are not those of one body, or not three."""
    for k, bow in enumerate(spec.bows):
        body, _, at = bow.at.partition(".")
        known = list(scene.interface_names()[body])
        strange = [(j, name) for j, name in enumerate(bow.between) if name not in known]
        for j, name in strange:
            said = unknown(f"interface of {body!r}", name, known)
            yield f"bows[{k}].between[{j}]: {said}"
        if not strange and len({at, *bow.between}) < 3:
            yield (
                f"bows[{k}].between: {', '.join(bow.between)}, and the bow is at {at}; the three "
                f"must differ, allowed are {', '.join(name for name in known if name != at)}"
            )


def _nonlinear_problems(scene: Scene, spec: NonlinearResponseSpec) -> Iterator[str]:
    """Unbalances that turn at several speeds, and friction where nothing slides."""

    def ratio(place: str) -> float:
        return 0.0 if place == "ground" else scene.speed_ratio_at(place)

    turns = sorted({abs(ratio(u.at)) for u in spec.unbalances})
    if len(turns) > 1:
        yield (
            f"unbalances: they turn at {turns[0]:g} and {turns[-1]:g} times the speed; all must "
            "turn at one, so that the motion repeats; give each its own nonlinear_response"
        )
    for k, joint in enumerate(spec.nonlinear):
        slides = ratio(joint.first) != ratio(joint.second)
        if joint.kind == "clearance" and joint.friction and not slides:
            yield (
                f"nonlinear[{k}].friction: {joint.first!r} and {joint.second!r} turn at one speed; "
                "friction needs ends that slide on each other"
            )


def _support_problems(
    scene: Scene, spec: CriticalSpeedMapSpec | StiffnessStudySpec
) -> Iterator[str]:
    """Bearings whose stiffness a map can not vary."""
    named = {b.name: b for b in scene.bearings}
    for k, name in enumerate(spec.bearings):
        bearing = named[name]
        if {"ux", "uy"} & set(bearing.rigid):
            yield f"bearings[{k}]: {name!r} is rigid in ux or uy; it has no stiffness to vary"
        elif spec.kind == "stiffness_study" and isinstance(scene.law_of(bearing), AbsoluteLaw):
            yield (
                f"bearings[{k}]: {name!r} has the table {bearing.speed_law!r}, which gives its "
                "stiffness; name bearings without a table"
            )


def _run_up_problems(scene: Scene, spec: RunUpSpec) -> Iterator[str]:
    for bearing in scene.bearings:
        law = scene.law_of(bearing)
        if isinstance(law, MagneticLawSpec) and law.bearing().controller.integrates:
            yield (
                f"kind: a run_up takes bearings as they are at the frequency of the spin, and the "
                f"controller of {bearing.speed_law!r} integrates, which has no value at rest; give "
                "it no integral part for a run_up"
            )
    ratios = [abs(scene.speed_ratio_at(u.at)) for u in spec.unbalances]
    fastest = max(ratios, default=0.0) * spec.to_rpm / 60.0
    if spec.record_hz < _RECORDS_PER_TURN * fastest:
        yield (
            f"record_hz: {spec.record_hz:g}, but the fastest unbalance turns at {fastest:.6g} Hz; "
            f"at least {_RECORDS_PER_TURN} records per turn are needed"
        )
    if 2.0 * np.pi * fastest > _LARGEST_ANGLE_RAD * spec.sampling_hz:
        yield (
            f"sampling_hz: {spec.sampling_hz:g}, but the fastest unbalance turns at {fastest:.6g} "
            f"Hz; at least {2.0 * np.pi * fastest / _LARGEST_ANGLE_RAD:.6g} is needed"
        )
    yield from _axial_problems(scene, spec.gravity_m_per_s2)
    if spec.compare_flexible and (spec.drives or spec.gravity_m_per_s2 is not None):
        yield (
            "compare_flexible: models are compared without weight and drives; give "
            "gravity_m_per_s2 and drives in a run_up of their own"
        )
    if spec.drives and scene.effects.torsion == "off":
        yield "drives: they act on rz, and the effect torsion is off"


def _static_problems(scene: Scene, spec: StaticSpec) -> Iterator[str]:
    """Loads along motions that are left out, gears that load nothing, and what falls."""
    for k, force in enumerate(spec.forces):
        effects = {EFFECT_OF[m] for m in force.motions if m in EFFECT_OF}
        for off in sorted(e for e in effects if getattr(scene.effects, e) == "off"):
            yield f"forces[{k}]: it acts on motions of the effect {off}, which is off"
    gears = {gear.name: gear for gear in scene.gears}
    for k, one in enumerate(spec.gears):
        if one.gear not in gears:
            yield f"gears[{k}].gear: {unknown('gear', one.gear, list(gears))}"
        elif gears[one.gear].line_of_action_deg is None:
            yield (
                f"gears[{k}].gear: {one.gear!r} has no line_of_action_deg, so that its teeth load "
                "no bearing; give it, and base_radius_first_m"
            )
    yield from _axial_problems(scene, spec.gravity_m_per_s2)


def _axial_problems(scene: Scene, gravity: tuple[float, float, float] | None) -> Iterator[str]:
    """Weight along an axis along which nothing moves."""
    if gravity is not None and gravity[2] != 0.0 and not _moves_axially(scene):
        yield (
            f"gravity_m_per_s2: {gravity[2]:g} along z, but nothing holds a body along the axis: "
            "nothing acts on uz or the effect axial is off"
        )


def _moves_axially(scene: Scene) -> bool:
    asked = scene.effects.axial
    kept = bool(scene.imported) or any(is_off_axis(b) for b in scene.rigid_bodies.values())
    return kept or asked == "on" or (asked == "auto" and bool(acting_on(scene, "axial")))


def _file_problems(scene: Scene) -> Iterator[str]:
    """Files that two analyses, or one of them twice, would write."""
    owner: dict[str, int] = {}
    bearings = {b.name: bool(b.speed_law) for b in scene.bearings}
    for k, spec in enumerate(scene.analyses):
        for file in spec.possible_files(bearings):
            first = owner.setdefault(file, k)
            if first != k and scene.analyses[first].label != spec.label:
                yield (
                    f"analyses[{k}].name: {spec.label!r} would write {file}, as "
                    f"{scene.analyses[first].label!r} does (analyses[{first}]); choose another name"
                )
                break
        names = spec.possible_files(bearings)
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            yield f"analyses[{k}]: {twice[0]} would be written twice; name speeds and bodies once"


def _last(key: str) -> str:
    return key.rpartition(".")[2].partition("[")[0]


def _named(record: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Keys of a record that name something, with the name."""
    for key in type(record).model_fields:
        if key in ("name", "kind", "direction"):
            continue
        yield from _texts(getattr(record, key), f"{prefix}{key}")


def _texts(value: Any, key: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, tuple):
        for k, item in enumerate(value):
            yield from _texts(item, f"{key}[{k}]")
    elif hasattr(type(value), "model_fields"):
        yield from _named(value, f"{key}.")
