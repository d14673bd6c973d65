"""Results as JSON, the interface that other programs rely on, and the folder of a run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.analyses.base import decrements, reference_ranges_rad_s
from solidwhirl.bodies.reduction import BodyResult
from solidwhirl.core.check_report import checks_document
from solidwhirl.core.outcome import Write, is_picture
from solidwhirl.core.plain_data import plain_data
from solidwhirl.core.stages import silent
from solidwhirl.core.versions import package_versions
from solidwhirl.cost.tables import forecast_document
from solidwhirl.estimates.documents import (
    accuracy_document,
    critical_speed_entry,
    with_estimate,
)
from solidwhirl.estimates.results import Estimates
from solidwhirl.files.run_folder import SCENE, claimed, replacing_files, reserve
from solidwhirl.files.vtk_files import mesh_grid, write_vtu
from solidwhirl.meshing import write_gmsh
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.interface_documents import interfaces_document
from solidwhirl.model.mesh_bodies import source_document
from solidwhirl.output.joint_documents import joint_document
from solidwhirl.output.picture_processes import Begin, in_turn
from solidwhirl.output.plan_documents import plan_document
from solidwhirl.output.report import report_text
from solidwhirl.page.frame.records import Run
from solidwhirl.page.sections import write_report
from solidwhirl.pipeline.asymmetry import asymmetry_document
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.run import ExcitedCriticalSpeed, Results
from solidwhirl.pipeline.verdict import verdict_document
from solidwhirl.rotordyn import CriticalSpeed, Superelement, draw_campbell
from solidwhirl.rotordyn.assembly.bearing_notes import note_lines
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers, branch_prints, shape_print
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.kinds import energy_shares, kinds, shares_document
from solidwhirl.rotordyn.plots.errors import draw_campbell_errors, draw_critical_speed_errors
from solidwhirl.rotordyn.storage.files import write_superelement, write_superelement_again
from solidwhirl.rotordyn.storage.sidecar import superelement_document
from solidwhirl.scene.records import ReferenceSpec
from solidwhirl.scene_reading.paths import leading_steps
from solidwhirl.scene_reading.reader import scene_hash

SCHEMA = "solidwhirl-results-1"
# Headers, attributes and provenance in a file of a superelement.
_AROUND_BYTES = 65_536
# Frequencies at rest that differ by less are of one mode.
_SAME_FREQUENCY = 1e-6


def results_document(results: Results) -> dict[str, Any]:
    """Everything that `results.json` holds; units are in the keys, absent values are null."""
    scene = results.scene
    numbers = _numbers(results)
    document = {
        "schema": SCHEMA,
        "scene": {
            "name": scene.name,
            "title": scene.title,
            "notes": list(scene.notes),
            "sha256": scene_hash(scene),
        },
        "plan": plan_document(results.plan),
        "bodies": {
            name: _solid(results.bodies[name])
            if name in results.bodies
            # a beam or rigid body has no mesh, but its whole tensor of inertia
            else {**_body(element), "inertia_kg_m2": np.asarray(element.inertia_kg_m2).tolist()}
            for name, element in results.elements.items()
        },
        "accuracy": accuracy_document(
            scene,
            results.largest_error,
            () if results.estimates is None else results.estimates.campbell.bodies_without_estimate,
            results.rounds,
            results.checks,
        ),
        "modes_at_rest": {
            "frequency_hz": results.at_rest.frequency_hz.tolist(),
            **_rest_kinds(results),
            "branch": [int(k) or None for k in numbers],
        },
        "campbell": _campbell(results),
        "critical_speeds": [critical_speed_document(results, c) for c in results.critical_speeds],
        "operating": [own._asdict() for own in results.operating],
        "doubts": _doubts(results),
        "invariants": checks_document(results.checks),
        "bearing_notes": list(note_lines(results.bearing_notes)),
        "bearings_beyond_theory": _beyond_theory(results),
        "analyses": {name: {"kind": o.kind, **o.document} for name, o in results.analyses.items()},
        "predicted_cost": forecast_document(results.forecast),
        "timings_s": dict(results.timings_s),
        "dense_problems": {name: dict(found) for name, found in results.dense_problems.items()},
        "body_problems": {name: dict(found) for name, found in results.body_problems.items()},
        "peak_memory_gib": results.peak_memory_gib,
        "packages": package_versions(),
    }
    if results.asymmetry is not None:
        document["asymmetry"] = asymmetry_document(results.asymmetry)
    if results.stages:
        document["stages"] = dict(results.stages)
    if results.estimates is not None:
        _put_estimates(document, results.estimates)
    plain: dict[str, Any] = plain_data(document)
    verdict = verdict_document(plain, results.stability, results.operating, results.alarms)
    plain["verdict"] = plain_data(verdict)
    if scene.references:
        plain["references"] = plain_data(compared(scene.references, plain))
    return plain


def _beyond_theory(results: Results) -> list[dict[str, Any]]:
    return [
        {
            "bearing": note.bearing,
            **note.beyond._asdict(),
            "from_rpm": note.speed_low_rpm,
            "to_rpm": note.speed_high_rpm,
            "message": note.message,
        }
        for note in results.bearing_notes
        if note.beyond is not None
    ]


def _rest_kinds(results: Results) -> dict[str, Any]:
    """Return kinds and shares of the modes at rest, asymmetric bodies at the angle 0."""
    shares = energy_shares(results.system, results.at_rest.shapes)
    return {"kind": kinds(shares).tolist(), "shares": shares_document(shares)}


def _numbers(results: Results) -> list[int]:
    """The branch that each mode at rest is on, from 1; 0: none."""
    if results.asymmetry is None:
        return [int(k) for k in branch_numbers(results.system, results.campbell, results.at_rest)]
    at_rest = results.campbell.frequency_hz[:, results.campbell.speeds_rad_s == 0.0]
    found = []
    for frequency in results.at_rest.frequency_hz:
        own = np.flatnonzero(np.abs(at_rest - frequency) <= _SAME_FREQUENCY * frequency)
        found.append(int(own[0]) + 1 if own.size else 0)
    return found


def _campbell(results: Results) -> dict[str, Any]:
    diagram, rule = results.campbell, results.scene.criteria.rule
    damped = np.isfinite(diagram.eigenvalues) & ~rule.counts(diagram.eigenvalues)
    is_even = results.asymmetry is None
    return {
        "frame": "inertial",
        "speed_rpm": (diagram.speeds_rad_s * RPM_PER_RAD_S).tolist(),
        "frequency_hz": diagram.frequency_hz.tolist(),
        "whirl": [[w or None for w in branch] for branch in diagram.whirl.tolist()],
        "kind": [[k or None for k in branch] for branch in diagram.kind.tolist()],
        "shares": shares_document(diagram.shares),
        "log_decrement": [decrements(branch) for branch in diagram.log_decrement],
        "critically_damped": damped.tolist(),
        "interface_motion": branch_prints(results.system, diagram) if is_even else [],
        "notes": [
            {
                "kind": note.kind,
                "speed_rpm": float(note.speed_rad_s * RPM_PER_RAD_S),
                "branches": [int(b) for b in note.branches],
                "text": note.text,
            }
            for note in diagram.notes
        ],
    }


def _doubts(results: Results) -> list[dict[str, Any]]:
    doubts = (*results.doubts, *results.support_doubts)
    said = [{"kind": "input", **asdict(doubt), "message": doubt.message} for doubt in doubts]
    return [*said, *(asdict(alarm) for alarm in results.alarms)]


def critical_speed_numbers(critical: CriticalSpeed) -> dict[str, Any]:
    """Return a critical speed as plain data, by itself."""
    return {
        "speed_rpm": float(critical.speed_rad_s * RPM_PER_RAD_S),
        "frequency_hz": float(critical.frequency_hz),
        "whirl": str(critical.whirl),
        "kind": critical.kind,
        "shares": shares_document(critical.shares),
        "log_decrement": float(critical.log_decrement) or None,
        "amplification_factor": critical.amplification_factor,
    }


def excitation_document(found: ExcitedCriticalSpeed) -> dict[str, Any]:
    """Return what excites a critical speed as plain data."""
    return {
        "shafts": list(found.shafts),
        "exciters": list(found.excitation.exciters),
        "excited_by": list(found.excited_by),
        "excited": found.excitation.excited,
        "excited_why": found.excitation.why,
    }


def critical_speed_document(results: Results, found: ExcitedCriticalSpeed) -> dict[str, Any]:
    """A critical speed as plain data, whether it counts and what excites it."""
    critical = found.critical
    return {
        **critical_speed_numbers(critical),
        "critically_damped": not critical.counts(results.scene.criteria.rule),
        **excitation_document(found),
        "interface_motion": shape_print(results.system, critical.shape)
        if results.asymmetry is None
        else [],
    }


def _put_estimates(document: dict[str, Any], estimates: Estimates) -> None:
    """Put the error estimates beside the numbers that they belong to."""
    document["modes_at_rest"] |= with_estimate(estimates.at_rest)
    document["campbell"] |= with_estimate(estimates.campbell)
    for index, entry in enumerate(document["critical_speeds"]):
        entry |= critical_speed_entry(estimates, index)
    for name, values in estimates.free_frequencies.items():
        document["bodies"][name]["free_frequency_error_estimate"] = values.tolist()


def write_results(results: Results, out: str | Path, *, pictures: bool = True) -> Path:
    """Write the folder of a run, all of it or nothing, and return it.

    Raises OutputError: the folder can't be written.
    """
    with claimed(out) as folder:
        write_into(results, folder, pictures=pictures)
        return folder


def write_into(
    results: Results,
    folder: Path,
    *,
    pictures: bool = True,
    page: bool = True,
    begin: Begin = in_turn,
    stage_cache: StageCache | None = None,
    scene_path: Path | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Write results into a claimed folder, and return what `results.json` holds.

    Everything is written to a temporary folder in it and moved into place file by file when it is
    complete, `results.json` last but for the manifest. `begin`: begins to draw the pictures; the
    page is made in the meantime. `stage_cache`: of pictures and files of bodies; None: nowhere.
    `scene_path`, `command`: for the page, the scene file and the command line that repeats the
    run. Raises OutputError: the folder can't be written.
    """
    document = results_document(results)
    kept = stage_cache or StageCache(store=None, progress=silent)
    with replacing_files(folder) as scratch:
        _write_all(results, document, scratch, kept)
        with begin(_drawn(results, scratch, kept) if pictures else {}) as drawn:
            if page:
                run = Run(
                    results=results, document=document, scene_path=scene_path, command=command
                )
                write_report(run, scratch / "report.html")
            for path, draw in drawn.items():
                draw(path)
    return document


