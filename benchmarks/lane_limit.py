"""Distance of the lanes from the processor's limit.

    python benchmarks/lane_limit.py

1. Arithmetic instructions of the lanes' machine code, function by function: packed (all lanes) and scalar.
2. Instructions that one evaluation and one trial step of W copies of fig05 execute, counted by gdb, step by step.
3. Rates of this processor (sums with product, divisions, roots) and times of an evaluation and a trial step, in one
   process. The clock is taken from a chain of dependent products, four cycles each on all processors with AVX-512.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from llvmlite import binding as llvm

from barchain.studies.ensemble.plan import EnsembleOptions, make_plan
from barchain.studies.ensemble.population import batch
from barchain.studies.ensemble.tasks import tasks
from reference_impl.fast.lanes import layout
from reference_impl.fast.lanes.batch import run_lanes
from reference_impl.fast.lanes.evaluation import evaluate
from reference_impl.fast.lanes.queue import run_queue
from reference_impl.fast.lanes.step import begin, try_step
from reference_impl.machine_code import target
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.lanes import equal, get, put, root
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix
from reference_impl.machine_code.unit import lowered
from reference_impl.machine_code.values import WIDTH

if TYPE_CHECKING:
    from collections.abc import Callable

SCENE, VARY, RTOL = "paper/fig05", "angle_deg=normal(0, 1)", 1e-8
ARITHMETIC = r"v?(?:fn?m(?:add|sub)\d*|add|sub|mul|div|sqrt|min|max)(pd|sd)"
SLOW = ("div", "sqrt")
CHAIN_CYCLES = 4  # latency of a product
TRACED = ("reference_impl.fast.lanes.evaluation.evaluate", "reference_impl.fast.lanes.step.try_step")
BEST_OF = 300

TRACE = """
import collections, gdb, json
gdb.execute("set pagination off")
gdb.execute("handle SIGUSR1 stop nopass")
gdb.execute("run", to_string=True)
found = {}
for name in %r:
    gdb.Breakpoint("*'" + name + "'").ignore_count = 2
    gdb.execute("continue", to_string=True)
    top, count = int(gdb.parse_and_eval("$rsp")), collections.Counter()
    while int(gdb.parse_and_eval("$rsp")) <= top:
        count[gdb.selected_frame().architecture().disassemble(int(gdb.parse_and_eval("$pc")))[0]["asm"]] += 1
        gdb.execute("stepi", to_string=True)
    found[name] = count
    gdb.execute("delete")
print("FOUND" + json.dumps(found))
gdb.execute("kill")
"""


@compiled
def chain_of_products(turns: int, x: float) -> float:
    """Product after product, each waiting for the one before."""
    y = x
    for _ in range(turns):
        y = y * x
    return y


@compiled
def products(turns: int, g: Matrix) -> None:
    """Ten sums with product in each turn that do not wait for each other."""
    a, b, c, d, e = get(g, 0), get(g, 1), get(g, 2), get(g, 3), get(g, 4)
    f, h, i, j, k = get(g, 5), get(g, 6), get(g, 7), get(g, 8), get(g, 9)
    x, y = get(g, 10), get(g, 11)
    for _ in range(turns):
        a, b, c, d, e = a * x + y, b * x + y, c * x + y, d * x + y, e * x + y
        f, h, i, j, k = f * x + y, h * x + y, i * x + y, j * x + y, k * x + y
    put(g, 0, a + b + c + d + e + f + h + i + j + k)


@compiled
def quotients(turns: int, g: Matrix) -> None:
    """Four divisions in each turn."""
    a, b, c, d, x = get(g, 0), get(g, 1), get(g, 2), get(g, 3), get(g, 10)
    for _ in range(turns):
        a, b, c, d = x / a, x / b, x / c, x / d
    put(g, 0, a + b + c + d)


@compiled
def roots(turns: int, g: Matrix) -> None:
    """Four square roots in each turn."""
    a, b, c, d = get(g, 0), get(g, 1), get(g, 2), get(g, 3)
    for _ in range(turns):
        a, b, c, d = root(a), root(b), root(c), root(d)
    put(g, 0, a + b + c + d)


@compiled
def evaluations(turns: int, n: int, gravity: int, g: Matrix) -> None:
    """Evaluations of W chains."""
    for _ in range(turns):
        evaluate(n, gravity, layout.STATE, layout.STATE + layout.SLOPES * (2 * n + 4), g)


@compiled
def steps(turns: int, n: int, gravity: int, step_s: float, g: Matrix) -> None:
    """Trial steps of W chains."""
    for _ in range(turns):
        put(g, layout.STEP, equal(step_s))
        try_step(n, gravity, 1e9, g)


Library("rates", (chain_of_products, products, quotients, roots, evaluations, steps))


def assembly(functions: list[Any], *, slp: bool) -> str:
    """Assembly of functions and their callees, optimized as the product's code; `slp` adds the SLP vectorizer."""
    machine = target.machine()
    module = llvm.parse_assembly(lowered("shown", functions, machine.triple, str(machine.target_data)))
    options = llvm.create_pipeline_tuning_options(speed_level=target.SPEED)
    options.loop_vectorization, options.slp_vectorization = True, slp
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    text: str = machine.emit_assembly(module)
    return text


