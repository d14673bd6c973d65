"""Section: all that is needed to repeat the run."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from datetime import UTC, datetime

from solidwhirl.page.frame.records import Block, Listing, Run, Section, Table, Text


def section(run: Run) -> Section:
    """Provenance of a run."""
    return Section(name="provenance", title="To repeat this run", blocks=tuple(_blocks(run)))


def _blocks(run: Run) -> Iterator[Block]:
    if run.command:
        yield Listing(text=run.command)
    document = run.document
    rows = [
        ("scene", document["scene"]["name"]),
        ("SHA-256 of what the scene says", f"`{document['scene']['sha256']}`"),
        ("file", "made in Python" if run.scene_path is None else f"`{run.scene_path}`"),
        ("schema of results.json", f"`{document['schema']}`"),
        ("page written", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("machine", f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}"),
    ]
    rows += [(name, version) for name, version in document["packages"].items()]
    yield Table(head=("", ""), rows=rows)
    yield Text(
        text="`solidwhirl check DIR` compares the files of the folder with the SHA-256 of each "
        "that the run wrote down in `SHA256SUMS`."
    )
    yield from _inputs(run)
    yield _scene_text(run)


def _inputs(run: Run) -> Iterator[Block]:
    """Files that the scene names."""
    scene = run.results.scene
    rows = [(name, f"`{b.file}`", f"`{b.sha256}`") for name, b in scene.mesh_bodies.items()]
    for name, body in run.document["bodies"].items():
        for file, digest in _digests(body.get("import")):
            rows.append((name, f"`{file}`", f"`{digest}`"))
    if rows:
        yield Table(title="Files that the scene names", head=("body", "file", "SHA-256"), rows=rows)


def _digests(found: object) -> Iterator[tuple[str, str]]:
    """Files and digests in the provenance of an imported body."""
    if isinstance(found, dict):
        if isinstance(found.get("sha256"), str):
            yield str(found.get("file", found.get("path", ""))), found["sha256"]
        for value in found.values():
            yield from _digests(value)
    elif isinstance(found, list):
        for value in found:
            yield from _digests(value)


def _scene_text(run: Run) -> Listing:
    """The scene file, or what was made in Python as JSON."""
    path = run.scene_path
    if path is not None and path.is_file():
        return Listing(text=path.read_text(encoding="utf-8"), folded=f"Scene file: {path.name}")
    text = run.results.scene.model_dump_json(indent=1, exclude_defaults=True, by_alias=True)
    return Listing(text=text, folded="The scene as JSON, keys at their defaults left out")
