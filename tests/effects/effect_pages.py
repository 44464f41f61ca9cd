"""What the pages in docs/effects have to say of keys and engines, made from the schema and the registry."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from adapters.registry import ENGINES
from scenarios import SceneFile
from scenarios.limits import MOST_MAGNITUDE

if TYPE_CHECKING:
    from collections.abc import Iterator

KEYS = "| key | default | allowed | unit |\n| --- | --- | --- | --- |"
UNITS = {
    "_kg_m3": "kg/m³", "_N_m_s_rad": "N m s/rad", "_N_m_rad": "N m/rad", "_rad_s": "rad/s", "_m3_s2": "m³/s²",
    "_Pa": "Pa", "_N_s": "N s", "_deg": "degrees", "_N": "N", "_m": "m", "_s": "s",
}  # fmt: skip
EFFECTS = {
    "gravity": "gravity", "oblateness": "oblateness", "third body": "third_body", "drag": "drag",
    "light": r"solar_pressure$", "shadow": r"solar_pressure\.shadow", "springs": "joint_spring_damper",
    "rotation": "prescribed_rotation", "thrust": "thrust", "impulse": "impulse",
}  # fmt: skip


def key_table(definition: str, *only: str) -> str:
    """Keys of a table of a scene file as its page shows them; some of them `only`."""
    schema = SceneFile.model_json_schema()["$defs"][definition]
    required = schema.get("required", [])
    rows = [
        f"| `{key}` | {default(found, key in required)} | {allowed(found)} | {unit(key)} |"
        for key, found in schema["properties"].items()
        if not only or key in only
    ]
    return "\n".join([KEYS, *rows])


def default(found: dict[str, Any], required: bool) -> str:
    """``required``, a value, or in words what is taken."""
    if required:
        return "required"
    value = found.get("default")
    if value is None:
        said = re.search(r"(?:^|[;,] )([^;,]+) by default", found.get("description", ""))
        return said[1] if said else "none"
    return plain(value)


def plain(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"{value:.9g}"


def allowed(found: dict[str, Any]) -> str:
    """Values that a key may have."""
    kinds = found.get("anyOf", found.get("oneOf", [found]))
    lists = [k for k in kinds if k.get("type") == "array"]
    single = [k for k in kinds if k.get("type") not in ("array", "null")]
    said = span(single[0]) if single else f"list of numbers {span(lists[0]['items'])}"
    return f"{said}, or a list" if single and lists else said


def span(kind: dict[str, Any]) -> str:
    """Values of one kind."""
    if "enum" in kind:
        return ", ".join(map(plain, kind["enum"]))
    if kind.get("type") == "boolean":
        return "`true`, `false`"
    kind = {k: v for k, v in kind.items() if not (k in ("minimum", "maximum") and abs(v) == MOST_MAGNITUDE)}
    if "exclusiveMinimum" in kind:
        return f"above {kind['exclusiveMinimum']:g}"
    if "minimum" in kind:
        return f"from {kind['minimum']:g}" + (f" to {kind['maximum']:g}" if "maximum" in kind else "")
    return "any number"


def unit(key: str) -> str:
    """Unit that a key's name ends with."""
    return next((said for end, said in UNITS.items() if key.endswith(end)), "")


def engine_table() -> str:
    """Which engine declares which effects; built on the reference or not, those that declare the same share a row.

    Raises
    ------
    ImportError
        If an engine is not installed.
    """
    rows: dict[tuple[bool, tuple[str, ...]], list[str]] = {}
    for name, registration in ENGINES.items():
        rows.setdefault((registration.ours, tuple(cells(registration.load().effects))), []).append(name)
    head = f"| engine | {' | '.join(EFFECTS)} |\n|{' --- |' * (len(EFFECTS) + 1)}"
    return "\n".join([head, *(f"| {', '.join(names)} | {' | '.join(found)} |" for (_, found), names in rows.items())])


def cells(carried: frozenset[str]) -> Iterator[str]:
    """Support by an engine of each kind of effect: yes, no, or which of them."""
    every = frozenset().union(*(r.load().effects for r in ENGINES.values()))
    for pattern in EFFECTS.values():
        kind = {name for name in every if re.match(pattern, name)}
        have = sorted(name.rpartition(".")[2] for name in kind & carried)
        yield "✓" if kind <= carried else ", ".join(have) or "–"