def _write_all(
    results: Results, document: dict[str, Any], folder: Path, stage_cache: StageCache
) -> None:
    (folder / "bodies").mkdir()
    (folder / "meshes").mkdir()
    for name, result in results.bodies.items():
        mesh = result.shown_mesh
        write_vtu(mesh_grid(mesh), folder / "meshes" / f"{name}.vtu")
        write_gmsh(mesh, folder / "meshes" / f"{name}.msh")
    for name, element in results.elements.items():
        path = folder / "bodies" / f"{name}.h5"
        _write_element(element, path, stage_cache)
        sidecar = json.dumps(superelement_document(element), indent=1, allow_nan=False)
        path.with_suffix(".json").write_text(sidecar + "\n", encoding="utf-8")
    for outcome in results.analyses.values():
        for file, write in outcome.files.items():
            if not is_picture(file):
                write(folder / file)
    (folder / "report.md").write_text(report_text(results, document), encoding="utf-8")
    # the paths of files that it names are those of this machine
    scene = results.scene.model_dump_json(indent=1, exclude_unset=True, exclude_none=True)
    (folder / SCENE).write_text(scene + "\n", encoding="utf-8")
    text = json.dumps(document, indent=1, allow_nan=False)
    (folder / "results.json").write_text(text + "\n", encoding="utf-8")


