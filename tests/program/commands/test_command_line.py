"""What the command refuses besides a wrong scene, its help and the examples in it, completion."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main
from typer.testing import CliRunner

from solidwhirl.cli import app, every_command

COMMANDS = every_command()
PROGRAM = Path(sys.executable).parent / "solidwhirl"
PATH = f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", ["name: missing", "name: missing"]),
        (b"name = = 3", ["bad.toml:1:8: is not valid TOML"]),
        (b'name = "a"\nname = "b"', ["is not valid TOML"]),
        # after ä, which is two bytes and one character
        (b'name = "a"\ntitle = "\xc3\xa4\xff"\n', ["bad.toml:2:11: is not UTF-8 text (byte 22)"]),
        (b'name = "a"\nnotes = [\n', ["bad.toml:3:1: is not valid TOML"]),
        (b"\x00\x01\x02", ["is not valid TOML"]),
        (b"[" * 100_000, ["is not valid TOML"]),
        (b"#" * 4_000_001, ["has 4000001 bytes, at most 4000000 are allowed"]),
    ],
)
def test_file_that_is_no_scene(invoke, content, said, refusal):
    done, written = invoke(content)
    message = refusal(done, "bad.toml")
    for text in said:
        assert text in message
    assert not written


def test_file_that_can_not_be_read(tmp_path, refusal):
    for path, said in ((tmp_path / "none.toml", "no such file"), (tmp_path, "is no regular file")):
        for command in (["run", str(path), "--out", str(tmp_path / "out")], ["plan", str(path)]):
            message = refusal(CliRunner().invoke(app, command), path.name)
            assert said in message
            assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--level", "plate"), ["--level", "'auto', 'beam', 'harmonic' or", "found 'plate'"]),
        (("--accuracy", "5"), ["--accuracy", "less than or equal to 0.1", "found 5.0"]),
        (("--accuracy", "0"), ["--accuracy", "greater than or equal to 0.000001", "found 0.0"]),
        (("--accuracy", "nan"), ["--accuracy", "found nan"]),
    ],
)
def test_bad_option(invoke, ferraris, options, said, refusal):
    done, written = invoke(ferraris, *options)
    message = refusal(done, "command line")
    for text in said:
        assert text in message
    assert not written


def test_option_that_contradicts_the_scene_or_is_no_number(
    invoke, ferraris, changed, refusal, tmp_path
):
    done, _ = invoke(changed(ferraris, "[model]", "[model]\norder = 4"), "--level", "solid")
    assert "--level: order = 4 with level 'solid'" in refusal(done, "command line")
    # beams have no stress: what would ask for it is left out, and told
    stress = '[[analyses]]\nname = "stress"\nkind = "recovery"\nbodies = ["inner"]\n'
    asked = ferraris + stress + "states = [{ speed_rpm = 9000 }]\n"
    (tmp_path / "asked.toml").write_text(asked, encoding="utf-8")
    done = CliRunner().invoke(app, ["plan", str(tmp_path / "asked.toml"), "--level", "beam"])
    assert done.exit_code == 0 and "--level beam leaves out stress: beams" in done.stderr
    # typer's own message
    done, written = invoke(ferraris, "--accuracy", "fine")
    assert done.exit_code == 2 and not written
    assert "--accuracy" in done.stderr and "valid number" in done.stderr
    assert "Traceback" not in done.stderr


def test_output_that_is_no_folder(invoke, ferraris, tmp_path, refusal):
    (tmp_path / "taken").write_text("kept", encoding="utf-8")
    for out in ("taken", "taken/below/it"):
        done, _ = invoke(ferraris, out=out)
        message = refusal(done, out)
        assert "can not be written" in message
        assert "is not a folder" in message
        assert "mesh " not in message
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "kept"


def test_output_without_permission(invoke, ferraris, tmp_path, monkeypatch, refusal):
    """By a stand-in for the system's answer, since root may write everywhere."""
    real = os.access

    def access(path, mode, **options):
        return Path(path) != tmp_path and real(path, mode, **options)

    monkeypatch.setattr(os, "access", access)
    done, written = invoke(ferraris)
    message = refusal(done, "results")
    assert "can not be written: no permission in" in message
    assert "mesh " not in message
    assert not written


def test_installed_command(tmp_path, ferraris, changed):
    """As a user starts it: exit code 2, one line on stderr, no traceback, no folder."""
    (tmp_path / "bad.toml").write_text(changed(ferraris, "1e10", "-inf"), encoding="utf-8")
    command = [str(PROGRAM), "run", "bad.toml", "--out", "out"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) <= 2  # both diagonal entries of the matrix
    line = 1 + ferraris[: ferraris.index("1e10")].count("\n")
    assert f"bad.toml:{line}:1: bearings[0].stiffness_n_per_m" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def shown_examples(name):
    """Lines of the examples in a command's help."""
    help_text = COMMANDS[name].epilog if name else typer.main.get_command(app).epilog
    head, *lines = help_text.split("\n\n")
    assert head == "Examples:"
    return lines


