"""Whether scenes without an effect move as they did before the effect was there, to the last bit.

``python benchmarks/same_bits.py REVISION [ENGINE ...]`` runs the paper's and the basic scenes in the tree and in a
checkout of a git revision, side by side on this machine, and compares every number of every trajectory. It names the
channels that differ, and exits with 1 if any does.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
ENGINES = ("reference", "reference-absolute", "reference-fast")
CHANNELS = ("com_m", "com_velocity_m_s", "angle_rad", "rate_rad_s", "reaction_N", "torque_N_m")


def digests(engines: list[str]) -> dict[str, dict[str, str]]:
    """Hash of each channel of each plain scene's trajectory in each engine."""
    import numpy as np  # noqa: PLC0415  # of the checkout that runs

    from adapters.registry import find_engine  # noqa: PLC0415
    from scenarios import load_scene, scene_names  # noqa: PLC0415

    found = {}
    for name in (n for n in scene_names() if n.startswith(("paper/", "basics/"))):
        scene = load_scene(name)
        for engine in engines:
            seen = find_engine(engine).engine().run(scene)
            values = {c: v for c in CHANNELS if (v := getattr(seen, c)) is not None}
            found[f"{name} in {engine}"] = {
                c: hashlib.sha256(np.ascontiguousarray(v).tobytes()).hexdigest()[:16] for c, v in values.items()
            }
    return found


def run_in(folder: Path, engines: list[str]) -> dict[str, dict[str, str]]:
    """Hashes by the sources in a folder, in a process of their own."""
    code = f"import sys; sys.path[:0] = [{str(folder)!r}, {str(Path(__file__).parent)!r}]\n"
    code += f"import json, same_bits; print(json.dumps(same_bits.digests({engines!r})))"
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    answer: dict[str, dict[str, str]] = json.loads(done.stdout.splitlines()[-1])
    return answer


def main() -> int:
    """Compare; prints one line a trajectory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("revision")
    parser.add_argument("engines", nargs="*", default=list(ENGINES))
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        tree = Path(scratch) / "tree"
        subprocess.run(["git", "worktree", "add", "-q", "--detach", tree, given.revision], cwd=ROOT, check=True)
        try:
            before = run_in(tree, given.engines)
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", tree], cwd=ROOT, check=True)
    now = run_in(ROOT, given.engines)
    changed = 0
    for key, channels in before.items():
        differ = [c for c, digest in channels.items() if now.get(key, {}).get(c) != digest]
        changed += bool(differ)
        print(f"{key}: {'DIFFERS in ' + ', '.join(differ) if differ else 'the same bits'}")
    print(f"{len(before) - changed} of {len(before)} trajectories are the same to the last bit")
    return 1 if changed else 0


if __name__ == "__main__":
    sys.exit(main())
