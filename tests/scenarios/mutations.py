"""Mutations of a scene file: each key with each wild value, lines and bytes changed; the same in each session."""

import random
import re
from collections.abc import Iterator
from pathlib import Path

from scenarios import load

SOURCES = ("basics/libration", "paper/fig17", "effects/drag", "effects/thrust", "effects/solar_pressure", "hard/whip")
WILD = (
    "nan",
    "inf",
    "1e308",
    "0",
    "1",
    "2.5",
    "9" * 30,
    "9" * 5000,
    "0x" + "f" * 300,
    "true",
    '""',
    '"1.0"',
    '"\\u202e"',
    '"\\u0000"',
    '"' + "a" * 20_000 + '"',
    "[]",
    "[nan]",
    "[1.0, 2.0]",
    "[1.0, 'a']",
    "{a = 1}",
    "1979-05-27",
    "[" * 3000 + "]" * 3000,
    "[" + "1.0," * 50_000 + "]",
    "é",
    "",
)
EXTRA = (
    "x = 1",
    '"a\\u202eb" = 1',
    "a" * 50_000 + " = 1",
    "a" + ".b" * 3000 + " = 1",
    "[x]",
    "title = 'again'",
    "=",
    "\0",
    "\ufeff",
    "[run]\norbits = 1.0",
    "[effects.drag]",
    "[[effects.thrust]]",
)
SEED = 11


def source(name: str) -> str:
    """Text of a shipped scene."""
    return (Path(load.__file__).parent / f"{name}.toml").read_text(encoding="utf-8")


def keys(text: str) -> list[re.Match[str]]:
    """Keys with their values, a line each."""
    return list(re.finditer(r"^(\w+)\s*=\s*(.+)$", text, re.MULTILINE))


def of_values(text: str) -> Iterator[str]:
    """Each key with each wild value, and without itself, twice, misspelt."""
    for found in keys(text):
        before, after = text[: found.start()], text[found.end() :]
        for value in WILD:
            yield f"{before}{found[1]} = {value}{after}"
        yield before + after
        yield f"{before}{found[0]}\n{found[0]}{after}"
        yield f"{before}{found[0][1:]}{after}"


def of_lines(text: str) -> Iterator[str]:
    """Extra lines at each end, lines left out and in another order, the text cut off."""
    lines = text.split("\n")
    for line in EXTRA:
        yield f"{line}\n{text}"
        yield f"{text}\n{line}\n"
    for k in range(len(lines)):
        yield "\n".join(lines[:k] + lines[k + 1 :])
        yield "\n".join(lines[:k])
    yield "\n".join(reversed(lines))


def of_bytes(text: str, count: int) -> Iterator[bytes]:
    """Bytes changed, left out and added at random, and the text in other encodings."""
    draw = random.Random(SEED)
    whole = text.encode()
    for _ in range(count):
        at, new = draw.randrange(len(whole)), draw.randbytes(draw.choice((0, 1, 1, 2, 8)))
        yield whole[:at] + new + whole[at + draw.choice((0, 1, 5)) :]
    yield from (text.encode(name) for name in ("utf-16", "utf-32", "utf-8-sig", "utf-16-le"))
    yield from (whole.replace(b"=", b"\xff"), whole * 2, b"", b"\n" * 100_000, b"[" * 100_000, b'"""' * 10_001)


def mutations(name: str, drawn: int = 60) -> list[bytes]:
    """All mutations of a shipped scene."""
    text = source(name)
    made = [m.encode("utf-8", "surrogatepass") for m in (*of_values(text), *of_lines(text))]
    return [*made, *of_bytes(text, drawn)]