@pytest.mark.parametrize("name", [*COMMANDS, ""])
def test_every_command_has_help_with_examples(name):
    done = CliRunner().invoke(app, [*([name] if name else []), "--help"], env={"COLUMNS": "80"})
    assert done.exit_code == 0
    shown = done.stdout
    assert "Usage: " in shown
    for line in shown_examples(name):
        assert f" {line} " in shown.replace("\n", " \n"), "broken over two lines"
        words = shlex.split(line)
        at = words.index("solidwhirl")
        assert words[at + 1] == name or not name
    assert shown_examples(name)
    # brackets are no markup: of a batch, the scenes may have a table [sweep]
    assert name != "batch" or "[sweep]" in shown


@pytest.mark.parametrize("words", [("plan", "--help"), ("plan", "--leve")])
def test_a_plain_terminal_gets_plain_help(words):
    environment = {**os.environ, "TERM": "dumb", "COLUMNS": "80"}
    environment.pop("FORCE_COLOR", None)
    done = subprocess.run(
        [PROGRAM, *words], env=environment, capture_output=True, text=True, check=False
    )
    shown = done.stdout + done.stderr
    assert shown.isascii(), "boxes or colours"
    assert "\x1b" not in shown
    assert "solidwhirl" in shown
    if words[-1] == "--help":
        assert "--help" in shown
        assert "\n\n  Examples:\n\n  solidwhirl " in shown


# In an order in which what one example writes is there for the next; those that search or compute
# many cases take a minute. A study that is not quick takes many, and does the same with more cases.
QUICK = ("init", "check", "geometry", "export", "formats", "schema", "plan", "version")
LONG = ("doctor", "run", "batch batch-pictures", "study", "identify", "pictures")
# What serves until it is ended: tests/program/watch.
SERVING = ("watch",)
# On files of the reader's own: tests/program/bearing_tables, and docs/howto.md.
OWN_FILES = ("bearing",)
# The example whose folder those of `check` and `export` read.
BEAM_RUN = "solidwhirl run scenes/laval.toml --out out/laval --level beam --pictures"


