"""Recipes for CI agree with the schemas of GitHub and GitLab, and name options that there are."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from barchain.cli.main import cli

ROOT = Path(__file__).parents[2]
RECIPES = ROOT / "docs" / "recipes"
GITHUB, GITLAB, CRON = (RECIPES / name for name in ("github-nightly.yml", "gitlab-nightly.yml", "crontab"))


@pytest.mark.parametrize(
    ("file", "options"),
    [
        (GITHUB, ["--builtin-schema", "vendor.github-workflows"]),
        (GITLAB, ["--builtin-schema", "vendor.gitlab-ci", "--data-transform", "gitlab-ci"]),
    ],
)
def test_a_recipe_agrees_with_the_schema_of_its_service(file: Path, options: list[str]) -> None:
    line = [sys.executable, "-m", "check_jsonschema", *options, str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("actionlint") is None, reason="actionlint is a program in Go; see CONTRIBUTING.md")
def test_actionlint_finds_nothing_in_the_workflow() -> None:
    done = subprocess.run(["actionlint", str(GITHUB)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_projects_own_workflow_is_the_recipe() -> None:
    assert (ROOT / ".github" / "workflows" / "nightly.yml").read_bytes() == GITHUB.read_bytes()


@pytest.mark.parametrize("file", [GITHUB, GITLAB, CRON])
def test_every_option_of_a_recipe_is_one_of_the_command(file: Path) -> None:
    line = next(each for each in file.read_text("utf-8").splitlines() if re.search(r"barchain (-q )?nightly ", each))
    known = CliRunner().invoke(cli, ["nightly", "--help"]).output
    for option in re.findall(r"(--[a-z-]+)", line.partition("nightly")[2]):
        assert option in known
