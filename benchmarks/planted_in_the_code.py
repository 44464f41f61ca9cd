"""Mistakes planted one at a time in barchain's own code, and whether its default tests notice.

    python benchmarks/planted_in_the_code.py                     # all: a quarter of an hour on two cores
    python benchmarks/planted_in_the_code.py --only "judge|runs" # those whose files match

Each mistake is one replacement in a copy of the committed and staged files. The tests of the folders concerned must
turn red; where they stay green, a test is missing, or the mistake is invisible.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILT = "reference_impl/kernel/built"
BUILD = "from reference_impl.kernel.build import build, compiler; build(compiler())"
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
JUDGE = "judge studies/test_selftest.py"
MISTAKES: dict[tuple[str, str], list[tuple[str, str]]] = {
    ("reference_impl/model/gravity.py", "reference"): [
        ("+ com_m * change)", "- com_m * change)"),
    ],
    ("reference_impl/model/gravity.py", "reference effects"): [
        ("Array = 3.0 * model", "Array = 1.5 * model"),
    ],
    ("reference_impl/model/joints.py", "reference"): [
        ("= xx - w[1:-1]", "= xx[::-1] - w[1:-1]"),
        ("REFINEMENTS = 5", "REFINEMENTS = 1"),
    ],
    ("reference_impl/model/relative.py", "reference effects"): [
        ("float(law - 2.0 *", "float(law + 2.0 *"),
    ],
    ("reference_impl/model/invariants.py", "reference metrics"): [
        ("- 0.5 * np.sum(position", "+ 0.5 * np.sum(position"),
    ],
    ("reference_impl/effects/drag.py", "effects"): [
        ("(w - 2.0 * kappa * v)", "(w + 2.0 * kappa * v)"),
    ],
    ("reference_impl/effects/solar_pressure.py", "effects"): [
        ("np.where(seen.real < 0.0", "np.where(seen.real > 0.0"),
    ],
    ("reference_impl/integrate/stepper.py", "reference effects"): [
        ("y = events.begin_segment", "events.begin_segment"),
    ],
    ("reference_impl/kernel/c/chain/gravity.h", "kernel"): [
        ("com_x * nearer - x * faded", "com_x * nearer + x * faded"),
    ],
    ("reference_impl/kernel/c/chain/joints.h", "kernel"): [
        ("-(sxx * txy + sxy * xxx)", "-(sxx * txy - sxy * xxx)"),
    ],
    ("reference_impl/kernel/c/effects/third_body.h", "kernel effects"): [
        ("(body_x * change + x * (1.0", "(body_x * change - x * (1.0"),
    ],
    ("reference_impl/kernel/c/effects/oblateness.h", "kernel effects"): [
        ("15.0 * seventh", "7.5 * seventh"),
    ],
    ("reference_impl/kernel/c/effects/joint_spring_damper.h", "kernel effects"): [
        ("y[n + 3 + i] - y[n + 2 + i]", "y[n + 2 + i] - y[n + 3 + i]"),
    ],
    ("scenarios/toml/checks.py", "scenarios"): [
        ("if p.bar > scene.chain.bars:", "if p.bar > scene.chain.bars + 1:"),
        ("MOST_SCALE_HEIGHTS = 30.0", "MOST_SCALE_HEIGHTS = 300.0"),
        ("size_m >= orbit.altitude_m", "size_m >= 10.0 * orbit.altitude_m"),
    ],
    ("scenarios/toml/resolve.py", "scenarios effects"): [
        ("(central.mu_m3_s2 + mu)", "(central.mu_m3_s2)"),
        ("elif angle:\n            value = math.radians(value)", "elif angle:\n            value = float(value)"),
    ],
    ("adapters/pymunk/space.py", "adapters/test_pymunk.py"): [
        ("0.5 * dt_s**2 * (np.array(lever_m)", "dt_s**2 * (np.array(lever_m)"),
        ("0.5 ** (2.0 / self", "0.5 ** (1.0 / self"),
    ],
    ("adapters/mujoco/chain.py", "adapters/test_mujoco.py"): [
        ("on_next_bar=True", "on_next_bar=False"),
        ("round(data.time / self", "int(data.time / self"),
        ("bar.inertia_kg_m2 * spin))", "bar.mass_kg * spin))"),
    ],
    ("barchain/runs/trajectory_checks.py", "harness metrics"): [
        ("~np.isfinite(value", "np.isnan(value"),
        ("if late <= TIME", "if late <= 10.0 * TIME"),
        ("np.minimum(length[:-1]", "np.maximum(length[:-1]"),
    ],
    ("barchain/runs/job.py", "harness execution"): [
        ("0.0) > self.time_s", "0.0) > 10.0 * self.time_s"),
    ],
    ("barchain/runs/kept_answers.py", "execution"): [
        ("if check == checksum(content) else None", "if content else None"),
    ],
    ("barchain/judge/checks/whole_run.py", JUDGE): [
        ("said = other_end_instant(run)", "said = None"),
    ],
    ("barchain/judge/checks/beyond_limit.py", JUDGE): [
        ("MAX_KINETIC_RATIO = 4.0", "MAX_KINETIC_RATIO = 40.0"),
        ("if not used <= highest", "if used > highest"),
    ],
    ("barchain/judge/checks/up_to_limit.py", JUDGE): [
        ("if ratio <= 1.0:", "if ratio <= 10.0:"),
    ],
    ("barchain/judge/checks/drifts.py", JUDGE): [
        ("allowed = bound[quantity][:n]", "allowed = 10.0 * bound[quantity][:n]"),
    ],
    ("barchain/judge/checks/restart.py", JUDGE): [
        ("np.max(attitude / attitude", "np.min(attitude / attitude"),
    ],
    ("barchain/judge/residuals.py", JUDGE): [
        ("HIGHER_ORDER_SHARE = 0.1", "HIGHER_ORDER_SHARE = 1.0"),
    ],
    ("barchain/judge/compare.py", JUDGE): [
        ("all(noise_explains(run, f)", "any(noise_explains(run, f)"),
    ],
    ("reports/results/outcome.py", JUDGE): [
        ("max(outcomes, key=SEVERITY", "min(outcomes, key=SEVERITY"),
    ],
}  # fmt: skip
"""Texts that occur once and what replaces them, by file and the paths below `tests` that are run"""


def copy(folder: Path) -> None:
    """Copy the committed and staged files, and the built kernel."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    subprocess.run([sys.executable, "-c", BUILD], cwd=ROOT, check=True)
    shutil.copytree(ROOT / BUILT, folder / BUILT, dirs_exist_ok=True)


