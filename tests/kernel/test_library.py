"""The kernel's library: built from its sources, loaded by level, its arguments checked."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reference_impl.kernel import build, effects, layout
from reference_impl.kernel.batch import Batch, members_of, new_results
from reference_impl.kernel.library import Evaluation, Integrator, Observer, evaluate, integrate_in_lanes, library
from tests.support.joint_roundoff import C, U, case
from tests.support.kernel import needs_kernel
from tests.support.machine import needs

pytestmark = needs_kernel
ROOT = Path(__file__).parents[2]
COMPILER = build.compiler()
needs_compiler = needs("a C compiler", there=COMPILER is not None)
needs_sanitizers = needs("gcc, which brings the sanitizers", there=shutil.which("gcc") is not None)


def prepared(bars: int = 5):
    """State vector, chain and workspace."""
    c = case(3, bars, "gradient", 0.0)
    y = layout.pack(c.state.com_m, c.state.com_velocity_m_s, c.state.angle_rad, c.state.rate_rad_s)
    chain = layout.compiled_chain(c.model)
    return y, chain, layout.workspace_of(chain)


def test_wrong_sizes_are_refused_before_the_call() -> None:
    y, chain, work = prepared()
    rates = np.zeros_like(y)
    with pytest.raises(ValueError, match="y has 12 numbers, allowed: 2N\\+4 = 14 or more"):
        evaluate(0.0, y[:12].copy(), rates, chain, work)
    with pytest.raises(ValueError, match="rates has the shape"):
        evaluate(0.0, y, rates[:-1].copy(), chain, work)
    with pytest.raises(ValueError, match=r"work\.bars has the shape"):
        evaluate(0.0, y, rates, chain, layout.workspace(4, 0))
    with pytest.raises(ValueError, match=r"chain\.bars has the shape"):
        evaluate(0.0, y, rates, replace(chain, bars=chain.bars[:9].copy()), work)
    with pytest.raises(ValueError, match=r"work\.effect_bars"):
        evaluate(0.0, y, rates, chain, layout.workspace(5, 0, effects=True))


def test_other_elements_and_gaps_are_refused() -> None:
    y, chain, work = prepared()
    with pytest.raises(TypeError, match="contiguous float64"):
        evaluate(0.0, y, np.zeros(len(y), dtype=np.float32), chain, work)
    with pytest.raises(TypeError, match="contiguous False"):
        evaluate(0.0, y, np.zeros(2 * len(y))[::2], chain, work)


def test_a_stepper_of_another_chain_is_refused() -> None:
    y, chain, work = prepared()
    smaller, no_surface = layout.new_stepper(prepared(1)[0]), layout.SurfaceBounds(0.0, np.inf, 0.0)
    with pytest.raises(ValueError, match=r"stepper\.y has 8 numbers"):
        Integrator(smaller, np.ones(8), no_surface, chain, work)
    with pytest.raises(ValueError, match="rows has the shape"):
        Integrator(layout.new_stepper(y), np.ones_like(y), no_surface, chain, work).sample_into(
            np.zeros(2), np.zeros((2, 8))
        )


def test_a_batch_without_room_for_its_results_is_refused() -> None:
    y, chain, _ = prepared()
    one, no_laws = np.zeros(1), np.zeros((1, 0, layout.FIRST_TURN + layout.TURN_COLUMNS))
    batch = Batch(
        np.full(1, chain.mu_m3_s2), chain.gravity, chain.bars[None], no_laws, (), y[None],
        np.ones((1, len(y))), one, one, one,
    )  # fmt: skip
    t_s = np.linspace(0.0, 10.0, 3)
    with pytest.raises(ValueError, match="angle_rad has the shape"):
        integrate_in_lanes(members_of(batch), t_s, new_results(batch, t_s[:2]))


def test_the_library_was_built_from_these_sources() -> None:
    assert library().source_digest().decode() == build.source_digest()


@pytest.mark.exhaustive
@needs_compiler
def test_a_library_with_another_layout_or_order_of_effects_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    library()
    load = library.__wrapped__  # without the cache, which keeps the library for the other tests
    load()
    monkeypatch.setattr(layout, "SCRATCH_ROWS", layout.SCRATCH_ROWS - 1)
    kinds = dict(reversed(effects.KINDS.items()))
    monkeypatch.setattr(effects, "KINDS", kinds)
    with pytest.raises(build.KernelMissingError) as refused:
        load()
    assert f"SCRATCH_ROWS is {layout.SCRATCH_ROWS + 1} there, {layout.SCRATCH_ROWS} here" in str(refused.value)
    assert "effect 0 is drag there, thrust here" in str(refused.value)


@pytest.mark.slow
def test_an_edited_source_is_compiled_when_it_is_next_used(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "reference_impl", tmp_path / "reference_impl")
    gravity = tmp_path / "reference_impl" / "kernel" / "c" / "chain" / "gravity.h"
    gravity.write_text(gravity.read_text().replace("3.0 * pull * inverse2", "4.0 * pull * inverse2"))
    code = "from reference_impl.kernel.build import library_file; print(library_file())"
    env = os.environ | {"PYTHONPATH": str(tmp_path), "PYTHONSAFEPATH": "1", build.EXTRA_FLAGS: "-O0"}  # sooner done
    done = [
        subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=env, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert "edited after it was built" in done[0].stderr
    assert done[1].stderr == ""
    assert done[0].stdout == done[1].stdout
    assert Path(done[0].stdout.strip()).name != build.library_path(build.best_level()).name


def test_an_edited_source_is_named_where_there_is_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "compiler", lambda: None)
    monkeypatch.setattr(build, "source_digest", lambda: "0123456789abcdef")
    monkeypatch.delenv(build.GIVEN_LIBRARY, raising=False)
    assert "its sources were edited after it was built" in build.why_missing()
    assert "there is no C compiler" in build.why_missing()


@needs_compiler
@pytest.mark.slow
def test_all_levels_that_run_here_agree_to_rounding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert COMPILER is not None
    monkeypatch.setattr(build, "UNITS", ("kernel.c",))  # which has what is called here
    y, chain, work = prepared(40)
    rates = np.zeros_like(y)
    assert Evaluation(y, rates, chain, work)(0.0)
    runnable = build.levels()[build.levels().index(build.best_level()) :]
    for path in build.build(COMPILER, tmp_path, runnable):
        other, found = ctypes.CDLL(str(path)), np.zeros_like(y)
        other.evaluate_state.argtypes = library().evaluate_state.argtypes
        other.evaluate_state.restype = ctypes.c_bool
        assert other.evaluate_state(0.0, y.ctypes.data, found.ctypes.data, chain.address, work.address)
        assert np.abs(found - rates).max() <= C * U * np.abs(rates).max()


def test_reactions_at_no_sample_are_none() -> None:
    y, chain, work = prepared()
    assert Observer(chain, work)(np.zeros(0), np.zeros((0, len(y))), np.zeros((0, 4, 2)), np.zeros((0, 0)))


@needs_sanitizers
@pytest.mark.slow
def test_the_kernels_tests_pass_under_the_sanitizers(tmp_path: Path) -> None:
    """Address and undefined behaviour; overruns of NumPy's arrays are seen too, as they are the kernel's memory."""
    flags = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer")
    (path,) = build.build(["gcc"], tmp_path, (build.best_level(),), flags)
    runtime = [
        subprocess.run(["gcc", f"-print-file-name={name}"], capture_output=True, text=True, check=True).stdout.strip()
        for name in ("libasan.so", "libstdc++.so.6")  # the second for exceptions of other libraries
    ]
    env = os.environ | {
        "LD_PRELOAD": " ".join(runtime), "ASAN_OPTIONS": "detect_leaks=0", "PYTHONMALLOC": "malloc",
        build.GIVEN_LIBRARY: str(path),
    }  # fmt: skip
    tests = [
        "tests/kernel/test_compiled_reference.py", "tests/kernel/test_lanes.py",
        "tests/effects/test_compiled_effects.py",
    ]  # fmt: skip
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]


FAKE = "import sys; open(sys.argv[sys.argv.index('-o') + 1], 'w').write(' '.join(sys.argv))"
"""Compiler that writes its arguments"""


def test_an_installation_compiles_for_this_processor_and_a_shared_one_for_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler = [sys.executable, "-S", "-c", FAKE]
    monkeypatch.setattr(build, "UNITS", ("kernel.c",))
    monkeypatch.delenv(build.ALL_LEVELS, raising=False)
    assert build.build(compiler, tmp_path / "own") == [build.library_path(build.best_level(), tmp_path / "own")]
    monkeypatch.setenv(build.ALL_LEVELS, "all")
    made = build.build(compiler, tmp_path / "all")
    assert made == [build.library_path(level, tmp_path / "all") for level in build.levels()]
    assert all(path.read_text().count("kernel.c.o") == 1 for path in made)
    monkeypatch.setenv(build.ALL_LEVELS, "v3")
    with pytest.raises(ValueError, match="v3 given, allowed: all"):
        build.wanted_levels()


def test_a_lower_library_serves_where_the_best_one_is_missing_and_nothing_compiles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(build, "levels", lambda: ("best", "lower", "lowest"))
    monkeypatch.setattr(build, "best_level", lambda: "best")
    monkeypatch.setattr(build, "compiler", lambda: None)
    monkeypatch.setattr(build, "library_path", lambda level: tmp_path / level)
    (tmp_path / "lowest").touch()
    assert build.built_file("a digest of no other test") == tmp_path / "lowest"
    (tmp_path / "lower").touch()
    assert build.built_file("another digest of no other test") == tmp_path / "lower"
