"""Loading of a :class:`~scenarios.scene.Scene` by name or file, with errors that name the remedy."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from scenarios.named_file import UnreadableError
from scenarios.nearest import nearest_name, nearest_scene
from scenarios.size_limits import MOST_LINE, LimitError
from scenarios.text import is_scene_name, shorten, visible
from scenarios.toml.changing import current_tables, merged
from scenarios.toml.faults import fault_lines
from scenarios.toml.field_types import type_faults, with_plain_numbers, with_types_of, without_numpy
from scenarios.toml.file import SceneFile
from scenarios.toml.reading import read_text, tables_of
from scenarios.toml.resolve import IncompleteError, resolve
from scenarios.toml.start_table import need_met_laws, with_state

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenarios.scene import Scene

SHIPPED = Path(__file__).parent


class SceneError(ValueError):
    """Invalid or missing scene; the message names the file, the key, the given and the allowed values."""


def scene_names(folders: Sequence[Path] = (SHIPPED,)) -> list[str]:
    """Names of all scenes below `folders`, e.g. ``paper/fig05``, sorted."""
    return sorted(
        {p.relative_to(folder).with_suffix("").as_posix() for folder in folders for p in folder.rglob("*.toml")}
    )


def load_scene(scene: str | Path, folders: Sequence[Path] = (SHIPPED,)) -> Scene:
    """Load and validate a scene.

    Parameters
    ----------
    scene : str or Path
        The name of a scene below `folders` (``paper/fig05``), or the path of a TOML file.
    folders : sequence of Path, optional
        Folders that names are looked up in, first match wins; the shipped scenes by default.

    Returns
    -------
    Scene
        Complete and frozen, in SI units and radians.

    Raises
    ------
    SceneError
        If there is no such scene, or its file is not valid; the message has one line for each fault.
    """
    if not isinstance(scene, (str, Path)) or not str(scene):
        raise SceneError(
            f"{shorten(scene)} given as a scene, allowed: a name, e.g. paper/fig05, or the path of a TOML file"
        )
    path = Path(scene)
    try:
        if is_scene_name(str(scene)) and not path.suffix:  # a path could lead out of the folders, and of the results
            for named in (folder / f"{scene}.toml" for folder in folders):
                if named.is_file():
                    return load_file(named, name=str(scene), file=f"{scene}.toml")
        if path.is_file():
            return load_file(path, name=path.stem, file=visible(path))
        said = missing(path, folders)
    except OSError:  # no file has a name that the system does not take
        said = "no such scene; `barchain scenes` lists all scenes, or give a file's path"
    raise SceneError(f"{visible(scene, MOST_LINE)}: {said}")


def missing(path: Path, folders: Sequence[Path]) -> str:
    """Words on a scene that is not there, with the nearest one; reading a device or a pipe might not end."""
    if path.exists() and not path.is_dir():
        return "a device, a pipe or a socket; a scene is an ordinary file that ends with .toml"
    if path.is_dir():
        kind = "a folder" if path.suffix == ".toml" else "a folder without scenes"
        return f"{kind}; a scene is a file that ends with .toml"
    if path.suffix == ".toml":
        beside = [each.name for each in path.parent.glob("*.toml")]
        near = nearest_name(path.name, beside)
        return f"no such file{f' (did you mean {visible(path.with_name(near))}?)' if near else ''}"
    with_ending = path.with_name(f"{path.name}.toml") if path.name else path
    match = str(with_ending) if with_ending.is_file() else nearest_scene(str(path), scene_names(folders))
    meant = f" (did you mean {visible(match)}?)" if match else ""
    return f"no such scene{meant}; `barchain scenes` lists all scenes, or give a file's path"


def load_file(path: Path, *, name: str, file: str) -> Scene:
    """Scene of a file; error messages begin with `file`.

    Raises
    ------
    SceneError
        As :func:`load_scene`.
    """
    try:
        text = read_text(path)
    except (LimitError, UnreadableError) as error:
        raise SceneError(f"{file}: {error}") from None
    return parse_scene(text, name=name, file=file, folder=path.parent)


def parse_scene(text: str, *, name: str, file: str, folder: Path = Path()) -> Scene:
    """Validate the TOML `text` of a scene, whose paths are relative to `folder`; error messages begin with `file`.

    Raises
    ------
    SceneError
        As :func:`load_scene`.
    """
    try:
        return scene_of(tables_of(text), name, file, folder)
    except (LimitError, UnreadableError) as error:
        raise SceneError(f"{file}: {error}") from None


def make_scene(tables: Mapping[str, Any], name: str = "mine") -> Scene:
    """Make a scene from tables in Python: the keys, units and defaults of a scene file.

    Parameters
    ----------
    tables : mapping
        The file's tables, e.g. ``{"title": "Two bars", "source": "mine", "orbit": {"altitude_m": 5e5}, "chain": {...},
        "run": {"orbits": 1.0}}``. Arrays and numbers of NumPy stand for lists and numbers.
    name : str, optional
        Name of the scene in tables, folders and messages.

    Returns
    -------
    Scene
        Complete and frozen, in SI units and radians.

    Raises
    ------
    SceneError
        If a file with these tables would be rejected; the message has one line for each fault.
    """
    if not isinstance(tables, Mapping):
        raise SceneError(
            f"{shorten(tables)} given as a scene's tables, allowed: a mapping with the keys of a scene file"
        )
    return scene_of(without_numpy(tables), name, name)


def change_scene(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Change a scene by the keys of its file; what the file leaves out follows, such as a duration in orbits.

    Parameters
    ----------
    scene : Scene
    changes : mapping
        Tables with the keys and units of a scene file, e.g. ``{"orbit": {"speed_factor": 1.17}}``. A list is replaced
        whole. None removes a key, so that its default holds.

    Returns
    -------
    Scene
        Complete and frozen, in SI units and radians. Of a scene that was made of no file and no tables, all values are
        given ones, and none follows.

    Raises
    ------
    SceneError
        If a file with these values would be rejected; the message has one line for each fault.
    """
    if not isinstance(changes, Mapping):
        raise SceneError(f"{shorten(changes)} given as changes, allowed: a mapping with the keys of a scene file")
    return scene_of(merged(current_tables(scene), without_numpy(changes)), scene.name, scene.name)


