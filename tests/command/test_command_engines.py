"""Engines that are programs: what a file of entries may say, and what a run makes of what the program does."""

import functools
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import barchain
from adapters.command.entries import FILES, EntryError, content_digest, read_entries, unpacked
from adapters.command.own_python import VARIABLE
from adapters.engine import Setting
from adapters.registry import engines, find_engine
from barchain.cli.engines import OFFERED
from barchain.cli.main import cli
from barchain.conform.run import conform
from barchain.engine.new_program import LANGUAGES, write_program
from barchain.nightly.figures.dependencies import capture, depends_on, installed_parts
from barchain.nightly.figures.figure import FigureKind
from barchain.runs import questions
from barchain.runs.job import Job, Role
from barchain.runs.kept_answers import answer_key
from barchain.runs.run import one_run, outside_call
from reports.results.outcome import Outcome
from tests.support.results import read_record
from tests.support.slow import one_in, rows, slow_but

SCENE = barchain.change_scene(barchain.load_scene("basics/two_bars_free"), {"run": {"samples": 5, "duration_s": 100.0}})
ENTRY = """
[[engine]]
name = "mine"
command = "{python} program.py {{request}} {{samples}} {{result}}"
effects = ["gravity.none", "gravity.point"]
rtol = [1e-8, 1e-10]
files = ["program.py"]
"""
RIGHT = """
import json, sys
from pathlib import Path
request, samples, result = sys.argv[1:]
assert json.load(open(request))["setting"]["value"] == 1e-10
table = Path(__file__).with_name("right.csv").read_text("utf-8")
open(samples, "w", encoding="utf-8").write(table)
json.dump({"version": 1, "seconds": 0.25, "steps": 7}, open(result, "w"))
"""
"""Program that gives the reference's samples, which lie beside it"""


@functools.cache
def right_samples(scene):
    found = barchain.simulate(scene, "reference", rtol=1e-10).to_frame()
    return found.drop(columns=[c for c in found if c.startswith(("gap", "com_residual"))]).to_csv(index=False)


@pytest.fixture
def program(tmp_path, monkeypatch):
    """Function that makes the engine `mine` of a program's text, and registers it."""

    def made(text, entry=ENTRY, scene=SCENE):
        (tmp_path / "program.py").write_text(text)
        (tmp_path / "right.csv").write_text(right_samples(scene))
        (tmp_path / "engines.toml").write_text(entry.format(python=sys.executable))
        monkeypatch.setenv(FILES, str(tmp_path / "engines.toml"))
        return find_engine("mine")

    return made


def run(registration):
    setting = Setting("rtol", 1e-10)
    return one_run(Job(SCENE, "mine", registration, setting, Role.MAIN), 60.0)


def test_a_run_has_the_samples_that_the_program_wrote(program):
    found = run(program(RIGHT))
    assert found.outcome is Outcome.PASS, found.reason
    own = barchain.simulate(SCENE, "reference", rtol=1e-10)
    assert (found.trajectory.angle_rad == own.angle_rad).all()
    assert found.trajectory.info["steps"] == 7
    assert found.seconds["simulate"] == 0.25, "the program's own clock"
    assert found.seconds["process"] > 0.0


def test_a_program_without_reactions_carries_a_single_bar(program):
    """A single bar has no joints: its table holds all reactions that there are, which are none."""
    single = 'observables = ["com", "attitude", "rate"]\nrtol ='
    scene = barchain.change_scene(barchain.load_scene("conform/one_bar_point"), {"run": {"samples": 5}})
    registration = program(RIGHT, ENTRY.replace("rtol =", single), scene)
    found = one_run(Job(scene, "mine", registration, Setting("rtol", 1e-10), Role.MAIN), 60.0)
    assert found.outcome is Outcome.PASS, found.reason
    assert found.trajectory.reaction_N is None


def with_table(written):
    """The right program with another table."""
    return RIGHT.replace("write(table)", f"write({written})")


