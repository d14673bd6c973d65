"""What a run says: schedule, lines and bar, the table at the end, JSON."""

from __future__ import annotations

import io
import json
import os
import pty
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.console.schedule import Schedule, run_steps
from solidwhirl.console.summary import percent_text, print_summary, summary_document
from solidwhirl.console.terminal import RunProgress, duration_text, telling
from solidwhirl.core.stages import Stage, StageName

PROGRAM = str(Path(sys.executable).parent / "solidwhirl")


class Watch:
    """A clock that stands until it is put forward."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


CRITICAL = Stage(name=StageName.CRITICAL_SPEEDS)


def reduction(body, seconds=0.0, detail=""):
    return Stage(name=StageName.REDUCTION, body=body, seconds=seconds, detail=detail)


def schedule(**seconds):
    """A schedule of reductions of some bodies and the clock it looks at."""
    watch = Watch()
    found = Schedule(watch)
    found.foresee([reduction(body, spent) for body, spent in seconds.items()])
    return found, watch


@pytest.mark.parametrize("detail", ["", ", iteratively as the scene says"])
def test_time_to_go_follows_the_forecast(detail):
    """Whatever people are told of a stage beside its name."""
    found, watch = schedule(a=10.0, b=20.0, c=30.0)
    assert found.to_go_s() == pytest.approx(60.0)
    found.begin(reduction("a", detail=detail))
    for spent in range(8):  # the last part of a stage is counted down slower
        assert found.to_go_s() == pytest.approx(60.0 - spent)
        assert found.share() == pytest.approx(spent / 60.0)
        watch.now += 1.0
    watch.now += 2.0
    assert found.begin(reduction("b")) == (reduction("a", detail=detail), 10.0)
    assert found.to_go_s() == pytest.approx(50.0)
    assert found.share() == pytest.approx(10.0 / 60.0)


def test_a_slower_machine_takes_longer_and_what_is_skipped_counts_no_more():
    """Twice the predicted time so far, beside a prior of a quarter of the whole."""
    found, watch = schedule(a=100.0, b=50.0, c=50.0)
    found.begin(reduction("a"))
    watch.now += 200.0
    found.begin(reduction("b"))
    assert found.slowness == pytest.approx(250.0 / 150.0)
    assert found.to_go_s() == pytest.approx(100.0 * 250.0 / 150.0)
    # stages that were kept say nothing
    found, watch = schedule(a=1.0, b=100.0, c=3.0)
    found.begin(reduction("a"))
    watch.now += 1.0
    found.begin(reduction("c"))
    assert found.to_go_s() == pytest.approx(3.0)
    assert found.slowness == pytest.approx(1.0)


def test_a_stage_that_lasts_longer_is_not_over():
    """The bar neither ends before the run nor goes back; before the forecast nothing is known."""
    found = Schedule(Watch())
    assert (found.to_go_s(), found.share()) == (None, 0.0)
    found, watch = schedule(a=2.0)
    found.begin(reduction("a"))
    shares = []
    for _ in range(50):
        watch.now += 1.0
        shares.append(found.share())
        assert found.to_go_s() > 0.0
    assert shares == sorted(shares)
    assert shares[-1] < 1.0
    # a round that was not foreseen lasts as long as the last one, but what was said stands
    assert found.begin(reduction("a")) == (reduction("a"), 50.0)
    assert found.slowness * found._current.seconds == pytest.approx(50.0)
    assert 0.0 < found.to_go_s() < 0.1
    assert found.end() == (reduction("a"), 0.0)
    assert found.end() is None
    assert found.to_go_s() is None
    assert found.share() >= shares[-1]


RECORDED = json.loads(Path(__file__).with_name("recorded_runs.json").read_text(encoding="utf-8"))


def replayed(run, samples=400):
    """Times, what was said to go, and shares, of a run whose stages began as recorded [s]."""
    watch = Watch()
    watch.now, (end, _, _) = 0.0, run["began"][-1]
    found, events = Schedule(watch), run["began"][:-1]
    found.foresee([Stage(name=StageName(n), body=b, seconds=s) for n, b, s in run["foreseen"]])
    out = []
    for at in np.linspace(0.0, end, samples, endpoint=False):
        while events and events[0][0] <= at:
            (watch.now, name, body), *events = events
            found.begin(Stage(name=StageName(name), body=body))
        watch.now = float(at)
        out.append((at, found.to_go_s(), found.share()))
    return end, np.array(out).T


def test_time_to_go_of_recorded_runs_never_rises_by_more_than_a_tenth():
    """Cold runs on a busy machine, among them rounds and analyses that the forecast had wrong."""
    halfway = []
    for name, run in RECORDED.items():
        end, (at, said, shares) = replayed(run)
        least = np.minimum.accumulate(said)
        assert (said[1:] <= 1.1 * least[:-1] * (1.0 + 1e-12)).all(), name
        assert (said > 0.0).all(), name
        assert (np.diff(shares) >= 0.0).all(), name
        middle = at.size // 2
        halfway.append(said[middle] / (end - at[middle]))
    # what is said is the time to go, and no number that only falls
    assert 0.7 < np.median(halfway) < 1.4


def spoken(**console):
    """What a run says to a console, its text and its progress."""
    text = io.StringIO()
    progress = RunProgress(console=Console(file=text, width=100, **console))
    return text, progress


def test_lines_where_there_is_no_terminal():
    text, progress = spoken()
    with progress:
        progress("level harmonic: [red]about[/red] 2 s")
        progress(Stage(name=StageName.MESHING, body="rotor", detail=" (harmonic)"))
        progress.foresee([reduction("rotor", 400.0)])
        progress(reduction("rotor"))
    assert text.getvalue().splitlines() == [
        "level harmonic: [red]about[/red] 2 s",  # as it is, no markup
        "mesh rotor (harmonic)",
        "reduce rotor (about 7 min to go)",
    ]
    assert "\x1b" not in text.getvalue()


def test_bar_on_a_terminal():
    text, progress = spoken(force_terminal=True, color_system=None)
    with progress:
        progress.foresee(
            [reduction("rotor", 1.0), Stage(name=StageName.CRITICAL_SPEEDS, seconds=90.0)]
        )
        progress(reduction("rotor"))
        progress(CRITICAL)
        time.sleep(0.2)  # the bar is drawn ten times a second
    shown = text.getvalue()
    assert "✓ reduce rotor" in shown
    assert "✓ critical speeds" in shown
    assert "to go" in shown
    assert shown.rstrip("\n").endswith("\x1b[2K")  # the bar itself is gone at the end
    # a stage that fails is not ticked off
    text, progress = spoken(force_terminal=True, color_system=None)
    with pytest.raises(ValueError, match="no"), progress:
        progress(reduction("rotor"))
        raise ValueError("no")
    assert "✓" not in text.getvalue()


def test_quiet_says_nothing(capsys):
    with RunProgress(quiet=True) as progress, telling(True) as tell:
        progress(reduction("rotor"))
        tell("[b]x")
    with telling(False) as tell:
        tell("[b]x")
    assert capsys.readouterr() == ("", "[b]x\n")


def test_numbers_for_people():
    said = [duration_text(s) for s in (0.04, 9.9, 42.0, 600.0, 7200.0)]
    assert said == ["0.0 s", "9.9 s", "42 s", "10 min", "2.0 h"]
    said = [percent_text(e) for e in (None, 1e-7, 2.34e-3, 0.1)]
    assert said == ["-", "< 0.001 %", "0.23 %", "10 %"]


@pytest.fixture(scope="module")
def small_run(tmp_path_factory, small_scene):
    """Folder, results, documents and all that a run of the small scene said."""
    from solidwhirl.output.documents import write_results
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import parse_scene

    margins = {"kind": "separation_margins", "search_factor": 1.0}
    operating = [{"shaft": "rotor", "from_rpm": 20000, "to_rpm": 25000}]
    data = small_scene(model={"estimates": "on", "modes": 4, "level": "harmonic"})
    data["analyses"] = [{**margins, "operating": operating}]
    said, foreseen = [], []

    def take(plan, expected):
        foreseen.append(run_steps(plan, expected, pictures=False))

    scene = parse_scene(data)
    results = run_scene(scene, progress=said.append, foreseen=take)
    out = tmp_path_factory.mktemp("small")
    write_results(results, out, pictures=False)
    written = json.loads((out / "results.json").read_text(encoding="utf-8"))
    summed = summary_document(results, written, out, seconds=12.0)
    return SimpleNamespace(
        out=out, results=results, said=said, foreseen=foreseen, written=written, summed=summed
    )


@pytest.mark.solver
def test_stages_are_those_that_were_foreseen(small_run):
    """In this order; the first line is a remark, and what is written comes after the run."""
    (steps,), said = small_run.foreseen, small_run.said
    stages = [event for event in said if isinstance(event, Stage)]
    assert len(stages) >= 6
    assert set(stages) < set(steps)
    assert {"reduce rotor", "critical speeds", "error estimates"} < {str(one) for one in stages}
    remarks = [event for event in said if isinstance(event, str)]
    assert all(text.startswith(("level ", "estimated error ")) for text in remarks)
    assert str(steps[-1]) == "write the results"


@pytest.mark.solver
def test_all_that_is_to_come_is_told_at_the_start(small_run):
    """The sum over all stages is the forecast, and pictures where they are drawn."""
    results, longer = small_run.results, {}
    for pictures in (True, False):
        text = io.StringIO()
        progress = RunProgress(console=Console(file=text, width=100), pictures=pictures)
        with progress:
            progress.foreseen(results.plan, results.forecast)
        steps = run_steps(results.plan, results.forecast, pictures=pictures)
        longer[pictures] = sum(step.seconds for step in steps)
        said = "analyses and pictures" if pictures else "analyses"
        wanted = f"about {duration_text(longer[pictures])} until all is written, with {said}\n"
        assert text.getvalue() == wanted
    expected = results.forecast  # what is told comes after the start
    assert longer[False] == pytest.approx(expected.seconds - expected.start_s)
    assert longer[True] - longer[False] == pytest.approx(expected.writing.pictures_s)


@pytest.mark.solver
def test_summary_has_the_results(small_run):
    """Margins are those of the analysis, which finds its critical speeds anew: hence tolerances."""
    found, results = small_run.summed, small_run.results
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["seconds"] == 12.0
    assert found["computing_seconds"] == sum(results.timings_s.values())
    assert found["files"] == ["report.html", "report.md", "results.json"]
    assert found["checks"]["failed"] == 0
    assert found["checks"]["passed"] > 10
    rows = found["critical_speeds"]
    assert len(rows) > 0
    for row, entry in zip(rows, small_run.written["critical_speeds"], strict=True):
        assert {key: row[key] for key in row.keys() & entry.keys()}.items() <= entry.items()
    theirs = results.analyses["separation_margins"].document["margins"]
    for row, their in zip(rows, theirs, strict=True):
        assert row["speed_rpm"] == pytest.approx(their["critical_speed_rpm"], rel=1e-6)
        assert row["margin"] == pytest.approx(their["margin"], abs=1e-6)
        assert row["margin_of"] == "rotor"


@pytest.mark.solver
def test_table_is_legible_without_a_terminal(small_run, capsys):
    results = small_run.results
    print_summary(results, small_run.summed)
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    first = next(c for c in results.critical_speeds if c.excitation.excited).critical
    row = next(line for line in shown.splitlines() if line.endswith("below rotor "))
    for text in (f"{first.frequency_hz:.2f}", first.whirl, " %"):
        assert text in row
    assert {"[rpm]", "[Hz]", "[%]"} <= {*shown.split()}
    assert "checks: " in shown
    assert shown.splitlines()[1].startswith("stability: stable, 0 to ")
    computing = sum(results.timings_s.values())
    assert f"time 12 s (computing {duration_text(computing)}), " in shown
    assert f"results: {small_run.out / 'results.json'}" in shown


@pytest.fixture
def path(root):
    """The Laval rotor, which beams run in a tenth of a second."""
    return root / "scenes" / "laval.toml"


@pytest.mark.solver
def test_json_is_all_that_stands_on_stdout(tmp_path, path):
    options = ["--out", str(tmp_path / "out"), "--level", "beam", "--no-pictures", "--json"]
    done = CliRunner().invoke(app, ["run", str(path), *options])
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["schema"], found["exit_code"], found["error"]) == ("solidwhirl-run-1", 0, None)
    # closed form of the scene's comment, see test_scenes: 19.54 Hz
    assert found["critical_speeds"][0]["frequency_hz"] == pytest.approx(19.54, abs=0.01)
    assert "critical speeds" in done.stderr
    quiet = CliRunner().invoke(app, ["run", str(path), *options, "--quiet"])
    assert json.loads(quiet.stdout)["critical_speeds"] == found["critical_speeds"]
    assert quiet.stderr == ""


def test_json_of_a_plan_and_of_a_refusal(tmp_path, path):
    done = CliRunner().invoke(app, ["plan", str(path), "--level", "harmonic", "--json"])
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["bodies"]["rotor"]["level"] == "harmonic"
    assert found["predicted_cost"]["cpu_s"] > 0.0
    path = tmp_path / "bad.toml"
    path.write_text("name = 3\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["run", str(path), "--out", str(tmp_path / "o"), "--json"])
    assert done.exit_code == 2
    found = json.loads(done.stdout)
    assert found["exit_code"] == 2
    assert f"{path}:1:1: name: " in found["error"]
    assert done.stderr == f"error: {found['error']}\n"


def seen_by_a_terminal(command, columns=100):
    """What a command writes to a terminal, and its exit code."""
    master, slave = pty.openpty()
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": str(columns)}
    environment.pop("NO_COLOR", None)
    with subprocess.Popen(
        command, stdin=slave, stdout=slave, stderr=slave, env=environment, close_fds=True
    ) as process:
        os.close(slave)
        found = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            found += part
    os.close(master)
    return process.returncode, found.decode()


@pytest.mark.solver
def test_a_run_in_a_terminal(tmp_path, path):
    quick = tmp_path / "laval.toml"
    text = path.read_text(encoding="utf-8").replace("count = 13", "count = 2")
    quick.write_text(text, encoding="utf-8")
    options = ["--out", str(tmp_path / "out"), "--level", "beam", "--no-pictures"]
    code, shown = seen_by_a_terminal([PROGRAM, "run", str(quick), *options])
    assert code == 0, shown
    assert "✓ \x1b[0mcritical speeds" in shown
    assert "\x1b[?25l" in shown  # the cursor was hidden while there was a bar,
    assert shown.rindex("\x1b[?25h") > shown.rindex("\x1b[?25l")  # and shown again
    table = shown[shown.rindex("\x1b[?25h") :]
    assert "19.54" in table
    assert "□ backward" not in table and "not excited by unbalance" in table
    assert "● forward" in table
