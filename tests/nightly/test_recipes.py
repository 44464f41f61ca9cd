"""Recipes agree with the schemas of their services, name options that there are, and pass on exit codes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

from barchain.cli.main import cli
from tests.support.machine import needs

ROOT = Path(__file__).parents[2]
RECIPES = ROOT / "docs" / "recipes"
GITHUB, GITLAB, SCRIPT, SERVICE, TIMER = (
    RECIPES / name
    for name in (
        "github-nightly.yml", "gitlab-nightly.yml", "nightly.sh", "barchain-nightly.service", "barchain-nightly.timer",
    )
)  # fmt: skip
GITHUB_GATE, GITLAB_GATE = RECIPES / "github-gate.yml", RECIPES / "gitlab-gate.yml"
COMMAND = re.compile(r"^[^#]*?\bbarchain (?:-q )?(nightly|gate|history \w+) ([^|&;\n]*)", re.MULTILINE)
INPUTS = {"CHANGE": "*:exudyn:*", "REASON": "$(touch injected)", "UNTIL": "2031-01-02", "LOGNAME": "someone"}
needs_flock = needs("flock", there=shutil.which("flock") is not None)


def yaml(file: Path) -> Any:
    return YAML(typ="safe").load(file.read_text("utf-8"))


def github_steps(file: Path = GITHUB) -> dict[str, dict[str, Any]]:
    job = next(iter(yaml(file)["jobs"].values()))
    return {step.get("name", step.get("uses")): step for step in job["steps"]}


def shell_parts() -> dict[str, str]:
    """Shell text of all recipes, by place; GitLab joins before_script and script."""
    gitlab = yaml(GITLAB)
    before = "\n".join(gitlab[".barchain"]["before_script"])
    return (
        {
            name: step["run"]
            for file in (GITHUB, GITHUB_GATE)
            for name, step in github_steps(file).items()
            if "run" in step
        }
        | {job: "\n".join([before, *gitlab[job]["script"]]) for job in ("nightly", "accept")}
        | {"gate": "\n".join(yaml(GITLAB_GATE)["gate"]["script"])}
        | {"after nightly": "\n".join(gitlab["nightly"]["after_script"]), "nightly.sh": SCRIPT.read_text("utf-8")}
    )


def play(
    text: str, folder: Path, given: dict[str, str] | None = None, code: int = 0
) -> subprocess.CompletedProcess[str]:
    """Run shell text as a CI does, with a `barchain` that writes down its arguments; others print theirs."""
    programs = folder / "bin"
    programs.mkdir(exist_ok=True)
    for name, body in {
        "barchain": f'[ "$1" = history ] || code={code}\necho "$LOGNAME:$*" >> said\nexit ${{code:-0}}',
        "pip": 'echo "pip $*"\n[ "$1" != wheel ] || { mkdir -p "$4"; touch "$4/mine-1-py3-none-any.whl"; }',
        "git": 'echo "git $*"',
        "gh": 'echo "gh $*"',
        "curl": 'echo "curl $*"',
    }.items():
        (programs / name).write_text(f"#!/bin/sh\n{body}\n", "utf-8")
        (programs / name).chmod(0o755)
    known = {"PATH": f"{programs}:{os.environ['PATH']}", "GITHUB_ENV": str(folder / "kept.env"), "BARCHAIN": "barchain",
             "FAIL_ON": "changed"}  # fmt: skip
    line = ["bash", "-e", "-o", "pipefail", "-c", text]
    return subprocess.run(line, cwd=folder, env=known | (given or {}), capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("file", "options"),
    [
        (GITHUB, ["--builtin-schema", "vendor.github-workflows"]),
        (GITHUB_GATE, ["--builtin-schema", "vendor.github-workflows"]),
        (GITLAB, ["--builtin-schema", "vendor.gitlab-ci", "--data-transform", "gitlab-ci"]),
        (GITLAB_GATE, ["--builtin-schema", "vendor.gitlab-ci", "--data-transform", "gitlab-ci"]),
    ],
)
def test_a_recipe_agrees_with_the_schema_of_its_service(file: Path, options: list[str]) -> None:
    line = [sys.executable, "-m", "check_jsonschema", *options, str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("actionlint") is None, reason="actionlint is a program in Go; see CONTRIBUTING.md")
def test_actionlint_finds_nothing_in_the_workflow() -> None:
    done = subprocess.run(["actionlint", str(GITHUB), str(GITHUB_GATE)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_finds_nothing_in_the_units(tmp_path: Path) -> None:
    for file in (SERVICE, TIMER):
        text = file.read_text("utf-8").replace("/srv/barchain/bin/barchain", "/bin/true")
        (tmp_path / file.name).write_text(text, "utf-8")
    line = ["systemd-analyze", "verify", *(str(tmp_path / file.name) for file in (SERVICE, TIMER))]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("file", [GITHUB, GITLAB, SCRIPT, SERVICE, GITHUB_GATE, GITLAB_GATE])
def test_every_command_of_a_recipe_has_the_options_that_it_names(file: Path) -> None:
    commands = COMMAND.findall(file.read_text("utf-8"))
    assert commands
    for command, rest in commands:
        known = CliRunner().invoke(cli, [*command.split(), "--help"])
        assert known.exit_code == 0, command
        for option in re.findall(r"(--[a-z-]+)", rest):
            assert option in known.output


@pytest.mark.parametrize("place", shell_parts())
def test_the_shell_of_a_recipe_has_no_fault_of_syntax_and_no_expression(place: str) -> None:
    text = shell_parts()[place]
    done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "${{" not in text, "an expression in shell text lets inputs run commands"


@pytest.mark.parametrize("place", ["Run the night", "nightly"])
@pytest.mark.parametrize("code", [0, 1, 3])
def test_a_night_passes_its_exit_code_on_and_its_service_takes_3_for_a_warning(
    tmp_path: Path, place: str, code: int
) -> None:
    done = play(shell_parts()[place], tmp_path, {"PLAN": "my plan.toml"}, code)
    github = place == "Run the night"
    assert done.returncode == (0 if github and code == 3 else code)
    assert ("::warning::" in done.stdout) == (github and code == 3)
    assert yaml(GITLAB)["nightly"]["allow_failure"] == {"exit_codes": [3]}
    said = (tmp_path / "said").read_text("utf-8")
    assert ":nightly --plan my plan.toml --out nights --require-history --fail-on changed\n" in said
    assert "history prune" in said


@pytest.mark.parametrize("place", ["Install", "nightly"])
def test_programs_are_built_before_the_night_and_a_failed_build_ends_it(tmp_path: Path, place: str) -> None:
    assert play(shell_parts()[place], tmp_path, {"BUILD": "touch engine"}).returncode == 0
    assert (tmp_path / "engine").exists()
    assert play(shell_parts()[place], tmp_path, {"BUILD": "false"}).returncode == 2


@pytest.mark.parametrize("place", ["Tell a chat", "after nightly"])
def test_a_chat_gets_the_night_in_a_few_lines_if_its_address_is_known(tmp_path: Path, place: str) -> None:
    (tmp_path / "nights").mkdir()
    (tmp_path / "nights" / "nightly.json").write_text("{}", "utf-8")
    known = {"LINK": "https://example.org/1", "CI_JOB_URL": "https://example.org/1"}
    assert play(shell_parts()[place], tmp_path, known).stdout == ""
    done = play(shell_parts()[place], tmp_path, known | {"CHAT": "https://chat.example.org/hook"})
    assert done.stdout.endswith(" --data-binary @- https://chat.example.org/hook\n")
    assert (tmp_path / "said").read_text("utf-8") == ":history tell --link https://example.org/1\n"


def test_both_recipes_keep_the_history_and_publish_the_results_page_after_a_night_that_failed_too(
    tmp_path: Path,
) -> None:
    github, gitlab = yaml(GITHUB)["jobs"], yaml(GITLAB)
    paths = {github_steps()[name]["with"]["path"] for name in ("Restore the history", "Keep the history")}
    assert paths == {github["nightly"]["env"]["BARCHAIN_HISTORY"]} == {"history"}
    before = gitlab[".barchain"]
    assert (before["variables"]["BARCHAIN_HISTORY"], before["cache"]["paths"]) == ("history", ["history/"])
    assert github_steps()["Hand it to the job that publishes it"]["with"]["path"] == "site"
    assert "history site --out site" in shell_parts()["Write the results page"]
    assert github["pages"]["if"].startswith("always() && vars.PAGES")
    assert "id-token" not in str(github["nightly"]) + str(yaml(GITHUB)["permissions"])
    assert play(shell_parts()["nightly"], tmp_path, code=1).returncode == 1
    assert ":history site --out public --days 14\n" in (tmp_path / "said").read_text("utf-8")
    assert gitlab["pages"]["artifacts"]["paths"][0] in gitlab["nightly"]["artifacts"]["paths"]
    assert gitlab["pages"]["rules"][-1]["when"] == "always"


@pytest.mark.parametrize(
    ("place", "given"),
    [("Accept a change", {"GITHUB_REF_NAME": "main", "BRANCH": "main"}), ("accept", {"GITLAB_USER_LOGIN": "someone"})],
)
def test_a_change_is_accepted_with_inputs_that_no_shell_reads(
    tmp_path: Path, place: str, given: dict[str, str]
) -> None:
    if "BRANCH" in given:  # GitHub offers the button on every branch
        elsewhere = play(shell_parts()[place], tmp_path, INPUTS | given | {"GITHUB_REF_NAME": "mine"})
        assert (elsewhere.returncode, (tmp_path / "said").exists()) == (2, False)
    done = play(shell_parts()[place], tmp_path, INPUTS | given)
    assert done.returncode == 0, done.stderr
    said = (tmp_path / "said").read_text("utf-8")
    assert said == "someone:history accept --reason $(touch injected) --until 2031-01-02 -- *:exudyn:*\n"
    assert not (tmp_path / "injected").exists()


WHEEL = "mine-1-py3-none-any.whl"
GATE = f"mine --base wheels/base/{WHEEL} --head wheels/head/{WHEEL} --minutes 5 --out gate.md"
REQUEST = {
    "ENGINE": "mine", "CI_MERGE_REQUEST_DIFF_BASE_SHA": "0123abcd", "CI_API_V4_URL": "https://example.org/api/v4",
    "CI_PROJECT_ID": "7", "CI_MERGE_REQUEST_IID": "3", "GITHUB_REPOSITORY": "you/mine", "PULL": "3",
}  # fmt: skip


@pytest.mark.parametrize("code", [0, 1, 2])
@pytest.mark.parametrize("place", ["Run the gate", "gate"])
def test_a_gate_compares_wheels_of_base_and_head_and_passes_its_exit_code_on(
    tmp_path: Path, place: str, code: int
) -> None:
    gitlab, built = place == "gate", "gate" if place == "gate" else "Build both wheels"
    (tmp_path / "gate.md").write_text("the answer", "utf-8")
    done = play(shell_parts()[built], tmp_path, REQUEST | {"GATE_TOKEN": "secret"}, code if gitlab else 0)
    assert f"git worktree add ../base {'0123abcd' if gitlab else 'HEAD^1'}\n" in done.stdout
    assert "pip wheel --no-deps --wheel-dir wheels/base ../base" in done.stdout
    again = play(shell_parts()[place], tmp_path, REQUEST, code)
    assert again.returncode == code
    assert (tmp_path / "said").read_text("utf-8").endswith(f":gate {GATE}\n")
    if gitlab:  # comments if it has a token
        assert "body@gate.md https://example.org/api/v4/projects/7/merge_requests/3/notes" in done.stdout
        assert "curl" not in again.stdout


def test_the_github_gate_replaces_its_last_comment(tmp_path: Path) -> None:
    done = play(shell_parts()["Write the comment"], tmp_path, REQUEST)
    assert done.stdout == "gh pr comment 3 --repo you/mine --edit-last --create-if-none --body-file gate.md\n"
    assert github_steps(GITHUB_GATE)["actions/checkout@v7"]["with"]["persist-credentials"] is False


@pytest.mark.parametrize("place", ["Install", "nightly", "accept", "Install the gate", "gate"])
def test_a_recipe_tells_in_one_sentence_what_is_not_set_or_installed(tmp_path: Path, place: str) -> None:
    text = shell_parts()[place]
    unset = [("BARCHAIN", {"BARCHAIN": ""})]
    unset += [("ENGINE", {})] if "gate" in place else []
    for variable, given in unset:
        done = play(text, tmp_path, given)
        assert done.returncode == 2
        assert done.stdout.strip().removeprefix("::error::").startswith(f"Set the variable {variable} to the ")
    own = play(
        text.replace("command -v barchain", "command -v no-such-barchain"),
        tmp_path,
        {"BARCHAIN": "-e .[all]", "ENGINE": "mine"},
    )
    assert own.returncode == 2
    assert "pip install -e .[all]\n" in own.stdout
    assert "The variable BARCHAIN (-e .[all]) does not install barchain." in own.stdout


@needs_flock
def test_the_script_of_cron_speaks_if_the_night_has_something_to_tell(tmp_path: Path) -> None:
    quiet, told = cron(tmp_path, "echo a result"), cron(tmp_path, "echo a result; exit 3")
    assert (quiet.returncode, quiet.stdout) == (0, "")
    assert (told.returncode, told.stdout) == (3, "The night ended with exit code 3.\na result\n")
    held = cron(tmp_path, "exit 0", "flock", "lock")
    assert (held.returncode, held.stdout) == (75, "The last night still runs: no night began.\n")


@needs_flock
def test_the_script_of_cron_requires_a_history_once_there_is_one_and_writes_its_results_page(tmp_path: Path) -> None:
    body = 'echo "$@" >> said; [ "$2" = nightly ] || exit 0; mkdir -p nights; {}; exit 1'
    assert cron(tmp_path, body.format("touch nights/nightly.json"), site="www").returncode == 1
    said = (tmp_path / "said").read_text("utf-8")
    assert "history site --out www\n" in said
    assert "--require-history" not in said
    cron(tmp_path, body.format("exit 1"))
    assert "--require-history" in (tmp_path / "said").read_text("utf-8")
    (tmp_path / "said").unlink()
    cron(tmp_path, body.format("echo no night began"), site="www")
    assert "history site" not in (tmp_path / "said").read_text("utf-8")


@pytest.mark.slow
@needs_flock
def test_the_script_of_cron_ends_a_night_that_hangs(tmp_path: Path) -> None:
    done = cron(tmp_path, "exec sleep 60", limit="1")
    assert done.returncode == 124
    assert done.stdout.startswith("The night was ended after 60 minutes.")


def cron(folder: Path, body: str, *under: str, limit: str = "60m", site: str = "") -> subprocess.CompletedProcess[str]:
    """Run the script in a folder, under some command, with a barchain of this body."""
    program, file = folder / "barchain", folder / "nightly.sh"
    program.write_text(f"#!/bin/sh\n{body}\n", "utf-8")
    program.chmod(0o755)
    text = SCRIPT.read_text("utf-8").replace("/srv/barchain/bin/barchain", str(program)).replace(" 60m ", f" {limit} ")
    text = text.replace("site= ", f"site={site} ")
    file.write_text(text.replace("/srv/nights ", f"{folder} "), "utf-8")
    return subprocess.run([*under, "sh", str(file)], cwd=folder, capture_output=True, text=True, check=False)
