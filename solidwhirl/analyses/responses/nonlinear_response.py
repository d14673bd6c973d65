"""Steady response to unbalance with squeeze films, clearances and cubic springs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import UnbalanceSpec, end_of, unbalance_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, numbers
from solidwhirl.core.fields import MOST, EndText, Finite, NotNegative, Place, Positive, Record
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.nonlinear.forced_system import NonlinearJoint
from solidwhirl.rotordyn.nonlinear.forces import (
    Clearance,
    CubicSpring,
    NonlinearForce,
    SqueezeFilm,
)
from solidwhirl.rotordyn.nonlinear.response import (
    NonlinearBranch,
    NonlinearResponse,
    nonlinear_response,
)
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.nonlinear import BranchCurves, JumpMark, branch_chart

# Balances that the branches of a range take, and motions along them: where orbits are circles, and
# where not. [measured: 1400 to 2900, with a gap 6800; 400 to 540, 190 to 430]
_BALANCES, _CIRCLES, _ORBITS = 2000.0, 450.0, 250.0
# Harmonics of other orbits; where a gap opens and closes.
_HARMONICS, _WITH_GAP = 3, 7
# Multipliers of a motion, beside what a result takes.
_MULTIPLIERS = 4.0
_GROUND = "ground"
_KEYS = ("major_m", "largest_radius_m")
# Why a branch is not known beyond an open end.
_REASONS = {
    "lost": "no motion is found beyond it, although there must be one",
    "closed": "a squeeze film is thinner than a hundredth of its clearance beyond it",
    "grows": "the motion grows beyond all bounds there; is there damping?",
    "long": "it had too many motions to be followed further; ask for a smaller range of speeds",
}
_Turns = Annotated[int, Field(ge=1, le=10, strict=True)]


class NonlinearJointSpec(Record):
    """What all nonlinear joints share: the places between which they act."""

    first: Place
    second: EndText = _GROUND

    @model_validator(mode="after")
    def _apart(self) -> NonlinearJointSpec:
        if self.first == self.second:
            raise ValueError(f"second: {self.second!r} is the first end too; the ends must differ")
        return self

    def force(self, spin_sense: int) -> NonlinearForce:
        """Return the force; `spin_sense`: 1, −1 or 0 as the first end turns in the second."""
        raise NotImplementedError


class CubicSpringSpec(NonlinearJointSpec):
    """A spring of third order."""

    kind: Literal["cubic"]
    radial_n_per_m3: Finite = 0.0
    along_n_per_m3: tuple[Finite, Finite] = (0.0, 0.0)

    def force(self, spin_sense: int) -> NonlinearForce:
        """Return the force."""
        return CubicSpring(radial_n_per_m3=self.radial_n_per_m3, along_n_per_m3=self.along_n_per_m3)


class ClearanceJointSpec(NonlinearJointSpec):
    """A gap that closes against a stiffness."""

    kind: Literal["clearance"]
    gap_m: NotNegative
    stiffness_n_per_m: Positive
    friction: NotNegative = 0.0
    center_m: tuple[Finite, Finite] = (0.0, 0.0)

    def force(self, spin_sense: int) -> NonlinearForce:
        """Return the force."""
        return Clearance(
            gap_m=self.gap_m,
            stiffness_n_per_m=self.stiffness_n_per_m,
            friction=self.friction,
            spin_sense=spin_sense,
            center_m=self.center_m,
        )


class SqueezeFilmSpec(NonlinearJointSpec):
    """A squeeze film damper with open ends."""

    kind: Literal["squeeze_film"]
    radius_m: Positive
    length_m: Positive
    clearance_m: Positive
    viscosity_pa_s: Positive
    centring_n_per_m: NotNegative = 0.0

    def force(self, spin_sense: int) -> NonlinearForce:
        """Return the force."""
        return SqueezeFilm(
            radius_m=self.radius_m,
            length_m=self.length_m,
            clearance_m=self.clearance_m,
            viscosity_pa_s=self.viscosity_pa_s,
            centring_n_per_m=self.centring_n_per_m,
        )


JointSpec = Annotated[
    CubicSpringSpec | ClearanceJointSpec | SqueezeFilmSpec, Field(discriminator="kind")
]


class NonlinearResponseSpec(base.Analysis):
    """Steady response to unbalance with nonlinear joints, along its branches over the speed."""

    section = PageSection(
        "nonlinear",
        "Nonlinear response",
        "Steady motion with joints whose force is no linear function of the motion.",
        85,
    )
    turning: ClassVar = {"at": base.UNBALANCE_TURNS}

    kind: Literal["nonlinear_response"]
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(min_length=1, max_length=MOST)]
    nonlinear: Annotated[tuple[JointSpec, ...], Field(min_length=1, max_length=20)]
    from_rpm: Positive
    to_rpm: Positive
    observe: base.Places
    gravity_m_per_s2: tuple[Finite, Finite] | None = None
    tolerance: Annotated[float, Field(gt=0, lt=1, strict=True)] = 1e-3
    period_multiples: Annotated[tuple[_Turns, ...], Field(max_length=10)] = ()

    @model_validator(mode="after")
    def _rising(self) -> NonlinearResponseSpec:
        base.refuse_falling(self.from_rpm, self.to_rpm)
        return self

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        branches = 1.0 + sum(self.period_multiples)
        harmonics, motions = 1, _CIRCLES
        if size.uneven or self.gravity_m_per_s2 is not None:
            gap = any(joint.kind == "clearance" for joint in self.nonlinear)
            harmonics, motions = _WITH_GAP if gap else _HARMONICS, _ORBITS
        balances = branches * _BALANCES * (harmonics + 1)
        results = _MULTIPLIERS * motions
        return Work(balances=balances, results=results, values=5.0 * balances)

    def run(self, engine: base.Engine) -> Outcome:
        """Branches of steady motion over the speed, with their stability and jumps."""
        joints = [_joint(spec, engine.speed_ratios) for spec in self.nonlinear]
        observed = list(dict.fromkeys(self.observe))
        found = nonlinear_response(
            engine.system,
            joints,
            [unbalance_of(u) for u in self.unbalances],
            (self.from_rpm * RAD_S_PER_RPM, self.to_rpm * RAD_S_PER_RPM),
            [end_of(place) for place in observed],
            gravity_m_per_s2=(*(self.gravity_m_per_s2 or (0.0, 0.0)), 0.0),
            tolerance=self.tolerance,
            sought_turns=self.period_multiples,
        )
        document: dict[str, Any] = {
            "unbalances": [u.model_dump() for u in self.unbalances],
            "nonlinear": [joint.model_dump() for joint in self.nonlinear],
            "branches": [_branch_document(b, observed) for b in found.branches],
            "jumps": [
                {
                    "speed_rpm": jump.speed_rad_s * RPM_PER_RAD_S,
                    "direction": jump.direction,
                    "before_m": dict(zip(observed, jump.before_m.tolist(), strict=True)),
                    "after_m": dict(zip(observed, jump.after_m.tolist(), strict=True)),
                }
                for jump in found.jumps
            ],
            "stability_changes": [
                {"speed_rpm": change.speed_rad_s * RPM_PER_RAD_S, "kind": change.kind}
                for change in found.changes
            ],
            "harmonics": found.harmonics,
            "truncation_error_estimate": found.truncation,
            "notes": _notes(self, found, engine.system),
        }
        isolated = _isolated_text(found)
        said = ", ".join(f"{j['direction']} at {j['speed_rpm']:.0f} rpm" for j in document["jumps"])
        return Outcome(
            kind=self.kind,
            document=document,
            headline=f"jumps: {said or 'none'}; {isolated}{found.harmonics} harmonics",
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The largest radius over the speed."""
        return {"": lambda: [_chart(found.document)]}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The branches, jumps, changes of stability, and how well harmonics describe them."""
        document = found.document
        return [
            *(Text(text=note, kind="warning") for note in document["notes"]),
            _chart(document),
            _jump_table(document),
            Table(
                title="Accuracy",
                head=["harmonics", "estimated change with twice as many"],
                rows=[[document["harmonics"], document["truncation_error_estimate"]]],
            ),
        ]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Motions of all branches one behind the other."""
        branches = document["branches"]
        places = list(branches[0]["places"])
        joined = {
            key: [v for b in branches for v in b[key]]
            for key in ("speed_rpm", "stable", "turning", "largest_multiplier")
        }
        radii = {
            key: [[v for b in branches for v in b["places"][place][key]] for place in places]
            for key in _KEYS
        }
        return Labels(
            {
                **{key: ("point", values) for key, values in joined.items()},
                **{key: (("place", "point"), values) for key, values in radii.items()},
            },
            {
                "place": ("place", places),
                "branch": ("point", [k for k, b in enumerate(branches) for _ in b["speed_rpm"]]),
                "period_multiple": (
                    "point",
                    [b["period_multiple"] for b in branches for _ in b["speed_rpm"]],
                ),
            },
            {key: document[key] for key in ("harmonics", "truncation_error_estimate")},
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest stable amplitudes, and the first speeds of jumps."""
        for place in document["branches"][0]["places"]:
            stable = (
                r
                for b in document["branches"]
                for r, s in zip(b["places"][place]["largest_radius_m"], b["stable"], strict=True)
                if s
            )
            yield f"{place}.largest_amplitude_m", base.largest_of(stable)
        for way in ("up", "down"):
            speeds = [j["speed_rpm"] for j in document["jumps"] if j["direction"] == way]
            yield f"jump_{way}_rpm", base.smallest_of(speeds)


def _joint(spec: JointSpec, ratios: Mapping[str, float]) -> NonlinearJoint:
    second = None if spec.second == _GROUND else end_of(spec.second)
    first = end_of(spec.first)
    relative = ratios[first.body] - (0.0 if second is None else ratios[second.body])
    return NonlinearJoint(first=first, second=second, force=spec.force(int(np.sign(relative))))


def _branch_document(branch: NonlinearBranch, places: Sequence[str]) -> dict[str, Any]:
    major = branch.major_m()
    return {
        "speed_rpm": (branch.speeds_rad_s * RPM_PER_RAD_S).tolist(),
        "stable": branch.is_stable.tolist(),
        "turning": branch.is_turning.tolist(),
        "largest_multiplier": np.abs(branch.multiplier).tolist(),
        "followed_to_its_end": not branch.open_ends,
        "open_ends": [
            {"speed_rpm": float(branch.speeds_rad_s[at]) * RPM_PER_RAD_S, "reason": _REASONS[why]}
            for at, why in branch.open_ends
        ],
        "period_multiple": branch.period_multiple,
        "closed": branch.is_closed,
        "places": {
            place: {
                "major_m": major[:, k].tolist(),
                "largest_radius_m": branch.largest_radius_m[:, k].tolist(),
            }
            for k, place in enumerate(places)
        },
    }


def _isolated_text(found: NonlinearResponse) -> str:
    """Return which branches meet no end of the speeds, or repeat after several turns."""
    said = [
        f"from {b.speeds_rad_s.min() * RPM_PER_RAD_S:.0f} to "
        f"{b.speeds_rad_s.max() * RPM_PER_RAD_S:.0f} rpm "
        + (f"repeating after {b.period_multiple} turns" if b.period_multiple > 1 else "isolated")
        for b in found.branches
        if b.is_closed or b.period_multiple > 1
    ]
    return f"also {', '.join(said)}; " if said else ""


def _notes(
    spec: NonlinearResponseSpec, found: NonlinearResponse, system: AssembledSystem
) -> list[str]:
    notes = []
    if found.truncation > spec.tolerance:
        notes.append(
            f"More than {found.harmonics} harmonics would still change the result by "
            f"{found.truncation:.2g}, above tolerance = {spec.tolerance:g}."
        )
    notes += [
        f"Branch {number} has an open end at {branch.speeds_rad_s[at] * RPM_PER_RAD_S:.6g} rpm "
        f"({branch.largest_radius_m[at, 0]:.4g} m at {spec.observe[0]}): {_REASONS[why]}."
        for number, branch in enumerate(found.branches, start=1)
        for at, why in branch.open_ends
    ]
    notes += [
        f"Where the loads are raised from none at {speed * RPM_PER_RAD_S:.6g} rpm, no motion is "
        f"found beyond {share:.3g} times the loads: a branch may be missing."
        for speed, share in found.stopped
    ]
    ratio = abs(system.system.rotors[end_of(spec.unbalances[0].at).body].speed_ratio)
    highest = found.harmonics * ratio * spec.to_rpm / 60.0
    for name, rotor in system.system.rotors.items():
        kept = float(rotor.element.fixed_interface_frequencies_hz.max(initial=0.0))
        if 0.0 < kept < highest and found.harmonics > 1:
            notes.append(
                f"Harmonic {found.harmonics} reaches {highest:.4g} Hz, and {name} has modes up to "
                f"{kept:.4g} Hz: its motion at the highest harmonics is that of a stiffer body."
            )
    return notes


def _chart(document: Mapping[str, Any]) -> Chart:
    branches = [
        BranchCurves(
            speed_rpm=numbers(b["speed_rpm"]),
            is_stable=np.array(b["stable"]),
            is_turning=np.array(b["turning"]),
            radius_m={p: numbers(m["largest_radius_m"]) for p, m in b["places"].items()},
            turns=b["period_multiple"],
        )
        for b in document["branches"]
    ]
    jumps = [
        JumpMark(
            j["speed_rpm"],
            *({p: np.nan if v is None else v for p, v in j[key].items()}
              for key in ("before_m", "after_m")),
        )
        for j in document["jumps"]
    ]  # fmt: skip
    return branch_chart(branches, jumps)


def _jump_table(document: Mapping[str, Any]) -> Table:
    rows: list[list[Any]] = [
        [f"{j['speed_rpm']:.1f}", f"jump as the speed goes {j['direction']}", place,
         j["before_m"][place], j["after_m"][place]]
        for j in document["jumps"]
        for place in j["before_m"]
    ]  # fmt: skip
    rows += [
        [f"{c['speed_rpm']:.1f}", f"changes stability: {c['kind']}", "", None, None]
        for c in document["stability_changes"]
    ]
    return Table(
        title="Jumps and changes of stability",
        head=["reference shaft [rpm]", "what", "place", "radius before [m]", "after [m]"],
        rows=rows or [["–", "none", "", None, None]],
    )