@pytest.mark.parametrize(
    ("text", "outcome", "words"),
    one_in(4, rows([
        ("import sys; sys.exit('no licence')", Outcome.FAILED, "no licence"),
        ("pass", Outcome.FAILED, "without a result"),
        ("import os; os.kill(os.getpid(), 11)", Outcome.FAILED, "signal 11"),
        ("import sys; open(sys.argv[3], 'w').write('{')", Outcome.FAILED, "damaged"),
        ("import sys; open(sys.argv[3], 'w').write('{\"version\": 2}')", Outcome.FAILED, "version"),
        (RIGHT.replace('"steps"', '"stepz"'), Outcome.FAILED, "stepz"),
        (with_table("table.replace('angle_1_rad', 'angel_1_rad')"), Outcome.FAILED, "did you mean angle_1_rad?"),
        (with_table("table.replace('angle_1_rad', 'angle_0_rad')"), Outcome.FAILED,
         "a column angle_0_rad; allowed: angle_1_rad"),
        (with_table("table.replace('angle_2_rad', 'angle_1_rad')"), Outcome.FAILED, "has two columns angle_1_rad"),
        (RIGHT.replace('"steps": 7', '"outcome": "unsupported", "reason": "no hinges"'), Outcome.UNSUPPORTED, "hinges"),
        (with_table("''.join(table.splitlines(True)[:4])"), Outcome.INCOMPLETE, "3 of 5 samples"),
        (RIGHT.replace('"steps": 7', '"outcome": "failed", "reason": "singular"'), Outcome.FAILED, "singular"),
        ("import sys; open(sys.argv[3], 'w').write('[]')", Outcome.FAILED, "[] given, allowed: an object"),
        (RIGHT.replace('"steps": 7', '"steps": 10**400'), Outcome.FAILED, "steps: 1000"),
        (RIGHT.replace('"steps": 7', '"samples": "../x"'), Outcome.FAILED, "the name of a file beside this one"),
        ("import os, sys; os.mkdir(sys.argv[3])", Outcome.FAILED, "Is a directory"),
        (with_table("table.replace('\\n0.0', '\\n٣0.0')"), Outcome.FAILED,
         "line 2, column t_s: '٣0.0' is no number"),
    ])),
)  # fmt: skip
def test_a_program_that_goes_wrong_costs_its_run_and_says_why(program, text, outcome, words):
    found = run(program(text))
    assert found.outcome is outcome
    assert words in found.reason


def test_a_program_that_hangs_ends_with_its_children(program):
    text = "import subprocess, time; subprocess.Popen(['sleep', '987654']); time.sleep(1000)"
    found = one_run(Job(SCENE, "mine", program(text), Setting("rtol", 1e-10), Role.MAIN), 1.0)
    assert found.outcome is Outcome.TIMED_OUT
    assert not subprocess.run(["pgrep", "-f", "sleep 987654"], capture_output=True, check=False).stdout


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("effects", "efects"), "did you mean effects?"),
        (("gravity.point", "gravity.pont"), "did you mean gravity.point?"),
        (("{{samples}} {{result}}", ""), "{samples} or {result}"),
        (('"{python} program', "\"'{python} program"), "quotation"),
        (("[1e-8, 1e-10]", "[1e-10, 1e-8]"), "from coarse to fine"),
        (("rtol =", "order = 4\nrtol ="), "order"),
        (('"mine"', '"my engine"'), "name"),
        (("rtol =", 'requirements = ["numpy"]\nrtol ='), "allowed with {python} in the command"),
        (("rtol =", 'requirements = ["--index-url x"]\nrtol ='), "a requirement such as"),
    ],
)
def test_an_entry_with_a_fault_is_told_in_one_line(tmp_path, change, words):
    path = tmp_path / "engines.toml"
    path.write_text(ENTRY.replace(*change).format(python="python"))
    with pytest.raises(EntryError) as told:
        read_entries(path)
    assert words in str(told.value)
    assert str(path) in str(told.value)
    assert "\n" not in str(told.value)


def test_a_file_of_programs_that_changes_is_read_anew(program):
    program(RIGHT)
    program(RIGHT, ENTRY + ENTRY.replace('"mine"', '"second"'))
    assert {"mine", "second"} <= set(engines())


def test_a_name_that_is_taken_is_rejected_and_told(program):
    program(RIGHT, ENTRY.replace('"mine"', '"pymunk"') + ENTRY)
    rejected = [r.rejected for name, r in engines().items() if name.startswith("pymunk (")]
    assert len(rejected) == 1
    assert "taken" in rejected[0]


@pytest.mark.parametrize("named", ['files = ["program.py"]', ""])
def test_the_version_of_a_program_follows_its_files_and_itself(program, named):
    registration = program(RIGHT, ENTRY.replace('files = ["program.py"]', named))
    folder, entry = unpacked(registration.entry)
    before = content_digest(folder, entry)
    assert registration.version == before
    (folder / "program.py").write_text(RIGHT + "\n")
    assert content_digest(folder, entry) != before


@pytest.mark.slow
def test_a_child_that_a_program_leaves_behind_delays_nothing(program):
    found = run(program(f"{RIGHT}\nimport subprocess\nsubprocess.Popen(['sleep', '876543'], start_new_session=True)\n"))
    assert found.outcome is Outcome.PASS, found.reason
    assert found.seconds["process"] < 30.0
    assert not subprocess.run(["pgrep", "-f", "sleep 876543"], capture_output=True, check=False).stdout


def test_a_program_that_is_not_there_is_missing(program):
    registration = program(RIGHT, ENTRY.replace("{python}", "no-such-program"))
    assert "no-such-program" in registration.missing


OWN = ENTRY.replace("{python} program", "{{python}} program")


def test_a_program_runs_in_the_python_of_its_entry_and_sees_none_of_this_ones_packages(program, tmp_path, monkeypatch):
    """A Python without packages beside one with NumPy: the first sees none, wherever modules of this process lie."""
    bare = tmp_path / "bare"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", bare], check=True)
    alone = "import importlib.util as u, sys; sys.exit('numpy' if u.find_spec('numpy') else 'no numpy')"
    monkeypatch.setenv("PYTHONPATH", str(Path(np.__file__).parents[1]))
    for python, words in (("bare/bin/python", "no numpy"), ("", "numpy")):
        found = run(program(alone, OWN.replace("rtol =", f'python = "{python}"\nrtol =')))
        assert found.reason.endswith(f": {words}"), found.reason
    assert "bin/gone is not there" in program(RIGHT, OWN.replace("rtol =", 'python = "bin/gone"\nrtol =')).missing


