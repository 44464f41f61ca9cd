"""Compilation of the kernel: which compiler, which processors, and where the libraries are.

The build hook of the package runs this module before anything is installed; it uses the standard library alone.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
SOURCES, BUILT = HERE / "c", HERE / "built"
UNITS = ("kernel.c", "wide.c", "levers.c", "wide_levers.c", "lanes.c", "cvode.c")
GIVEN_LIBRARY = "BARCHAIN_KERNEL"
"""Environment variable: library to load instead, one built with other flags"""
NO_KERNEL = "BARCHAIN_NO_KERNEL"
"""Environment variable: 1 installs without the kernel, where neither a compiler nor ziglang is in reach"""
ALL_LEVELS = "BARCHAIN_KERNEL_LEVELS"
"""Environment variable: all builds a wheel, or an installation, that is shared with machines of other processors"""
EXTRA_FLAGS = "BARCHAIN_KERNEL_FLAGS"
"""Environment variable: further flags of the compiler, such as -Werror"""
FLAGS = (
    "-std=c11", "-O3", "-g1", "-fPIC",
    # the freedom that the arithmetic allows: a product and a sum may become one operation, but sums keep their order
    "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast",
    "-Wall", "-Wextra",
    "-Wno-unknown-pragmas",  # clang has no ivdep, and needs none
    "-Wno-psabi",  # vectors wider than a register are passed between functions of one file only
)  # fmt: skip
LEVELS = {
    "x86-64-v4": ("-march=x86-64-v4", "-mprefer-vector-width=256"),  # short loops are faster at half the width
    "x86-64-v3": ("-march=x86-64-v3",),
    "x86-64-v2": ("-march=x86-64-v2",),
}
"""Levels of x86-64, best first, and their flags; other processors have one library without such flags"""
PROCESSOR_FEATURES = {
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"},
}
"""Names in /proc/cpuinfo, beyond the level below"""


def compiler() -> list[str] | None:
    """Command of a C compiler: the machine's, or that of the distribution ziglang; None without either."""
    found = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if found:
        return found.split()
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-P", "-m", "ziglang", "cc"]
    return None


def machine() -> str:
    """Name of the processor's architecture."""
    name = platform.machine().lower()
    return {"amd64": "x86_64", "arm64": "aarch64"}.get(name, name)


def levels() -> tuple[str, ...]:
    """Libraries of this architecture, best first."""
    return tuple(LEVELS) if machine() == "x86_64" else (machine(),)


def wanted_levels() -> tuple[str, ...]:
    """Libraries that an installation compiles: this processor's, or all.

    Raises
    ------
    ValueError
        If the environment variable has another value than ``all``.
    """
    given = os.environ.get(ALL_LEVELS, "")
    if given not in ("", "all"):
        raise ValueError(f"{ALL_LEVELS}={given} given, allowed: all, or unset for this processor's library alone")
    return levels() if given else (best_level(),)


@cache
def best_level() -> str:
    """Best library that this processor can run."""
    if machine() != "x86_64":
        return machine()
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:  # not Linux
        return "x86-64-v2"
    features = set(next((line for line in text.splitlines() if line.startswith("flags")), "").split())
    if not PROCESSOR_FEATURES["x86-64-v3"] <= features:
        return "x86-64-v2"
    return "x86-64-v4" if PROCESSOR_FEATURES["x86-64-v4"] <= features else "x86-64-v3"


@cache
def source_digest() -> str:
    """Digest of the sources and of this module, whose flags decide the code."""
    found = hashlib.sha256()
    for path in (*sorted(SOURCES.rglob("*.[ch]")), Path(__file__)):
        found.update(f"{path.name} {path.stat().st_size}\n".encode() + path.read_bytes())
    return found.hexdigest()[:16]


def library_path(level: str, folder: Path = BUILT) -> Path:
    """Library of a level, named by its sources: an edited source has no library until it is built."""
    suffix = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    return folder / f"kernel-{source_digest()}-{level}{suffix}"


