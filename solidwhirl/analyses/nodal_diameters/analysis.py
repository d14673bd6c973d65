"""Modes of blades and disks by nodal diameter, and the engine orders that meet them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.nodal_diameters import results, told
from solidwhirl.analyses.nodal_diameters import shapes as own_shapes
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import MOST, Count, Finite, Name, Record
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels, tabled
from solidwhirl.rotordyn import nodal_diameters as nd
from solidwhirl.rotordyn.plots.nodal_diameters import blade_campbell_chart, interference_chart

_OVER = ("direction", "nodal_diameter", "speed_rpm", "mode")


class MistuningSpec(Record):
    """Blades of unequal frequency: given, or at random."""

    engine_order: Count
    mode: Annotated[Count, Field(le=20)] = 1
    damping_ratio: Annotated[float, Field(gt=0, lt=0.5, strict=True)] = 1e-3
    standard_deviation: Annotated[float, Field(gt=0, le=0.1, strict=True)] | None = None
    samples: Annotated[int, Field(ge=20, le=100_000, strict=True)] = 1000
    seed: Annotated[int, Field(ge=0, strict=True)] = 1
    blade_deviations: Annotated[tuple[Finite, ...], Field(min_length=3, max_length=MOST)] | None = (
        None
    )

    @model_validator(mode="after")
    def _one_kind(self) -> MistuningSpec:
        given = (self.standard_deviation is not None, self.blade_deviations is not None)
        if sum(given) != 1:
            found = "both" if all(given) else "neither"
            raise ValueError(
                f"standard_deviation and blade_deviations: {found} found; one of them is needed"
            )
        if self.blade_deviations is not None and max(map(abs, self.blade_deviations)) > 0.2:
            raise ValueError(
                "blade_deviations: parts of the frequency are meant, at most 0.2; found "
                f"{max(self.blade_deviations, key=abs):g}"
            )
        return self

    @property
    def asked(self) -> results.MistuningAsked:
        """What the analysis is asked."""
        spread = self.standard_deviation
        return results.MistuningAsked(
            mode=self.mode,
            engine_order=self.engine_order,
            damping_ratio=self.damping_ratio,
            blade_deviations=self.blade_deviations,
            random=None if spread is None else (spread, self.samples, self.seed),
        )


class NodalDiametersSpec(base.Sweep):
    """Modes of blades and disks by nodal diameter, and the engine orders that meet them."""

    section = PageSection(
        "nodal-diameters",
        "Modes of blades and disks",
        "Vibration of single bodies with any number of nodal diameters, in the frame that turns "
        "with them, and what excites it.",
        65,
    )
    turning: ClassVar = {"body": "no engine order meets its modes"}
    sees_operating = True
    suffixes = (".png", "_interference.png", "_amplification.png", ".npz")
    axes: ClassVar = {
        "body_speed_rpm": ("speed_rpm",),
        "standing": ("nodal_diameter",),
    }

    kind: Literal["nodal_diameters"]
    body: Name
    count: base.Points = 41
    held: Annotated[tuple[Name, ...], Field(max_length=MOST)] = ()
    modes: Annotated[Count, Field(le=20)] = 3
    nodal_diameters: (
        Annotated[
            tuple[Annotated[int, Field(ge=0, le=1000, strict=True)], ...],
            Field(min_length=1, max_length=MOST),
        ]
        | None
    ) = None
    engine_orders: Annotated[tuple[Count, ...], Field(max_length=MOST)] = ()
    margin_percent: Annotated[float, Field(gt=0, lt=100, strict=True)] = 5.0
    probe: Literal["off", "on"] = "off"
    mistuning: MistuningSpec | None = None

    @model_validator(mode="after")
    def _followed(self) -> NodalDiametersSpec:
        if self.mistuning is not None and self.mistuning.mode > self.modes:
            raise ValueError(
                f"mistuning.mode = {self.mistuning.mode} is not among modes = {self.modes}"
            )
        return self

    def indices(self, sectors: int | None) -> tuple[tuple[int, ...], list[str]]:
        """Nodal diameters of a body of so many sectors, and notes on what is left out.

        Raises AnalysisError: a nodal diameter, or blades, that such a body has not.
        """
        if self.mistuning is not None:
            results.refuse_mistuning(self.mistuning.asked, sectors, self.body)
        every = self.mistuning is not None
        return results.chosen_indices(self.nodal_diameters, sectors, self.held, every=every)

    def run(self, engine: base.Engine) -> Outcome:
        """Modes of all nodal diameters over the speed, their crossings, and mistuned blades."""
        source: results.CyclicSource = engine.cyclic(self.body)
        ratio = abs(engine.speed_ratios[self.body])
        indices, notes = self.indices(source.sectors)
        notes += results.disks_left_out(source, self.held, indices)
        orders = results.chosen_orders(self.engine_orders, source.sectors, indices)
        asked = results.Asked(
            body=self.body,
            speeds_rad_s=self.speeds_rad_s,
            held=self.held,
            modes=self.modes,
            margin=0.01 * self.margin_percent,
            engine_orders=orders,
        )
        body, shapes = source.reduce(self.held, indices, self.modes)
        modes = nd.nodal_diameter_modes(body, ratio * self.speeds_rad_s, self.modes)
        crossings = nd.engine_order_crossings(modes, orders)
        operating = results.operating_of(engine, self.body)
        document = results.modes_document(modes, asked, ratio) | {
            "mode": list(range(1, self.modes + 1)),
            "engine_orders": list(orders),
            "margin_percent": self.margin_percent,
            "crossings": results.crossings_document(crossings, asked, ratio, operating),
            "veerings": results.veerings_document(nd.veerings(modes), ratio),
            "interference": results.interference_document(body, asked, ratio, operating),
            "mistuning": None
            if self.mistuning is None
            else results.mistuning_document(
                body, self.mistuning.asked, crossings, ratio, float(self.speeds_rad_s[-1])
            ),
            "fixed_frame_hz": results.fixed_frame_document(modes, asked)
            if self.probe == "on"
            else None,
            "root_stress": own_shapes.root_document(shapes, modes, self.modes),
            "notes": notes,
        }
        arrays = own_shapes.file_arrays(body, shapes, modes)
        return Outcome(
            kind=self.kind,
            document=document,
            files={f"{self.label}.npz": partial(_write_arrays, arrays)},
            headline=results.headline_of(document),
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The Campbell diagram of the blades, the interference diagram, the amplification."""
        document = found.document
        view = partial(told.campbell_view, document, found.engine)
        made: dict[str, base.Charts] = {
            "": lambda: [blade_campbell_chart(view())],
            "_interference": lambda: [interference_chart(told.interference_view(document))],
        }
        if document["mistuning"] and document["mistuning"]["amplification"]:
            made["_amplification"] = lambda: [told.amplification_view(document)]
        return made

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Crossings, diagrams, shapes in space, and mistuned blades."""
        return told.blocks_of(found.document, found.engine, found.record)

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Over nodal diameter, speed and mode; one row for each crossing."""
        rows = document["crossings"]
        labels = tabled(document, cls.axes)
        over: dict[str, Any] = {
            key: (_OVER, numbers([found[d] for d in own_shapes.DIRECTIONS]))
            for key, found in (
                ("frequency_hz", document["frequency_hz"]),
                ("frequency_error_estimate", document["frequency_error_estimate"]),
                *((f"root_{key}", f) for key, f in (document["root_stress"] or {}).items()),
            )
        }
        seen = document["fixed_frame_hz"]
        if seen:
            by_direction = numbers([seen[d] for d in own_shapes.DIRECTIONS])
            over["fixed_frame_hz"] = ((_OVER[0], "k", *_OVER[1:]), by_direction)
        names = ("engine_order", "nodal_diameter", "mode", "speed_rpm", "frequency_hz", "margin")
        of_crossings = {
            f"crossing_{key}": ("crossing", np.array([row[key] for row in rows], dtype=float))
            for key in names
        }
        words = np.array([row["direction"] for row in rows], dtype=str)
        of_crossings["crossing_direction"] = ("crossing", words)
        coordinates = {**labels.coordinates, "direction": ("direction", [*own_shapes.DIRECTIONS])}
        if seen:
            coordinates["k"] = ("k", seen["k"])
        for key in ("nodal_diameter", "mode"):
            coordinates[key] = (key, document[key])
        variables = {**labels.variables, **over, **of_crossings}
        return labels._replace(variables=variables, coordinates=coordinates)

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the lowest frequency, the smallest margin, and the amplification."""
        lowest = (f for h in document["frequency_hz"]["backward"] for f in h[0])
        yield "lowest_frequency_hz", base.smallest_of(lowest)
        margins = [c["margin"] for c in document["crossings"]]
        yield "smallest_margin", base.smallest_of(abs(m) for m in margins if m is not None)
        yield "crossings_too_near", float(sum(c["too_near"] for c in document["crossings"]))
        mistuning = document["mistuning"]
        if mistuning:
            yield "amplification_factor", mistuning["pattern"]["amplification_factor"]
            for name, value in (mistuning["amplification"] or {}).get("quantiles", {}).items():
                yield f"amplification_{name.replace(' %', '_percent')}", value


def _write_arrays(arrays: Mapping[str, Any], path: Path) -> None:
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
