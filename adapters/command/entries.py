"""Entries of engines that are commands: the files that name them, and what each entry declares."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import platformdirs
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, field_validator, model_validator

from adapters.command.own_python import READY, environment_of, python_in, without_own
from adapters.common.step_alignment import misalignment
from adapters.engine import (
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Declarations,
    StatedAnswers,
    lacking_effects,
)
from adapters.trajectory import Observable
from scenarios.channels import NOISE  # noqa: TC001  # pydantic reads the annotation
from scenarios.effect_types import all_effect_names
from scenarios.named_file import UnreadableError
from scenarios.nearest import nearest
from scenarios.size_limits import LimitError
from scenarios.text import shorten
from scenarios.toml.faults import fault_lines
from scenarios.toml.reading import read_text, tables_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenarios import Scene

FILES = "BARCHAIN_ENGINES"
"""Variable that names further files with entries; the option ``--engines`` sets it for a command and its processes"""
FILE = "engines.toml"
"""Name of the file that is read in the working folder, and in the user's folder of settings"""
OURS = tuple(Path(__file__).parents[1] / name / FILE for name in ("basilisk", "jaxsim"))
"""Files of engines of barchain's that have an environment of their own"""
REQUEST, SAMPLES, RESULT = "{request}", "{samples}", "{result}"
PYTHON = "{python}"
DIGITS = 16
MOST_VERSION = 80
"""Characters of a version"""
VERSION_S = 10.0
"""Longest run of a command that prints a version, s"""
PACKAGE = r"[A-Za-z0-9][A-Za-z0-9._-]*\s*($|[\[=<>!~;@(])"
"""Beginning of a requirement"""
MOST_FILES = 64
"""Files of entries that are remembered"""
OWN_CLOCK = "own_clock_s"
"""Key in a trajectory's `info` of the run time by the program's own clock, s"""


class EntryError(ValueError):
    """A file of engines that can't be read, or an entry with a fault; one line for each fault."""


@dataclass(frozen=True)
class EntryAnswers(StatedAnswers):
    """Answers by what an entry states of a program of equal steps."""

    effects: tuple[str, ...] = ()

    def unsupported(self, scene: Scene, /) -> str | None:
        """Reason why the program does not support a scene: an effect, or an event within a step."""
        return lacking_effects(scene, self.effects, {}) or misalignment(scene)