def test_an_environment_that_is_not_made_is_told_with_the_command_that_makes_it(program, tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environments"))
    registration = program(RIGHT, OWN.replace("rtol =", 'requirements = ["numpy==2.0.2"]\nrtol ='))
    assert registration.missing == f"its environment is not there; make it: {registration.remedy}"
    assert registration.remedy == "barchain engines --make mine"
    other = program(RIGHT, OWN.replace("rtol =", 'requirements = ["numpy==2.0.1"]\nrtol ='))
    assert other.version != registration.version, "packages decide results"


@pytest.mark.exhaustive
def test_a_program_with_another_numpy_runs_beside_the_engines_of_this_one(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environments"))
    write_program("start", "python-program", tmp_path / "start")
    entry = tmp_path / "start" / "engines.toml"
    text = entry.read_text().replace('["numpy"]', '["numpy==2.0.2"]')
    entry.write_text(f"{text}version = \"{{python}} -c 'import numpy; print(numpy.__version__)'\"\n")
    monkeypatch.setenv(FILES, str(entry))
    made = CliRunner().invoke(cli, ["engines", "--make", "start"])
    assert made.exit_code == 0, made.output
    assert find_engine("start").version_words == "2.0.2"
    assert np.__version__ != "2.0.2"
    found = barchain.compare(["basics/two_bars_free"], ["start", "reference"], tmp_path / "out")
    assert found.passed, found.metrics[found.metrics.reason.notna()][["quantity", "reason"]]
    assert read_record(tmp_path / "out")["engines"]["start"]["version"] == "2.0.2"
    entry.write_text(text.replace("2.0.2", "0.0.99"))
    refused = CliRunner().invoke(cli, ["engines", "--make", "start"])
    assert refused.exit_code == 2
    assert "0.0.99" in refused.output


def start_of(language, folder, monkeypatch):
    """Write and build the start in a language; in Python, it runs with the packages that are here."""
    of = LANGUAGES[language]
    tool = (of.build or of.runner).split()[0]
    if tool != "{python}" and shutil.which(tool) is None:
        pytest.skip(f"{tool} is not here")
    write_program("start", language, folder)
    if of.build:
        subprocess.run(of.build, shell=True, cwd=folder, check=True)
    entry = folder / "engines.toml"
    lines = entry.read_text().splitlines(keepends=True)
    entry.write_text("".join(line for line in lines if not line.startswith("requirements")))
    monkeypatch.setenv(FILES, str(entry))
    return len((folder / of.source).read_text().splitlines())


def test_the_command_line_offers_every_language():
    assert ("python", *LANGUAGES) == OFFERED


@pytest.mark.slow
@pytest.mark.parametrize("language", slow_but(LANGUAGES, ["c", "python-program"]))
def test_the_start_in_each_language_is_short_and_passes(tmp_path, monkeypatch, language):
    assert start_of(language, tmp_path / "start", monkeypatch) < 150
    found = barchain.compare(["basics/two_bars_free"], ["start"], tmp_path / "out")
    assert found.passed, found.metrics[found.metrics.reason.notna()][["quantity", "reason"]]


@pytest.mark.exhaustive
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_start_in_each_language_conforms(tmp_path, monkeypatch, language):
    start_of(language, tmp_path / "start", monkeypatch)
    report = conform("start")
    assert report.passed, [check.words for check in report.failures]


def test_an_option_names_a_file_of_programs_and_one_with_a_fault_is_bad_input(tmp_path):
    (tmp_path / "engines.toml").write_text('[[engine]]\nname = "a"\ncomand = "x"\n')
    found = CliRunner().invoke(cli, ["engines", "--engines", str(tmp_path / "engines.toml")])
    assert isinstance(found.exception, EntryError)
    assert "did you mean command?" in str(found.exception)


def test_a_changed_program_makes_its_runs_anew_and_is_a_part_of_nights(program):
    registration = program(RIGHT)
    call = outside_call(questions.run, Job(SCENE, "mine", registration, Setting("rtol", 1e-10), Role.MAIN), 60.0)
    key, (part,) = answer_key(call), [p for p in parts_here() if p.name.startswith("program:")]
    assert part.name == "program:mine (its entry, program.py)"
    assert part.name in depends_on("basics/two_bars_free", "mine", FigureKind.ERROR)
    folder, _ = unpacked(registration.entry)
    (folder / "program.py").write_text(RIGHT + "\n")
    assert answer_key(call) != key
    assert [p.digest for p in parts_here() if p.name == part.name] != [part.digest]


def parts_here():
    """Parts of a night with the program alone."""
    return installed_parts(["mine"], ["basics/two_bars_free"], capture())