def build(
    command: list[str], folder: Path = BUILT, wanted: tuple[str, ...] | None = None, flags: tuple[str, ...] = ()
) -> list[Path]:
    """Compile libraries into a folder, and remove those of other sources there.

    Parameters
    ----------
    command : list of str
        Compiler.
    folder : Path
    wanted : tuple of str, optional
        Levels, by default those of :func:`wanted_levels`.
    flags : tuple of str
        Further flags.

    Raises
    ------
    subprocess.CalledProcessError
        If the compiler fails; its messages are in the exception.
    OSError
        If the folder can't be written, or the compiler not started.
    """
    folder.mkdir(parents=True, exist_ok=True)
    made = {level: library_path(level, folder) for level in wanted or wanted_levels()}
    with tempfile.TemporaryDirectory(dir=folder, prefix=".") as scratch, ThreadPoolExecutor(os.cpu_count()) as pool:
        define, objects = f'-DSOURCE_DIGEST="{source_digest()}"', []
        more = {
            level: (*known_flags(command, LEVELS.get(level, ())), *flags, *os.environ.get(EXTRA_FLAGS, "").split())
            for level in made
        }
        for level in made:
            for unit in UNITS:
                part = str(Path(scratch) / f"{level}-{unit}.o")
                line = [*command, *FLAGS, *more[level], define, "-c", "-o", part, str(SOURCES / unit)]
                objects.append((level, part, pool.submit(run, line)))
        for _, _, compiled in objects:
            compiled.result()
        for level, path in made.items():
            parts, whole = [part for of, part, _ in objects if of == level], Path(scratch) / path.name
            run([*command, "-fPIC", "-shared", *more[level], "-o", str(whole), *parts, "-lm"])
            whole.replace(path)
    for old in folder.glob("kernel-*"):
        if source_digest() not in old.name:
            old.unlink(missing_ok=True)
    return list(made.values())


def run(line: list[str]) -> None:
    """Run the compiler, and show its warnings.

    Raises
    ------
    subprocess.CalledProcessError
        If it fails; its messages are in the exception.
    """
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise subprocess.CalledProcessError(done.returncode, done.args, done.stdout, done.stderr)
    sys.stderr.write(done.stderr)


def known_flags(command: list[str], flags: tuple[str, ...]) -> tuple[str, ...]:
    """Flags of a level as the compiler knows them: zig writes x86_64_v3."""
    if "ziglang" not in command and not command[0].endswith("zig"):
        return flags
    return tuple(flag.replace("-march=x86-64-", "-march=x86_64_") for flag in flags)


class KernelMissingError(ImportError):
    """The library is not there, or was built from other sources."""


def why_missing() -> str:
    """Reason why the kernel can't be used here, and a way to get it; empty if it can be used."""
    try:
        library_file()
    except KernelMissingError as error:
        return str(error)
    return ""


def library_file() -> Path:
    """Library for this processor; one of edited sources is built first, where there is a compiler.

    Raises
    ------
    KernelMissingError
        If there is none, with a way to get it.
    """
    given = os.environ.get(GIVEN_LIBRARY)
    if given:
        return Path(given)
    return built_file(source_digest())


@cache
def built_file(digest: str) -> Path:
    """Library of the sources with a digest."""
    path, command = library_path(best_level()), compiler()
    if path.exists():
        return path
    lower = [library_path(level) for level in levels()[levels().index(best_level()) + 1 :]]
    if command is None and (found := next(filter(Path.exists, lower), None)):
        return found  # installed by a machine with an older processor
    older = any(BUILT.glob("kernel-*")) if BUILT.exists() else False
    state = f"its sources were edited after it was built (now {digest})" if older else "it was not built"
    if command is None:
        raise KernelMissingError(
            f"no compiled kernel: {state}, and there is no C compiler; "
            "try: install gcc, clang or `pip install ziglang`, then install barchain again"
        )
    try:
        sys.stderr.write(f"barchain: {state}; the kernel is compiled by {' '.join(command)}\n")
        build(command, wanted=(best_level(),))
    except (OSError, subprocess.CalledProcessError) as error:
        words = (getattr(error, "stderr", "") or str(error)).strip().splitlines()
        raise KernelMissingError(
            f"no compiled kernel: {state}, and building fails: {words[0] if words else error}"
        ) from error
    return path


if __name__ == "__main__":  # build.py FOLDER FLAGS: a library for this processor, to be named in BARCHAIN_KERNEL
    found = compiler()
    if found is None or len(sys.argv) < 2:
        sys.exit("usage: python -m reference_impl.kernel.build FOLDER [FLAGS], with a C compiler")
    print(*build(found, Path(sys.argv[1]), (best_level(),), tuple(sys.argv[2:])))