class Entry(BaseModel):
    """One engine: its command, and its declarations."""

    model_config = ConfigDict(extra="forbid")

    name: str = Field(description="name of the engine", pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,59}$")
    command: str = Field(
        description="command line; {request} stands for the file to read, {samples} for the CSV to write, and {result} "
        "for the JSON to write: one of the two, or both; {python} for the entry's Python",
        min_length=1,
    )
    python: str = Field("", description="Python that {python} stands for: a path, from the file of entries on")
    requirements: list[str] = Field(
        default_factory=list,
        description="packages of an environment of the program's own, whose Python {python} stands for",
    )
    title: str = Field("", description="one line for tables and reports")
    effects: list[str] = Field(description="effects that the program supports exactly: gravity.point, drag, ...")
    observables: list[Observable] = Field(
        default_factory=lambda: [Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION],
        description="quantities that every table of samples holds",
    )
    coordinates: Coordinates = Field(
        Coordinates.ABSOLUTE, description="coordinates that the program integrates; they decide its round-off"
    )
    order: float | None = Field(None, ge=1, le=40, description="order of a method of equal steps")
    steps_per_orbit: list[PositiveFloat] | None = Field(
        None, min_length=1, description="settings from coarse to fine, of a method of equal steps"
    )
    rtol: list[PositiveFloat] | None = Field(
        None, min_length=1, description="settings from coarse to fine, of a method that controls its step"
    )
    default: PositiveFloat | None = Field(None, description="setting of comparisons; the middle one by default")
    step_constant: float = Field(
        1.0, gt=0, le=10, description="largest error of one step relative to the requested one, with rtol"
    )
    joints_in_place: bool = Field(False, description="whether every step closes the joints at position level")
    noise: dict[Literal[NOISE], Annotated[float, Field(ge=0, allow_inf_nan=False)]] = Field(  # type: ignore[valid-type]
        default_factory=dict, description="errors that do not fall with the step, by quantity, in SI units"
    )
    files: list[str] = Field(
        default_factory=list,
        description="files that the results depend on, from the file of entries on: the program, its data",
    )
    version: str = Field(
        "", description="version of the program: a word, or a command line whose first line of output it is"
    )
    commit: str = Field(
        "", description="commit of the program's sources: a word, or a command line whose first line of output it is"
    )
    licence: str = Field("", description="licence of the program")
    homepage: str = Field("", description="address of the program")

    @field_validator("command")
    @classmethod
    def names_files(cls, command: str) -> str:
        """Check that the program is told what to read and what to write."""
        try:
            shlex.split(command)
        except ValueError:
            raise ValueError("allowed: a command line whose quotation marks and backslashes are closed") from None
        known = (REQUEST, SAMPLES, RESULT, PYTHON)
        unknown = [name for name in re.findall(r"\{\w*\}", command) if name not in known]
        if unknown:
            raise ValueError(f"{unknown[0]} stands for nothing; allowed: {', '.join(known)}")
        if REQUEST not in command:
            raise ValueError(f"allowed: a command line with {REQUEST} in it")
        if SAMPLES not in command and RESULT not in command:
            raise ValueError(f"allowed: a command line with {SAMPLES} or {RESULT} in it, or both")
        return command

    @field_validator("version", "commit")
    @classmethod
    def one_line(cls, text: str) -> str:
        """Check that a version is a word, or a command line."""
        try:
            shlex.split(text)
        except ValueError:
            raise ValueError("allowed: a word, or a command line whose quotation marks are closed") from None
        if not text.isprintable():
            raise ValueError("allowed: one line of printable characters")
        return text

    @field_validator("effects")
    @classmethod
    def known_effects(cls, effects: list[str]) -> list[str]:
        """Check the names of effects."""
        known = sorted(all_effect_names())
        for name in effects:
            if name not in known:
                raise ValueError(f"{name}: no such effect{nearest(name, known)}; allowed: {', '.join(known)}")
        return effects

    @field_validator("requirements")
    @classmethod
    def packages(cls, requirements: list[str]) -> list[str]:
        """Check that requirements are packages, and no options of an installer."""
        for text in requirements:
            if not re.match(PACKAGE, text) or not text.isprintable():
                raise ValueError(f"{shorten(text)} given, allowed: a requirement such as numpy==2.0.2")
        return requirements

    @model_validator(mode="after")
    def one_python(self) -> Entry:
        """Check that a Python is given once, and used."""
        if self.python and self.requirements:
            raise ValueError("python and requirements given, allowed: one of them")
        if (self.python or self.requirements) and PYTHON not in self.command:
            raise ValueError(f"{'python' if self.python else 'requirements'}: allowed with {PYTHON} in the command")
        return self

    @model_validator(mode="after")
    def one_kind_of_setting(self) -> Entry:
        """Check that settings are of one kind and in order, and that an order comes with equal steps."""
        if (self.steps_per_orbit is None) == (self.rtol is None):
            raise ValueError("give exactly one of steps_per_orbit, rtol: settings from coarse to fine")
        if (self.order is None) != (self.steps_per_orbit is None):
            raise ValueError("order: allowed with steps_per_orbit, and needed there")
        values = self.values
        if list(values) != sorted(set(values), reverse=self.rtol is not None):
            raise ValueError(f"{self.parameter}: allowed: values from coarse to fine, none twice")
        return self

    @model_validator(mode="after")
    def default_is_a_setting(self) -> Entry:
        """Check that the default is one of the settings."""
        if self.default is not None and self.default not in self.values:
            raise ValueError(f"default = {self.default:g} given, allowed: {', '.join(f'{v:g}' for v in self.values)}")
        return self

    @property
    def parameter(self) -> AccuracyParameter:
        """The number that sets the accuracy."""
        return AccuracyParameter.RTOL if self.steps_per_orbit is None else AccuracyParameter.STEPS_PER_ORBIT

    @property
    def values(self) -> tuple[float, ...]:
        """Settings from coarse to fine."""
        return tuple(self.steps_per_orbit or self.rtol or ())

    @property
    def declarations(self) -> Declarations:
        """What the entry declares."""
        middle, effects = self.values[len(self.values) // 2], tuple(sorted(self.effects))
        answered = {"unsupported": self.order is not None, "noise": bool(self.noise)}
        return Declarations(
            title=self.title or f"{self.name}, a program",
            coordinates=self.coordinates,
            order=self.order,
            sweep=AccuracySweep(self.parameter, self.values, self.default or middle),
            effects=effects,
            observables=tuple(sorted(self.observables)),
            joints_in_place=self.joints_in_place,
            step_constant=self.step_constant,
            questions=tuple(question for question, own in answered.items() if own),
            answers=EntryAnswers(dict(self.noise), effects),
        )


class EngineFile(BaseModel):
    """A file of engines."""

    model_config = ConfigDict(extra="forbid")

    engine: list[Entry] = Field(default_factory=list, description="one engine each")


def entry_files() -> list[Path]:
    """Files with entries, the more particular first: those of the variable, the working folder's, the user's, ours."""
    named = [Path(each) for each in os.environ.get(FILES, "").split(os.pathsep) if each]
    usual = (Path(FILE), platformdirs.user_config_path("barchain") / FILE)
    return [*named, *(path for path in usual if path.is_file()), *OURS]


def lies_here(path: Path) -> bool:
    """Whether a file of :func:`entry_files` is the working folder's, which nobody has named."""
    return path == Path(FILE)


def found_entries() -> Iterator[tuple[Path, Entry]]:
    """Files and entries of all files; of a name that stands in several the first.

    Raises
    ------
    EntryError
        If a file can't be read, or an entry has a fault.
    """
    seen = set()
    for path in entry_files():
        for entry in read_entries(path):
            if entry.name not in seen:
                seen.add(entry.name)
                yield path, entry


def read_entries(path: Path) -> list[Entry]:
    """Entries of a file; one that has not changed is read once.

    Raises
    ------
    EntryError
        If it can't be read, an entry has a fault, or two have one name.
    """
    try:
        state = path.stat()
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}") from None
    return list(entries_in(path.resolve(), str(path), (state.st_ino, state.st_size, state.st_mtime_ns)))