def go_on(scene: Scene, state: Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Scene:
    """Make the scene of a run that goes on where a run of `scene` is.

    Parameters
    ----------
    scene : Scene
    state : mapping
        State of a run, of `Trajectory.state`: of `scene`, or of a scene that has gone on from one of its runs.
    changes : mapping, optional
        Other changes, as :func:`change_scene` takes them, e.g. the duration that is left.

    Returns
    -------
    Scene
        It starts in that state. Its instants and those of its results count from there; its effects are where they were
        in the run.

    Raises
    ------
    SceneError
        If a file with these values would be rejected; the message has one line for each fault.
    """
    started = merged(current_tables(scene), without_numpy(state))
    return scene_of(merged(started, without_numpy(changes or {})), scene.name, scene.name, goes_on=True)


def scene_of(tables: dict[str, Any], name: str, file: str, folder: Path = Path(), *, goes_on: bool = False) -> Scene:
    """Scene of a file's tables, whose paths are relative to `folder`; error messages begin with `file`.

    A scene that goes on from the state of a run has laws that this state meets.
    """
    goes_on = goes_on or "start" in tables
    try:
        tables = with_state(tables, folder)
        scene = dataclasses.replace(resolve(SceneFile.model_validate(tables), name), given=tables)
        if goes_on:
            need_met_laws(scene)
        return scene
    except ValidationError as error:
        raise SceneError("\n".join(f"{file}: {line}" for line in fault_lines(error))) from None
    except (IncompleteError, LimitError) as error:
        raise SceneError(f"{file}: {error}") from None


def check_scene(scene: Scene) -> Scene:
    """Check a scene that was made or changed in Python; a scene from a file is valid already.

    Values that follow from others in the scene's file must follow from the changed ones: `change_scene` computes them.
    Faults are named as in a file: ``effects.thrust[1].bar`` is the bar of the first thrust, and angles are in degrees.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
        The same scene; numbers of NumPy are Python's in it, and numbers are whole or not as in a file's scene, so that
        equal scenes have equal digests.

    Raises
    ------
    SceneError
        If a file with these values would be rejected; the message has one line for each fault.
    """
    try:
        scene = with_plain_numbers(scene)
        found = scene_of(current_tables(scene), scene.name, scene.name)
    except SceneError:
        raise
    except (TypeError, AttributeError, OverflowError, ValueError) as error:
        raise SceneError(f"{scene.name}: a field of the scene is not of its type: {error}") from None
    faults = list(type_faults(scene, found))
    if faults:
        raise SceneError("\n".join(f"{scene.name}: {line}" for line in faults))
    checked: Scene = with_types_of(scene, found)
    return checked
