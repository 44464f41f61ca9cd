"""Count the machine instructions of one compiled evaluation, effect by effect, and time it.

    python benchmarks/instructions.py [--against REVISION]

Valgrind's callgrind counts what a virtual processor executes: the same number on every run and machine, whose code is
made for one fixed kind of processor. A count is the difference of 2K and K evaluations, over K. With a git revision the
plain scenes are counted in it too: code that has grown effects must not cost a chain that has none.
"""

from __future__ import annotations

import ctypes
import dataclasses
import json
import mmap
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.studies.timing.evaluation import evaluation_times, loop_of
from scenarios import Gravity, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenarios import Scene

HERE = Path(__file__).resolve()
ENGINE, SHOWN = "reference-fast", "effects/everything"
PLAIN = ("paper/fig05", "paper/fig09", "basics/two_bars_free")
EVALUATIONS, TURNS = 20_000, 15  # so many that the few hundred instructions of a call from Python round off
LEVEL = "x86-64-v3"  # valgrind knows no AVX-512
BUILD = "import pathlib, sys; from reference_impl.kernel import build; "
BUILD += f"print(build.build(build.compiler(), pathlib.Path(sys.argv[1]), ({LEVEL!r},))[0])"
ZERO, DUMP, START, STOP = 0x43540001, 0x43540003, 0x43540004, 0x43540005  # callgrind.h
# `long request(long *six_words)`: words to rax, valgrind's magic preamble, answer from rdx; nothing on a processor
REQUEST = bytes.fromhex("4889f8 31d2 48c1c703 48c1c70d 48c1c73d 48c1c733 4887db 4889d0 c3")


def variants() -> Iterator[tuple[str, Scene]]:
    """Chains of one scene with no effect, each alone, and all."""
    scene = load_scene(SHOWN)
    given = dataclasses.replace(scene.effects, prescribed_rotation=(), impulse=())
    none = dataclasses.replace(
        given, gravity=Gravity.GRADIENT, oblateness=None, third_body=(), drag=None, solar_pressure=None,
        joint_spring_damper=None, thrust=(),
    )  # fmt: skip
    thrust = tuple(dataclasses.replace(t, times_s=tuple(s - t.times_s[0] for s in t.times_s)) for t in given.thrust)
    yield "no effects", dataclasses.replace(scene, effects=none)
    for gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER):
        yield gravity.value, dataclasses.replace(scene, effects=dataclasses.replace(none, gravity=gravity))
    alone = {
        "oblateness": given.oblateness, "third_body": given.third_body[:1], "drag": given.drag,
        "solar_pressure": given.solar_pressure, "joint_spring_damper": given.joint_spring_damper, "thrust": thrust,
    }  # fmt: skip
    for name, value in alone.items():
        yield name, dataclasses.replace(scene, effects=dataclasses.replace(none, **{name: value}))
    yield "all of them", dataclasses.replace(scene, effects=dataclasses.replace(given, thrust=thrust))