@functools.lru_cache(MOST_FILES)
def entries_in(path: Path, name: str, state: tuple[int, ...]) -> tuple[Entry, ...]:
    """Entries of a file in a state, which is told by its `name`; errors as of :func:`read_entries`."""
    del state
    try:
        found = EngineFile.model_validate(tables_of(read_text(path))).engine
    except (LimitError, UnreadableError) as error:
        raise EntryError(f"{name}: {error}") from None
    except ValidationError as error:
        raise EntryError("\n".join(f"{name}: {line}" for line in fault_lines(error, EngineFile))) from None
    names = [entry.name for entry in found]
    twice = next((each for each in names if names.count(each) > 1), None)
    if twice:
        raise EntryError(f"{name}: two engines are called {twice}, allowed: each name once")
    return tuple(found)


def packed(folder: Path, entry: Entry) -> str:
    """Entry and folder as text, which a registration carries to other processes."""
    return json.dumps({"folder": str(folder), "entry": entry.model_dump(mode="json")}, sort_keys=True)


def unpacked(text: str) -> tuple[Path, Entry]:
    """Folder and entry of a registration's text."""
    found: dict[str, Any] = json.loads(text)
    return Path(found["folder"]), Entry.model_validate(found["entry"])


def arguments(folder: Path, entry: Entry, files: Mapping[str, Path]) -> list[str]:
    """Command line of a run.

    Parameters
    ----------
    folder : Path
        Folder of the file of entries; a word that names a file in it stands for that file.
    entry : Entry
    files : mapping of str to Path
        Files of the run by the names that stand for them.
    """
    found, meant = [], {PYTHON: python_path(folder, entry), **files}
    for word in shlex.split(entry.command):
        filled = word
        for name, path in meant.items():
            filled = filled.replace(name, str(path))
        found.append(str(folder / filled) if (folder / filled).is_file() else filled)
    return found