def arithmetic(text: str) -> dict[str, Counter[str]]:
    """Packed and scalar arithmetic instructions of each function in an assembly text."""
    found: dict[str, Counter[str]] = {}
    name = ""
    for line in text.splitlines():
        if label := re.match(r'^"?([a-z_]+[\w.]*)"?:', line):
            name = label[1]
        elif code := re.match(rf"^\s+{ARITHMETIC}\s", line):
            found.setdefault(name, Counter())["packed" if code[1] == "pd" else "scalar"] += 1
    return found


def executed() -> dict[str, Counter[str]]:
    """Classes of the instructions that an evaluation and a trial step execute."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder, "trace.py")
        script.write_text(TRACE % (TRACED,), encoding="utf-8")
        line = ["gdb", "-q", "-batch", "-x", str(script), "--args", sys.executable, __file__, "--traced"]
        said = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    counts = json.loads(said[said.index("FOUND") + 5 :].splitlines()[0])
    found: dict[str, Counter[str]] = {}
    for name, texts in counts.items():
        own = found[name] = Counter()
        for text, times in texts.items():
            own[kind(text)] += times
    return found


def kind(text: str) -> str:
    """Class of an instruction."""
    code = re.match(rf"{ARITHMETIC}\s", text)
    if code is None:
        return "loads and stores of vectors" if text.startswith("vmov") and "(" in text else "other"
    if code[1] == "sd":
        return "scalar arithmetic"
    return next((slow for slow in SLOW if slow in code[0]), "packed sums and products")


def least(runs: dict[str, tuple[int, Callable[[], Any]]]) -> dict[str, float]:
    """Least time of a turn of each function, s, all in turn; given with their numbers of turns."""
    best = dict.fromkeys(runs, np.inf)
    for _ in range(BEST_OF):
        for name, (turns, run) in runs.items():
            begun = time.perf_counter()
            run()
            best[name] = min(best[name], (time.perf_counter() - begun) / turns)
    return best


def group() -> tuple[Any, int, Matrix]:
    """Batch of W copies of the scene, its number of bars, and its group at the start."""
    plan = make_plan(EnsembleOptions(SCENE, [VARY], runs=WIDTH, orbits=1.0))
    made = batch(next(tasks(plan)).part, RTOL)
    n = plan.scene.bars
    columns, g, s = layout.start_columns(made), layout.new_group(n), 2 * n + 4
    g[: layout.STATE + 2 * s] = columns[:, : layout.STATE + 2 * s].T
    for i in range(n):
        first, own = layout.STATE + layout.BLOCKS * s + layout.BAR_ROWS * i, layout.STATE + 2 * s + 10 * i
        g[first : first + 10] = columns[:, own : own + 10].T
    begin(n, made.gravity, 0.0, plan.scene.run.duration_s, g)
    return made, n, g


def show_rates() -> None:
    """Print rates of the processor, and times of the lanes."""
    made, n, g = group()
    r = np.ones((12, WIDTH)) + 0.5 * np.random.default_rng(1).random((12, WIDTH))
    r[10] = 0.5
    step_s = float(g[layout.STEP, 0])
    found = least({
        "product after product": (100_000, lambda: chain_of_products(100_000, 1.0)),
        "sum with product": (200_000, lambda: products(20_000, r.copy())),
        "division": (20_000, lambda: quotients(5000, r.copy())),
        "root": (20_000, lambda: roots(5000, r.copy())),
        "evaluation": (500, lambda: evaluations(500, n, made.gravity, g.copy())),
        "trial step": (40, lambda: steps(40, n, made.gravity, step_s, g.copy())),
    })  # fmt: skip
    cycle = found["product after product"] / CHAIN_CYCLES
    click.echo(f"clock {1e-9 / cycle:.2f} GHz; {WIDTH} chains of {n} bars in step take {g.nbytes / 1000:.0f} kB")
    for name, seconds in found.items():
        click.echo(f"{name}: {seconds * 1e9:.1f} ns, {seconds / cycle:.2f} cycles")


@click.command()
@click.option("--traced", is_flag=True, hidden=True)
def main(traced: bool) -> None:
    """Measure how far the lanes are from the processor's limit."""
    if traced:
        made, _, _ = group()
        run_lanes(made, np.linspace(0.0, 1000.0, 5))
        os.kill(os.getpid(), signal.SIGUSR1)
        run_lanes(made, np.linspace(0.0, 1000.0, 5))
        return
    click.echo("machine code of the lanes: arithmetic instructions")
    for name, count in arithmetic(assembly([run_queue, begin], slp=False)).items():
        click.echo(f"  {name:55s} packed {count['packed']:4d}  scalar {count['scalar']:4d}")
    if shutil.which("gdb"):
        for name, count in executed().items():
            click.echo(f"{name} executes {count.total()}: " + ", ".join(f"{v} {k}" for k, v in count.most_common()))
    show_rates()


if __name__ == "__main__":
    main()