def asker() -> Callable[..., None]:
    """Object that makes requests to valgrind."""
    page = mmap.mmap(-1, mmap.PAGESIZE, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    page.write(REQUEST)
    call = ctypes.CFUNCTYPE(ctypes.c_long, ctypes.c_void_p)(ctypes.addressof(ctypes.c_char.from_buffer(page)))

    def ask(request: int, text: bytes = b"") -> None:
        kept = ctypes.create_string_buffer(text)
        words = (ctypes.c_long * 6)(request, ctypes.addressof(kept), 0, 0, 0, 0)
        call(ctypes.addressof(words))

    ask.page = page  # type: ignore[attr-defined]  # lives as long as the function
    return ask


def scenes(which: str) -> dict[str, Scene]:
    """Counted scenes, by name."""
    return {name: load_scene(name) for name in PLAIN} if which == "plain" else dict(variants())


def counted(which: str) -> None:
    """Inside valgrind: run each loop K and 2K times, a dump after each."""
    ask = asker()
    for name, scene in scenes(which).items():
        loop = loop_of(ENGINE, scene)
        loop(1)
        for times in (EVALUATIONS, 2 * EVALUATIONS):
            ask(START)
            ask(ZERO)
            loop(times)
            ask(DUMP, f"{name} {times}".encode())
            ask(STOP)


def totals(folder: Path) -> dict[str, int]:
    """Instructions of each dump, by its name."""
    found = {}
    for path in folder.glob("out*"):
        lines = path.read_text().splitlines()
        triggers = [line.split("Client Request: ")[1].strip() for line in lines if "Client Request: " in line]
        if triggers:
            found[triggers[0]] = next(
                int(line.split()[1]) for line in lines if line.startswith(("totals:", "summary:"))
            )
    return found


def instructions(which: str, tree: Path) -> dict[str, int]:
    """Instructions of one evaluation of each scene, by the code in `tree`."""
    env = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(tree), "PYTHONSAFEPATH": "1"}
    with tempfile.TemporaryDirectory() as folder:
        child = [sys.executable, str(HERE), "--child", which]
        built = [sys.executable, "-c", BUILD, folder]
        made = subprocess.run(built, env=env, cwd=tree, capture_output=True, text=True, check=True).stdout.split()
        env["BARCHAIN_KERNEL"] = made[-1]
        valgrind = ["valgrind", "--quiet", "--tool=callgrind", "--instr-atstart=no", "--smc-check=all-non-file"]
        subprocess.run([*valgrind, f"--callgrind-out-file={folder}/out", *child], env=env, cwd=tree, check=True)
        found = totals(Path(folder))
    names = scenes(which)
    return {
        name: round((found[f"{name} {2 * EVALUATIONS}"] - found[f"{name} {EVALUATIONS}"]) / EVALUATIONS)
        for name in names
    }


def in_revision(revision: str) -> dict[str, int]:
    """Instructions of the plain scenes in a git revision, in a tree of its own."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        git = ["git", "-C", str(HERE.parent), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), revision], check=True)
        try:
            return instructions("plain", tree)
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)


def timed() -> dict[str, float]:
    """Least time of one evaluation of each variant, s; all take turns, so that what disturbs disturbs each of them."""
    loops = {name: loop_of(ENGINE, scene) for name, scene in variants()}
    turns = [{name: float(evaluation_times([loop], 1)[0, 0]) for name, loop in loops.items()} for _ in range(TURNS)]
    return {name: float(min(turn[name] for turn in turns)) for name in loops}


def table(found: dict[str, int], times: dict[str, float]) -> None:
    """Print counts and times, and both over those of no effects."""
    first = next(iter(found))
    click.echo(f"{'one evaluation, ' + SHOWN:34s}{'instructions':>13s}{'':>7s}{'ns':>9s}")
    for name, count in found.items():
        ratio, slower = count / found[first], times[name] / times[first]
        click.echo(f"{name:34s}{count:13d}{ratio:7.2f}{1e9 * times[name]:9.0f}{slower:7.2f}")


def compared(revision: str) -> None:
    """Print the plain scenes' counts beside those of a revision."""
    now, then = instructions("plain", HERE.parent.parent), in_revision(revision)
    click.echo(f"\n{'one evaluation, no effects':34s}{'now':>13s}{revision[:12]:>14s}{'ratio':>9s}")
    for name, count in now.items():
        click.echo(f"{name:34s}{count:13d}{then[name]:14d}{count / then[name]:9.4f}")


@click.command()
@click.option("--against", help="Git revision in which plain scenes are counted too.")
@click.option("--json", "out", type=click.Path(path_type=Path, dir_okay=False), help="File for the numbers.")
@click.option("--child", type=click.Choice(["effects", "plain"]), hidden=True)
def main(against: str | None, out: Path | None, child: str | None) -> None:
    """Count the instructions of one compiled evaluation, and time it."""
    if child:
        counted(child)
        return
    found = instructions("effects", HERE.parent.parent)
    times = timed()
    table(found, times)
    if out:
        out.write_text(json.dumps({"instructions": found, "seconds": times}, indent=1))
    if against:
        compared(against)


if __name__ == "__main__":
    main()