def _write_element(element: Superelement, path: Path, stage_cache: StageCache) -> None:
    """Write the file of a body, or that of another scene with the same body once more."""
    reserve(path, _size_bytes(element))
    key = stage_cache.key("file of a superelement", element)
    kept = stage_cache.find(key)
    if kept is not None:
        write_superelement_again(kept, element, path)
        return
    write_superelement(element, path)
    stage_cache.keep(key, path.name, path.read_bytes())


def _size_bytes(element: Superelement) -> int:
    """About the size of an element's file: its arrays, and what HDF5 puts around them."""
    forms = sum(form.gram.nbytes + element.mass.nbytes for form in element.error_forms)
    arrays = 9 * element.mass.nbytes + element.recovery_points_m.nbytes
    if element.moments is not None:
        arrays += element.moments.second_kg.nbytes
    if element.surface is not None:
        arrays += element.surface.amplitudes.nbytes + element.surface.cells.nbytes
    return int(1.1 * (forms + arrays + element.recovery_modes.nbytes)) + _AROUND_BYTES


def _drawn(results: Results, folder: Path, stage_cache: StageCache) -> dict[Path, Write]:
    """What draws all pictures of a run, by their files."""
    drawn = {
        folder / file: write
        for outcome in results.analyses.values()
        for file, write in outcome.files.items()
        if is_picture(file)
    }
    for file, draw in diagrams_of(results).items():
        key = stage_cache.key(file, draw.args, draw.keywords)
        drawn[folder / file] = stage_cache.picture(key, draw)
    return drawn


