"""The verdict of a run in words, the same in the terminal, on the page and in the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from solidwhirl.rotordyn.modes.kinds import motion_words, shares_in
from solidwhirl.rotordyn.plots.chart import whirl_name

# Unstable intervals, critical speeds and operating speeds that are named; of others their number.
_MOST = 3
# The choice of the coupling is named where it is worth so many times the estimated error.
_MUCH, _ROUNDING = 2.0, 1e-6


class Answer(NamedTuple):
    """An answer that a design review asks for.

    `good` is None where there is nothing to judge.
    """

    about: str
    text: str
    good: bool | None = None

    @property
    def marked(self) -> str:
        """The text with its judgement, by its words before the first comma or bracket, bold."""
        if self.good is None:
            return self.text
        cut = min((k for k in map(self.text.find, (",", " (", ":")) if k > 0), default=None)
        head, tail = self.text[:cut], self.text[cut:] if cut else ""
        return f"{'✓' if self.good else '✗'} **{head}**{tail}"


def answers(document: Mapping[str, Any]) -> tuple[Answer, ...]:
    """Return what a run comes to: the `verdict` of the contents of `results.json` in words.

    Stability, damping, critical speeds, margins, vibration, accuracy; what was not asked is left
    out.
    """
    verdict = document["verdict"]
    return (
        *stability_answers(verdict),
        _critical_speeds(verdict),
        *_gravity_critical_speeds(verdict.get("gravity_critical_speeds")),
        *_margins(verdict["margins"]),
        *_vibration(verdict["vibration"]),
        _accuracy(verdict["accuracy"]),
        *_coupling(verdict),
    )


def stability_answers(verdict: Mapping[str, Any]) -> tuple[Answer, ...]:
    """Return what a verdict says of stability, and of damping at the operating speeds."""
    return _stability(verdict), *_damping(verdict["at_operating"])


def _stability(verdict: Mapping[str, Any]) -> Answer:
    low, high = verdict["speed_range_rpm"]
    found = verdict["unstable_intervals"]
    if not found:
        return Answer("Stability", f"stable, {low:.0f} to {rpm_text(high)}", True)
    listed = [_interval(i) for i in found[:_MOST]]
    more = f", and {len(found) - _MOST} more intervals" if len(found) > _MOST else ""
    return Answer("Stability", f"unstable {'; '.join(listed)}{more}", False)


def _interval(found: Mapping[str, Any]) -> str:
    low, high = found["from_rpm"], found["to_rpm"]
    speeds = f"{low:.0f} to {rpm_text(high)}" if found["closes"] else f"from {rpm_text(low)}"
    if found["kind"] == "divergence":
        return f"{speeds} (divergence)"
    whirl = f"{whirl_name(found['whirl'])}, " if found["whirl"] else ""
    return f"{speeds} ({found['kind']}, {whirl}{found['frequency_hz']:.4g} Hz)"


def _damping(found: Sequence[Mapping[str, Any]]) -> Iterator[Answer]:
    """Yield the damping of the first forward mode at the operating speeds."""
    several = len({entry["shaft"] for entry in found}) > 1
    listed, worst = [], []
    for entry in found:
        mode = entry["first_forward"]
        where = rpm_text(entry["shaft_speed_rpm"]) + (f" of {entry['shaft']}" * several)
        if mode["frequency_hz"] is None:
            continue
        decrement = mode["log_decrement"]
        worst.append(decrement)
        said = "no damping" if decrement is None else f"{decrement:.3g}"
        listed.append(f"{said} at {where} ({mode['frequency_hz']:.4g} Hz)")
    if listed:
        good = False if any(d is not None and d < 0.0 for d in worst) else None
        yield Answer("Log. decrement, first forward mode", "; ".join(listed), good)
    elif found:
        text = "none at the operating speeds is oscillatory and lightly damped"
        yield Answer("Log. decrement, first forward mode", text)


def critical_speed_words(entry: Mapping[str, Any]) -> str:
    """Return a critical speed of the verdict in words: rpm, whirl, amplification factor, margin."""
    factor = entry["amplification_factor"]
    said = [motion_words(entry["whirl"], shares_in(entry["shares"]))]
    said += [f"AF {factor:.3g}"] if factor is not None else ["undamped"]
    if entry["margin"] is not None:
        said.append(margin_words(entry["margin"], entry["margin_of"]))
    return f"{rpm_text(entry['speed_rpm'])} ({', '.join(said)})"


def margin_words(margin: float, shaft: str) -> str:
    """Return a margin in words, such as "4 % above lp"; 0 is "inside the speeds of lp"."""
    if margin == 0.0:
        return f"inside the speeds of {shaft}"
    percent = 100.0 * abs(margin)
    size = "< 0.1" if percent < 0.05 else f"{percent:.{1 if percent < 0.95 else 0}f}"
    return f"{size} % {'above' if margin > 0.0 else 'below'} {shaft}"


def _critical_speeds(verdict: Mapping[str, Any]) -> Answer:
    """Name those that an unbalance excites, the nearest to operating speeds first."""
    every = verdict["critical_speeds"]
    found = [c for c in every if c["excited"]]
    if not found:
        end = rpm_text(verdict["speed_range_rpm"][1])
        return Answer("Critical speeds", f"none that unbalance excites up to {end}")
    near = sorted(found, key=lambda c: abs(c["margin"]) if c["margin"] is not None else 1e9)
    shown = sorted(near[:_MOST], key=lambda c: c["speed_rpm"])
    text = "; ".join(critical_speed_words(c) for c in shown)
    if len(found) > _MOST:
        which = "nearest" if near[0]["margin"] is not None else "lowest"
        text = f"{len(found)} that unbalance excites; {which}: {text}"
    return Answer("Critical speeds (AF: amplification factor)", text)


def _gravity_critical_speeds(found: Sequence[Mapping[str, Any]] | None) -> Iterator[Answer]:
    """Yield the speeds at which the weight is in resonance, where a body is asymmetric."""
    if found is None:
        return
    listed = "; ".join(rpm_text(one["speed_rpm"]) for one in found[:_MOST])
    more = f", and {len(found) - _MOST} more" if len(found) > _MOST else ""
    yield Answer("Gravity critical speeds", f"{listed}{more}" or "none in the speed range")


def _margins(found: Mapping[str, Any]) -> Iterator[Answer]:
    if found["passed"] is None:
        return
    word = "pass" if found["passed"] else "fail"
    method = {"api617": "API 617"}.get(found["method"], str(found["method"]))
    good = None if found["passed"] and not found["decided"] else bool(found["passed"])
    yield Answer("Separation margins", f"{word} (by {method}): {found['why']}", good)


def _vibration(found: Sequence[Mapping[str, Any]]) -> Iterator[Answer]:
    """Yield the largest vibration at operating speeds; without these, that of the sweep."""
    key = "at_operating" if any(v["at_operating"] for v in found) else "over_sweep"
    known = [v for v in found if v[key] is not None]
    if not known:
        return
    worst = max(known, key=lambda v: v[key]["peak_to_peak_um"])
    own, limit = worst[key], worst["api617_limit_um"]
    text = (
        f"{own['peak_to_peak_um']:.3g} µm peak to peak at {worst['place']}, "
        f"{rpm_text(own['speed_rpm'])}"
    )
    if len(found) > 1:
        text += f", the largest of {len(found)} places"
    if key == "at_operating" and limit is not None:
        text += f"; limit of API 617 at the probes: {limit:.3g} µm"
    yield Answer("Vibration", text)


def _accuracy(found: Mapping[str, Any]) -> Answer:
    largest, asked = found["largest_error_estimate"], percent_text(found["asked"])
    names = ", ".join(found["not_estimated"])
    if largest is None:
        return Answer("Accuracy", f"not estimated: {names}" if names else "no error estimates")
    told, good = f"{percent_text(largest)} estimated, {asked} asked", found["met"]
    if names and good is None:
        return Answer("Accuracy", f"not estimated: {names}; the rest {told}")
    met = {True: "met", False: "NOT met", None: "not known"}[good]
    return Answer("Accuracy", f"{met}: {told}" + f"; not estimated: {names}" * bool(names), good)


def _coupling(verdict: Mapping[str, Any]) -> Iterator[Answer]:
    """Yield the choice of the coupling where it is worth more than the estimated error."""
    effect = verdict["coupling_effect"]
    largest = verdict["accuracy"]["largest_error_estimate"] or 0.0
    if effect is not None and effect > _MUCH * max(largest, _ROUNDING):
        text = f"up to {percent_text(effect)} by rigid instead of distributing ones, or the reverse"
        yield Answer("Choice of interfaces", text)


def rpm_text(speed_rpm: float) -> str:
    """Return a speed in whole rpm, below 100 rpm with four digits."""
    return f"{speed_rpm:.0f} rpm" if speed_rpm >= 100.0 else f"{speed_rpm:.4g} rpm"


def percent_text(relative: float | None) -> str:
    """Return a relative error in percent, two digits; below 0.001 % it is not told how small."""
    if relative is None:
        return "-"
    if relative < 1e-5:
        return "< 0.001 %"
    return f"{100.0 * relative:.2g} %" if relative < 0.995 else f"{100.0 * relative:.0f} %"