def python_path(folder: Path, entry: Entry) -> Path:
    """Python of an entry: its own, that of its environment, or else the one that runs barchain."""
    if entry.requirements:
        return python_in(environment_of(entry.requirements))
    return folder / entry.python if entry.python else Path(sys.executable)


def variables(entry: Entry) -> dict[str, str]:
    """Variables of a program's process; a Python gets none that would lead it to the packages of this one."""
    return without_own(os.environ) if PYTHON in entry.command else dict(os.environ)


def why_not_there(folder: Path, entry: Entry) -> str:
    """Reason why a program can't be started; empty if it can."""
    if entry.requirements and not (environment_of(entry.requirements) / READY).is_file():
        return f"its environment is not there; make it: {remedy(entry)}"
    program, place = arguments(folder, entry, {})[0], os.path.relpath(folder / FILE)
    if shutil.which(program) is None:
        program = os.path.relpath(program) if Path(program).is_absolute() else program
        return f"{program} is not there, or is no program; its entry is in {place}"
    lacking = next((name for name in entry.files if not (folder / name).is_file()), "")
    return f"{lacking}, one of its files, is not there; its entry is in {place}" if lacking else ""


def remedy(entry: Entry) -> str:
    """Command that makes what is missing of a program; empty where none does."""
    return f"barchain engines --make {entry.name}" if entry.requirements else ""


def version_words(folder: Path, entry: Entry) -> str:
    """Version and commit of a program in words; a command that prints one is run."""
    version, commit = (stated(folder, entry, text) for text in (entry.version, entry.commit))
    version = version.removeprefix(f"{entry.name} ")  # many programs print their name before it
    return f"{version} ({commit})" if version and commit else version or commit


def stated(folder: Path, entry: Entry, text: str) -> str:
    """Version or commit that an entry states: the word itself, or the first line that a command prints.

    Several words are a command line, and so is the name of a file beside the entry. One that can't be run, or prints
    nothing, gives no version: a night is measured all the same.
    """
    if len(shlex.split(text)) < 2 and not (text and (folder / text).is_file()):
        return text[:MOST_VERSION]
    line = arguments(folder, entry.model_copy(update={"command": text}), {})
    try:
        done = subprocess.run(
            line, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=VERSION_S, check=True,
            env=variables(entry),
        )  # fmt: skip
    except (OSError, ValueError, subprocess.SubprocessError):
        return ""
    return next((shown for shown in map(str.strip, done.stdout.splitlines()) if shown), "")[:MOST_VERSION]


def deciding_files(folder: Path, entry: Entry) -> list[str]:
    """Files that decide results: those that an entry declares, and those that its command names beside it."""
    words = (word for word in shlex.split(entry.command) if not Path(word).is_absolute())
    return sorted({*entry.files, *(word for word in words if (folder / word).is_file())})


def content_digest(folder: Path, entry: Entry) -> str:
    """Digest of an entry and of its deciding files; a file that is missing counts as that.

    A version and a commit are names of a state, and part of none.
    """
    declared = entry.model_dump(mode="json", exclude={"version", "commit"})
    found = hashlib.sha256(json.dumps({"folder": ".", "entry": declared}, sort_keys=True).encode())
    for name in deciding_files(folder, entry):
        path = folder / name
        found.update(name.encode() + b"\0" + (hashlib.sha256(path.read_bytes()).digest() if path.is_file() else b"-"))
    return found.hexdigest()[:DIGITS]