def diagrams_of(results: Results) -> dict[str, partial[None]]:
    """Return what draws the pictures of every run, by the names of their files.

    Diagram, diagram with error bands, critical speeds with error bars.
    """
    title = results.scene.title or results.scene.name
    critical = tuple(c.critical for c in results.critical_speeds)
    excited = tuple(c.critical for c in results.critical_speeds if c.excitation.excited)
    ratios = results.scene.speed_ratios()
    drawn = {
        "campbell.png": partial(
            draw_campbell,
            results.campbell,
            excited,
            title=title,
            excitation_ratios=ratios,
            operating_rad_s=reference_ranges_rad_s(results.operating),
        )
    }
    if results.estimates is not None:
        drawn["campbell_errors.png"] = partial(
            draw_campbell_errors,
            results.estimates.campbell,
            title=title,
            excitation_ratios=ratios,
        )
        if critical:
            errors = results.estimates.critical_speeds
            drawn["critical_speeds.png"] = partial(
                draw_critical_speed_errors, critical, errors, title=title
            )
    return drawn


def _body(element: Superelement) -> dict[str, Any]:
    """What all bodies have."""
    inertia = np.asarray(element.inertia_kg_m2)
    return {
        "level": element.level,
        "mass_kg": element.mass_kg,
        "center_of_gravity_m": np.asarray(element.center_of_gravity_m).tolist(),
        "polar_inertia_kg_m2": inertia[2, 2],
        "diametral_inertia_kg_m2": inertia[0, 0] if inertia[0, 0] == inertia[1, 1] else None,
        "full_dofs": element.full_dofs,
        "reduced_dofs": len(element.coordinates),
        "free_frequencies_hz": element.free_frequencies_hz.tolist(),
        "fixed_interface_frequencies_hz": element.fixed_interface_frequencies_hz.tolist(),
        "interfaces": interfaces_document(element),
        **({"import": element.provenance["import"]} if "import" in element.provenance else {}),
    }


def _solid(result: BodyResult) -> dict[str, Any]:
    return {
        **_body(result.element),
        **_mass_properties(result),
        "interfaces": interfaces_document(result.element, result.body, result.mesh),
        "element_order": result.discretisation.degree,
        "modes_per_family": result.discretisation.modes,
        "mesh": {
            "points": len(result.shown_mesh.points),
            "cells": len(result.shown_mesh.cells),
            "minimum_scaled_jacobian": result.mesh.quality.minimum_scaled_jacobian,
            "straightened_elements": result.mesh.quality.straightened_elements,
        },
        "assembled": {k: list(v) for k, v in result.work.assembled.items()},
        "solved": {k: list(v) for k, v in result.work.solved.items()},
        "solver": result.work.solver,
        "orthogonality_error": result.work.orthogonality_error,
        "hoop_strain_at_top_speed": result.work.hoop_strain,
        **({"joints": [*map(joint_document, result.work.joints)]} if result.work.joints else {}),
    }


def _mass_properties(result: BodyResult) -> dict[str, Any]:
    """In closed form of a profile; of a mesh its whole tensor, and where it comes from."""
    p = result.properties
    if isinstance(result.body, MeshedBody) or p is None:
        inertia = np.asarray(result.element.inertia_kg_m2)
        out: dict[str, Any] = {"inertia_kg_m2": inertia.tolist()}
        if isinstance(result.body, MeshedBody):
            out["source"] = source_document(result.body)
        return out
    return {
        "mass_kg": p.mass_kg,
        "center_of_gravity_m": np.asarray(p.center_of_gravity_m).tolist(),
        "polar_inertia_kg_m2": p.polar_inertia_kg_m2,
        "diametral_inertia_kg_m2": p.diametral_inertia_kg_m2,
    }


def value_at(document: Mapping[str, Any], path: str) -> float | None:
    """Return the number at a place such as "critical_speeds[0].frequency_hz"; None for none."""
    found: Any = document
    for step in leading_steps(path)[0]:
        try:
            found = found[int(step[1:-1]) if step.startswith("[") else step]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    number = isinstance(found, int | float) and not isinstance(found, bool)
    return float(found) if number else None


def compared(
    references: Sequence[ReferenceSpec], document: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Compare the contents of `results.json` with the references of a scene.

    Returns of each what the scene says, `result`, `relative_difference` from the reference (None
    where either is missing or the reference is 0), and `met` (None without tolerance; a result that
    is missing meets none).
    """
    return [_compared(reference, value_at(document, reference.quantity))
            for reference in references]  # fmt: skip


def _compared(reference: ReferenceSpec, found: float | None) -> dict[str, Any]:
    difference = None
    if found is not None and reference.value != 0.0:
        difference = (found - reference.value) / abs(reference.value)
    met = None
    if reference.tolerance is not None:
        met = difference is not None and abs(difference) <= reference.tolerance
    return {
        "quantity": reference.quantity,
        "title": reference.title,
        "source": reference.source,
        "value": reference.value,
        "result": found,
        "relative_difference": difference,
        "tolerance": reference.tolerance,
        "met": met,
    }
