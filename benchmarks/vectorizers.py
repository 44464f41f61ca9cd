"""Machine code that LLVM's vectorizers make of an evaluation in a loop over chains, and its time beside the lanes'.

    python benchmarks/vectorizers.py

The text of the lanes' evaluation is rewritten for one number instead of W, and called in a loop over W chains, whose
numbers lie side by side in memory. With the number of bars known only at run time, and as a constant. Prints packed
and scalar arithmetic instructions without and with LLVM's SLP vectorizer, LLVM's remarks, and times.
"""

from __future__ import annotations

import ast
import importlib.util
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import click
import numpy as np
from lane_limit import arithmetic, assembly, evaluations, group, least
from llvmlite import binding as llvm

from reference_impl.fast.lanes import evaluation, layout
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.values import WIDTH

REMARKS = "(loop-vectorize|slp-vectorizer)"
LOOP = """
@compiled
def evaluate_all(n: int, gravity: int, at: int, to: int, g: Matrix) -> int:
    lost = 0
    for lane in range(WIDTH):
        lost |= evaluate(BARS, gravity, at, to, g, lane)
    return lost

@compiled
def one_by_one(turns: int, n: int, gravity: int, at: int, to: int, g: Matrix) -> None:
    for _ in range(turns):
        evaluate_all(n, gravity, at, to, g)
"""


class OneNumber(ast.NodeTransformer):
    """Text of functions of W numbers for the number in one lane."""

    PLAIN: dict[str, str] = {  # noqa: RUF012
        "get": "{0}[{1}, lane]", "select": "({1}) if ({0}) else ({2})", "equal": "float({0})", "root": "np.sqrt({0})",
        "digit": "(int({0}) >> {1} & 1) == 1", "bits": "1 if ({0}) else 0",
    }  # fmt: skip

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Operations of one number; functions of the module get the lane."""
        self.generic_visit(node)
        name, given = getattr(node.func, "id", ""), [ast.unparse(a) for a in node.args]
        if name in self.PLAIN:
            return ast.parse(self.PLAIN[name].format(*given), mode="eval").body
        if name.endswith(("_bars", "_gravity")):
            node.args.append(ast.Name("lane", ast.Load()))
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        """Assignments in place of `put`."""
        self.generic_visit(node)
        if isinstance(node.value, ast.Call) and getattr(node.value.func, "id", "") == "put":
            where, row, value = (ast.unparse(a) for a in node.value.args)
            return ast.parse(f"{where}[{row}, lane] = {value}").body[0]
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Functions of a lane."""
        self.generic_visit(node)
        node.args.args.append(ast.arg("lane", ast.Name("int", ast.Load())))
        return node


def one_number_module(folder: Path, name: str, bars: str) -> Any:
    """Module with the evaluation of one number, and a loop over chains of so many bars: ``n`` or a constant."""
    tree = OneNumber().visit(ast.parse(Path(evaluation.__file__).read_text(encoding="utf-8").replace("Lanes", "float")))
    tree.body = [b for b in tree.body if not (isinstance(b, ast.ImportFrom) and (b.module or "").endswith(".lanes"))]
    text = ast.unparse(ast.fix_missing_locations(tree))
    head = f"import numpy as np\nfrom reference_impl.machine_code.lanes import ROUNDER\nWIDTH = {WIDTH}\n"
    text = text.replace("import annotations\n", f"import annotations\n{head}", 1).replace("@compiled", "@inlined")
    text += LOOP.replace("BARS", bars)
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    sys.modules[name] = made
    spec.loader.exec_module(made)
    Library(name, (made.evaluate_all, made.one_by_one))
    return made


def show(name: str, one: Any) -> None:
    """Print instructions and time of a loop over chains."""
    made, n, g = group()
    at, to = layout.STATE, layout.STATE + layout.SLOPES * (2 * n + 4)
    lanes, alone = g.copy(), g.copy()
    evaluations(1, n, made.gravity, lanes)
    one.one_by_one(1, n, made.gravity, at, to, alone)
    assert np.array_equal(lanes[to : to + 2 * n + 4], alone[to : to + 2 * n + 4])
    found = least({
        "lanes": (500, lambda: evaluations(500, n, made.gravity, g.copy())),
        "loop": (100, lambda: one.one_by_one(100, n, made.gravity, at, to, g.copy())),
    })  # fmt: skip
    loop, ratio = found["loop"], found["loop"] / found["lanes"]
    click.echo(f"{name}: {loop * 1e9:.0f} ns an evaluation of {WIDTH} chains, {ratio:.1f} times the lanes'")
    for slp in (False, True):
        count = sum(arithmetic(assembly([one.evaluate_all], slp=slp)).values(), Counter())
        click.echo(f"  loops{' and SLP' if slp else ''}: packed {count['packed']}, scalar {count['scalar']}")


@click.command()
@click.option("--remarks", is_flag=True, help="Print LLVM's remarks on standard error.")
def main(remarks: bool) -> None:
    """Show what LLVM makes of a loop over chains."""
    if remarks:
        for option in ("pass-remarks", "pass-remarks-missed", "pass-remarks-analysis"):
            llvm.set_option("", f"-{option}={REMARKS}")
    with tempfile.TemporaryDirectory() as folder:
        for bars, name in (("n", "any number of bars"), ("5", "five bars")):
            show(name, one_number_module(Path(folder), f"one_number_{bars}", bars))


if __name__ == "__main__":
    main()
