"""Programs and Python engines that misbehave, named on the command line: each command ends in short lines, in time."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest

from tests.support.command_ends import fault_of
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from pathlib import Path

LIMIT_S = 60.0
SCENE = "basics/two_bars_free"
ENTRIES = """
[[engine]]
name = "mine"
command = "{python} -I -S program.py {{request}} {{samples}} {{result}}"
effects = ["gravity.none", "gravity.point"]
rtol = [1e-8, 1e-10]
"""
HEAD = """
import os, sys, time
request, samples, result = sys.argv[1:]
def write(path, content):
    open(path, "wb").write(content)
"""
RESULTS = (
    "pass", "write(result, b'')", "write(result, b'{')", "write(result, b'[]')", r"write(result, b'\xff\xfe\x00')",
    "write(result, bytes(1 << 21))", "write(result, b'[' * 100000)", "os.mkdir(result)", "os.mkfifo(result)",
    "os.symlink('/dev/zero', result)", "os.symlink('nowhere', result)", "os.symlink(result, result)",
    """write(result, b'{"version": 1, "steps": %s}' % (b'9' * 5000))""",
    """write(result, b'{"version": 1, "samples": "/etc/passwd"}')""",
    r"""write(result, b'{"version": 1, "samples": "a\\u0000b"}')""",
    """write(result, b'{"version": 1, "outcome": "failed", "reason": "%s"}' % (b'x' * 100000))""",
    r"""write(result, b'{"version": 1, "outcome": "failed", "reason": "\\u001b[2J\\u202e\\n"}')""",
    r"""write(result, b'{"version": 1, "outcome": "unsupported", "reason": "\\ud800"}')""",
    """write(result, b'{"version": 1, "%s": 1}' % (b'k' * 100000))""",
)  # fmt: skip
"""What a program leaves in the place of its result"""
HEADER = "b't_s,com_x_m,com_y_m,com_vx_m_s,com_vy_m_s,angle_1_rad\\n'"
TABLES = (
    "pass", "write(samples, b'')", "write(samples, b'\\n')", r"write(samples, b'\xff\x00' * 1000)", "os.mkdir(samples)",
    "os.mkfifo(samples)", "os.symlink('/dev/zero', samples)", "os.symlink(samples, samples)",
    f"write(samples, {HEADER})",
    f"write(samples, {HEADER} + b'0,1,2,3,4,5,6\\n')", f"write(samples, {HEADER} + '٠,١,٢,٣,٤,٥\\n'.encode())",
    f"write(samples, {HEADER} + b'nan,inf,-inf,1e999,1e-999,\\n')", f"write(samples, {HEADER} + b'\\\"')",
    f"write(samples, {HEADER}.replace(b'_1_', '_١_'.encode()) + b'0,1,2,3,4,5\\n')",
    f"write(samples, {HEADER}.replace(b'_1_', b'_' + b'9' * 5000 + b'_') + b'0,1,2,3,4,5\\n')",
    f"write(samples, {HEADER} + b'0,1,2,3,4,' + b'9' * 10_000_000)", "write(samples, b'x,' * 100_000)",
    "write(samples, b''); os.truncate(samples, 1 << 33)",
)  # fmt: skip
"""What it leaves in the place of its samples, beside a result that passes"""
LINES = (
    "b'[1, 2]\\n'", "b'{\"t_s\": [1]}\\n'", "b'{\"t_s\": ' + b'9' * 400 + b'}\\n'", "b'[' * 100000",
    "b'\\xff'", "b'null\\n'", "b'{}\\n'",
)  # fmt: skip
"""Tables of JSON lines"""
ACTS = (
    "sys.exit(1)", "sys.exit(255)", "sys.exit('x' * 10**6)", "os.kill(os.getpid(), 6)", "os.kill(os.getpid(), 9)",
    "os.kill(os.getpid(), 11)", "time.sleep(1000)", "print('x' * 10**7)",
    "os.write(1, bytes(range(256)) * 1000); sys.exit(3)",
    "os.fork() or time.sleep(1000)", "os.closerange(0, 100); sys.exit(4)", "os.setsid(); time.sleep(1000)",
    "os.chmod('.', 0); sys.exit(5)", "import shutil; shutil.rmtree('.', ignore_errors=True)",
)  # fmt: skip
"""What it does instead"""
PASSES = """write(result, b'{"version": 1}')"""
PROGRAMS = (
    *RESULTS, *(f"{PASSES}; {each}" for each in TABLES), *ACTS,
    *(f"""write(result, b'{{"version": 1, "samples": "s.jsonl"}}'); write('s.jsonl', {each})""" for each in LINES),
)  # fmt: skip


@pytest.mark.parametrize("number", exhaustive_but(range(len(PROGRAMS)), [9, 39]))
def test_a_program_that_misbehaves_ends_its_run(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "program.py").write_text(HEAD + PROGRAMS[number])
    (tmp_path / "engines.toml").write_text(ENTRIES.format(python=sys.executable))
    line = f"simulate {SCENE} --engine mine --time-limit 3 --out run.csv"
    assert not fault_of(line.split(), capsys, LIMIT_S), PROGRAMS[number]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["engines.toml", "program.py"]
