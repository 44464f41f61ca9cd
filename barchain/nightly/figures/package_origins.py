"""Where an installed distribution came from: an index, a repository, a file; and how its state is installed again."""

from __future__ import annotations

import os
import re
from functools import cache
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from barchain.nightly.figures.figure import MOST_TEXT
from barchain.record.environment import package_version
from barchain.record.sources import direct_url, installed_commit
from barchain.runs.environment import OWN_PYTHON
from barchain.runs.processes import GitError, git, run

CONFIG_S = 30.0
AT = " @ "
"""Stands between the version and the address of a distribution that no index has"""
UNCOMMITTED = "(not committed)"
"""End of the version of a distribution whose sources differ from every commit"""
COMMIT = re.compile(r"^(git\+.+)@([0-9a-f]{7,64})(#subdirectory=(.+))?$")


def installed_state(distribution: str) -> str:
    """Version of an installed distribution; of one that no index has with its address, so that it is known again.

    ``3.2.7``, ``0.1.0 @ git+https://example.org/engine@0123abcd``, or ``0.1.0 (not committed)``.
    """
    version, found = package_version(distribution), direct_url(distribution)
    if not found:
        return version
    state = f"{version}{AT}{address}" if (address := origin(distribution)) else f"{version} {UNCOMMITTED}"
    return state if len(state) <= MOST_TEXT else version


def origin(distribution: str) -> str:
    """Address of the files of a distribution that pip did not take from an index; empty of sources in no commit."""
    found = direct_url(distribution)
    url, inside = str(found.get("url") or ""), str(found.get("subdirectory") or "")
    if commit := installed_commit(distribution):
        return f"git+{url}@{commit}{f'#subdirectory={inside}' if inside else ''}"
    if "dir_info" in found and url.startswith("file:"):
        return committed(Path(url2pathname(urlsplit(url).path)))
    return url


def committed(folder: Path) -> str:
    """Address of a folder in the last commit of its repository; empty if there is none, or a file differs from it."""
    try:
        top = Path(git(folder, "rev-parse", "--show-toplevel").decode().strip())
        commit = git(folder, "rev-parse", "HEAD").decode().strip()
        changed = git(folder, "status", "--porcelain", "--untracked-files=no", "--", ".")
    except GitError:
        return ""
    inside = folder.resolve().relative_to(top.resolve()).as_posix()
    tail = "" if inside == "." else f"#subdirectory={inside}"
    return "" if changed else f"git+{top.as_uri()}@{commit}{tail}"


def requirement_of(distribution: str, state: str) -> str:
    """Requirement of a state as :func:`installed_state` gives it."""
    version, _, address = state.partition(AT)
    return f"{distribution}{AT}{address}" if address else f"{distribution}=={version}"


def can_be_installed(state: str) -> bool:
    """Whether a state can be installed again."""
    return bool(state) and not state.endswith(UNCOMMITTED)


def state_words(state: str) -> str:
    """State in a word: its version, or the first digits of its commit."""
    found = COMMIT.match(state.partition(AT)[2])
    return found[2][:12] if found else state


def states_between(before: str, after: str, scratch: Path) -> list[str] | None:
    """States of all commits between those of two states, both among them; None if they are no commits of one address.

    Raises
    ------
    GitError
        If the repository can't be had.
    """
    version, _, address = before.partition(AT)
    first, last = COMMIT.match(address), COMMIT.match(after.partition(AT)[2])
    if first is None or last is None or (first[1], first[4]) != (last[1], last[4]):
        return None
    git(scratch, "clone", "--quiet", "--bare", first[1].removeprefix("git+"), "repository")
    paths = ("--", first[4]) if first[4] else ()

    def between(old: str, new: str) -> list[str]:
        return git(scratch / "repository", "rev-list", "--reverse", f"{old}..{new}", *paths).decode().split()

    found = [first[2], *between(first[2], last[2])]
    if len(found) == 1:  # the good night has the later commit
        found = [last[2], *between(last[2], first[2])][::-1]
    return [f"{version}{AT}{first[1]}@{commit}{first[3] or ''}" for commit in found]


@cache
def pip_setting(name: str) -> str:
    """Setting of pip, as it is configured here; empty without."""
    done = run([*OWN_PYTHON, "-m", "pip", "config", "get", f"global.{name}"], limit_s=CONFIG_S)
    return "" if done.reason else done.output.strip()


@cache
def wheel_folders() -> tuple[Path, ...]:
    """Folders of wheels that pip is configured to look into, beside the index."""
    given = " ".join(os.environ.get(name, "") for name in ("PIP_FIND_LINKS", "UV_FIND_LINKS")).replace(",", " ")
    given = given.strip() or pip_setting("find-links")
    paths = (Path(url2pathname(urlsplit(w).path)) if w.startswith("file:") else Path(w) for w in given.split())
    return tuple(path.resolve() for path in paths if path.is_dir())