@pytest.mark.solver
def test_examples_run(tmp_path, monkeypatch, root):
    """As they are typed, in a folder with the scenes of the project."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").symlink_to(root / "scenes", target_is_directory=True)
    assert BEAM_RUN in shown_examples("run")
    for line in [BEAM_RUN, *(line for name in QUICK for line in shown_examples(name))]:
        program, *words = shlex.split(line)
        assert program == "solidwhirl"
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, f"{line}: {done.output}"
    assert (tmp_path / "out" / "laval" / "results.json").is_file()


@pytest.mark.verify
@pytest.mark.solver
@pytest.mark.mpi
@pytest.mark.parametrize("name", LONG)
def test_long_examples_run(tmp_path, root, name):
    (tmp_path / "scenes").symlink_to(root / "scenes", target_is_directory=True)
    mpi = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    mpi |= {"OMPI_MCA_rmaps_base_oversubscribe": "1"}
    for line in [line for one in name.split() for line in shown_examples(one)]:
        if " study " in line and "--quick" not in line:
            continue
        done = subprocess.run(
            shlex.split(line),
            cwd=tmp_path,
            env={**os.environ, **mpi, "PATH": PATH},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{line}: {done.stdout}"


def test_all_examples_are_run():
    assert sorted([*QUICK, *" ".join(LONG).split(), *SERVING, *OWN_FILES]) == sorted(COMMANDS)


@pytest.fixture(scope="module")
def completed(tmp_path_factory):
    """Function: what bash proposes after a line, by the script that the program gives."""
    folder = tmp_path_factory.mktemp("completion")
    (folder / "mine.toml").touch()
    # as --show-completion prints it, without a look at which shell this is
    script = subprocess.run(
        [str(PROGRAM)],
        env={**os.environ, "_SOLIDWHIRL_COMPLETE": "source_bash"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    (folder / "complete.sh").write_text(script, encoding="utf-8")

    def propose(line):
        words = line.split(" ")
        asked = (
            "source ./complete.sh\n"
            f"COMP_WORDS=({' '.join(shlex.quote(w) for w in words)})\n"
            f"COMP_CWORD={len(words) - 1}\n"
            "_solidwhirl_completion solidwhirl\n"
            'printf "%s\\n" "${COMPREPLY[@]}"\n'
        )
        done = subprocess.run(
            ["bash", "--norc", "-c", asked],
            cwd=folder,
            env={**os.environ, "PATH": PATH},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stderr == ""
        return done.stdout.split()

    propose.script = script
    return propose


def test_completion_in_bash(completed):
    assert "complete -o default -F _solidwhirl_completion solidwhirl" in completed.script
    assert set(completed("solidwhirl ")) == set(COMMANDS)
    assert completed("solidwhirl export --format s") == ["sid"]


@pytest.mark.verify
def test_more_completion_in_bash(completed):
    assert "--accuracy" in completed("solidwhirl run --")
    assert completed("solidwhirl pl") == ["plan"]
    assert completed("solidwhirl run --level ha") == ["harmonic"]
    assert completed("solidwhirl init --kind t") == ["twin"]


@pytest.mark.verify
def test_completion_is_installed_for_bash(tmp_path):
    done = subprocess.run(
        ["bash", "-c", f"{shlex.quote(str(PROGRAM))} --install-completion bash"],
        env={
            **os.environ,
            "HOME": str(tmp_path),
            "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "solidwhirl" in (tmp_path / ".bashrc").read_text(encoding="utf-8")
    scripts = list((tmp_path / ".bash_completions").iterdir())
    assert [path.name for path in scripts] == ["solidwhirl.sh"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["rnu", "x.toml"], "did you mean 'run'?"),
        (["plans"], "did you mean 'plan'?"),
        (["schema", "scenes"], "did you mean 'scene'?"),
        (["init", "x.toml", "--kind", "lavall"], "did you mean 'laval'?"),
        (["zzz"], "no command 'zzz'; allowed are init, run, plan"),
    ],
)
def test_names_are_proposed(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, words, env={"COLUMNS": "200", "TERM": "dumb"})
    assert done.exit_code == 2 and done.stdout == ""
    assert said in " ".join(done.stderr.replace("│", " ").split())
    assert not list(tmp_path.iterdir())


ONE_BEARING = """
name = "{name}"
[speeds]
to_rpm = 3000
count = 3
[beams.rotor]
material = "steel"
stations_m = [0.0, 0.3, 0.6]
outer_radius_m = [0.02]
interfaces = {{ left = 0.0, middle = 0.3, right = 0.6 }}
[[bearings]]
name = "left"
first = {first}
stiffness_n_per_m = 1e7
"""


def test_plan_says_that_a_rotor_is_free(tmp_path):
    """One bearing leaves the two tilts, two at its ends none; costs stand behind an option."""
    path = tmp_path / "rotor.toml"
    path.write_text(ONE_BEARING.format(name="rotor", first='"rotor.left"'), encoding="utf-8")
    done = CliRunner().invoke(app, ["plan", str(path)])
    (line,) = done.stderr.splitlines()
    assert line.startswith("warning: bearings: 'rotor' is held by one bearing only ('left') and")
    assert "2 lateral motions at 0 Hz" in line
    assert done.exit_code == 0 and "warning" not in done.stdout
    assert "--costs says of what" in done.stdout and "predicted s" not in done.stdout
    assert "predicted s" in CliRunner().invoke(app, ["plan", str(path), "--costs"]).stdout
    both = '["rotor.left", "rotor.right"]'
    path.write_text(ONE_BEARING.format(name="rotor", first=both), encoding="utf-8")
    assert CliRunner().invoke(app, ["plan", str(path)]).stderr == ""


def test_folders_of_others_are_not_written_into(root, tmp_path, refusal):
    path = tmp_path / "rotor.toml"
    path.write_text(ONE_BEARING.format(name="rotor", first='"rotor.left"'), encoding="utf-8")
    laval = root / "scenes" / "laval.toml"
    for command, scene in (("run", path), ("pictures", path), ("batch", path), ("study", laval)):
        for out in (Path("/"), tmp_path):
            done = CliRunner().invoke(app, [command, str(scene), "--out", str(out)])
            assert "is not empty (" in refusal(done, str(out))
    assert [p.name for p in tmp_path.iterdir()] == ["rotor.toml"]


@pytest.mark.solver
def test_results_go_into_a_folder_by_the_name_of_the_scene_file(tmp_path, monkeypatch):
    """And warnings to standard error; neither a run nor a batch takes the folder of the other."""
    monkeypatch.chdir(tmp_path)
    Path("shaft.toml").write_text(ONE_BEARING.format(name="rotor", first='"rotor.left"'))
    done = CliRunner().invoke(app, ["run", "shaft.toml"])
    assert done.exit_code == 0, done.stderr
    assert Path("out", "shaft", "results.json").is_file()
    assert "results: out/shaft/results.json" in done.stdout and "warning" not in done.stdout
    assert "held by one bearing only" in done.stderr
    again = CliRunner().invoke(app, ["run", "shaft.toml", "-q"])
    assert (again.exit_code, again.stdout) == (0, "")
    done = CliRunner().invoke(app, ["batch", "shaft.toml"])
    assert done.exit_code == 2 and "is the folder of a run" in done.stderr
    done = CliRunner().invoke(app, ["batch", "shaft.toml", "--out", "out/many"])
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("1 rows, 0 failed, 0 with failed checks: out/many/")
    done = CliRunner().invoke(app, ["run", "shaft.toml", "--out", "out/many"])
    assert done.exit_code == 2 and "is the folder of a batch" in done.stderr