def noticed(path: Path, old: str, new: str, tests: str, folder: Path) -> str:
    """First test that fails with a mistake in a file below `folder`; empty if none does."""
    right = path.read_text("utf-8")
    if right.count(old) != 1:
        raise SystemExit(f"{path}: {old!r} occurs {right.count(old)} times, expected 1")
    path.write_text(right.replace(old, new), "utf-8")
    environment = os.environ | {"PYTHONPATH": str(folder)}
    try:
        if path.suffix == ".h":
            subprocess.run([sys.executable, "-c", BUILD], cwd=folder, env=environment, check=True)
        command = [sys.executable, "-m", "pytest", "-x", "--tb=no", *(f"tests/{each}" for each in tests.split())]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    finally:
        path.write_text(right, "utf-8")
        shutil.copytree(ROOT / BUILT, folder / BUILT, dirs_exist_ok=True)
    if done.returncode == 0:
        return ""
    found = FAILED.search(done.stdout)
    return found.group(1) if found else f"pytest ended with {done.returncode}"


def main() -> None:
    """Plant the mistakes, and print a table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="Regular expression of files.")
    given = parser.parse_args()
    print("| file | right | planted | first test that fails |\n|---|---|---|---|")
    green = 0
    with tempfile.TemporaryDirectory() as name:
        copy(Path(name))
        for (file, tests), replacements in MISTAKES.items():
            for old, new in replacements if re.search(given.only, file) else ():
                by = noticed(Path(name) / file, old, new, tests, Path(name))
                green += not by
                cells = (file, old, new, by or "**none**")
                print(f"| {' | '.join(' '.join(cell.split()) for cell in cells)} |", flush=True)
    raise SystemExit(f"{green} mistakes are not noticed" if green else 0)


if __name__ == "__main__":
    main()
