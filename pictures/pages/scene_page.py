"""Page of one scene: picture, reason, physics, certified solution, and what each engine makes of it."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

from pictures.pages.libraries import LIBRARIES
from pictures.pages.words import cell, errors, growth_text, outcome_text, short, stability_text, table
from pictures.paths import DOCS, ENGINE_PAGES, GALLERY
from pictures.record.certified import SHIPPED, TABLE
from pictures.templating import render
from reports.results.cost import KINDS as HEADINGS
from reports.results.cost import OWN_EQUATIONS
from reports.text.numerals import each

if TYPE_CHECKING:
    from pathlib import Path

    from pictures.pages.record import MeasuredRecord
    from scenarios import Scene

EFFECT_PAGES = {"gravity": "gravity", "impulse": "thrust", "thrust": "thrust"}
"""Pages of effects that are not named like the effect"""
KINDS = ((True, "Independent physics"), (False, HEADINGS[OWN_EQUATIONS]))
HARD = "hard/"
LEAST_ORBITS = 0.01  # below, seconds say more


def scene_page(scene: Scene, alt: str, measured: MeasuredRecord) -> str:
    """Markdown of a scene's page."""
    page = page_of(scene.name)
    return render(
        "scene.md.j2",
        scene=scene,
        folder=scene.name.partition("/")[0],
        file=page.with_suffix(".svg").name,
        alt=alt,
        facts=table(("physics", "value"), facts(scene, page)),
        certified=certified_sentences(scene, measured),
        certified_page=link(page, DOCS / "explanation" / "certified_solutions.md"),
        hard=scene.name.startswith(HARD),
        tables=engine_tables(scene, measured),
        runs=measured.runs,
        stability_page=link(page, DOCS / "studies" / "stability.md"),
        verdicts_page=link(page, DOCS / "explanation" / "verdicts.md"),
    )


def page_of(scene: str) -> Path:
    """File of a scene's page."""
    return GALLERY / f"{scene}.md"


def link(page: Path, target: Path) -> str:
    """Link from a page to another file."""
    return os.path.relpath(target, page.parent).replace(os.sep, "/")


def facts(scene: Scene, page: Path) -> list[tuple[str, str]]:
    """Physics of the scene in two columns."""
    return [
        ("bars", str(scene.bars) + "".join(f", bar {bar} an end body" for bar in scene.chain.bodies)),
        ("masses", each(scene.chain.mass_kg, "kg")),
        ("lengths", each(scene.chain.length_m, "m")),
        *([("centres of mass", each(scene.chain.left_m, "m from the left end"))] if scene.chain.com_share else []),
        ("orbit", orbit_text(scene)),
        ("duration", f"{duration_text(scene)}, {scene.run.samples} samples"),
        ("gravity and effects", ", ".join(effect_links(scene, page))),
        ("tags", ", ".join(scene.tags)),
    ]


def orbit_text(scene: Scene) -> str:
    """Injection in words."""
    if scene.effects.gravity.value == "none":
        return "none: free space"
    start = f"from {scene.orbit.altitude_m / 1e3:,.10g} km altitude".replace(",", " ")
    factor, path = scene.orbit.speed_factor, math.degrees(scene.orbit.flight_path_rad)
    speed = f"{start}, at {'' if factor == 1.0 else f'{factor:.6g} times '}the local circular speed"
    return speed + (f", {abs(path):.4g}° {'above' if path > 0.0 else 'below'} the horizontal" if path else "")


def duration_text(scene: Scene) -> str:
    """Duration in orbits and seconds."""
    seconds = f"{short(scene.run.duration_s)} s"
    orbits = scene.run.duration_s / scene.period_s
    return (
        f"{short(orbits)} orbit{'s'[: orbits != 1.0]} ({seconds})" if scene.bound and orbits > LEAST_ORBITS else seconds
    )


def effect_links(scene: Scene, page: Path) -> list[str]:
    """Effects, each linked to its page."""
    names = sorted(scene.effects.names, key=lambda name: (not name.startswith("gravity"), name))
    return [
        f"[{name.replace('.', ': ').replace('_', ' ')}]({link(page, DOCS / 'effects' / effect_file(name))})"
        for name in names
    ]


def effect_file(name: str) -> str:
    """File of an effect's page."""
    first = name.partition(".")[0]
    return f"{EFFECT_PAGES.get(first, first)}.md"


def certified_sentences(scene: Scene, measured: MeasuredRecord) -> list[str]:
    """Sentences on the scene's certified solution."""
    row = measured.certified.get(scene.name, {})
    source = row.get("source", "")
    if source not in (SHIPPED, TABLE):
        return [
            "No certified solution comes with barchain; the reference solution judges.",
            *hard_sentences(scene, measured),
        ]
    where = "at all samples" if source == SHIPPED else "at 21 instants of the whole run and 21 of its first orbit"
    bars = ", ".join(error_bars(row))
    found = [f"A certified solution comes with barchain, {where}. Its largest error bars are {bars}."]
    if row["amplification"] is not None:
        found.append(f"A small perturbation of the attitude grows up to {growth_text(row['amplification'])} times.")
    return found + hard_sentences(scene, measured)


def error_bars(row: dict[str, Any]) -> list[str]:
    """Error bars of a certified solution, each with its quantity."""
    known = (("attitude_error_rad", "rad"), ("reaction_error_N", "N"), ("com_error_m", "m"))
    words = {"rad": "of the attitude", "N": "of the reactions", "m": "of the centre of mass"}
    return [f"{short(row[name], unit)} {words[unit]}" for name, unit in known if row[name] is not None]


def hard_sentences(scene: Scene, measured: MeasuredRecord) -> list[str]:
    """Predictability limit, growth and condition of a hard scene, as the stability study measured them."""
    row = measured.hard.get(scene.name)
    if row is None or row["limit_s"] is None:
        return []
    whole = row["limit_s"] >= scene.run.duration_s * (1.0 - 1e-9)
    limit = "not before the end of the run" if whole else f"after {short(row['limit_s'], 's')}"
    found = [f"The reference solution reaches its predictability limit {limit}."]
    if row["amplification"] is not None:
        found.append(f"A small perturbation grows {growth_text(row['amplification'])} times to the end.")
    if row["condition_high"] is not None:
        found.append(f"The condition number of the joint system is at most {short(row['condition_high'])}.")
    return found


def engine_tables(scene: Scene, measured: MeasuredRecord) -> list[tuple[str, str, str]]:
    """Heading, table and reasons of each kind of engines; kinds without a result are left out."""
    found = []
    for external, heading in KINDS:
        names = [(lib.page, e) for lib in LIBRARIES for e, r in lib.engines.items() if r.external is external]
        made = stability_rows if scene.name.startswith(HARD) else comparison_rows
        head, lines = made(scene, names, measured)
        if lines:
            found.append((heading, table(head, lines), reasons(scene, [engine for _, engine in names], measured)))
    return found


def reasons(scene: Scene, engines: list[str], measured: MeasuredRecord) -> str:
    """List of the reasons of outcomes below a table: sentences make its last column leave the page."""
    known: dict[str, list[str]] = {}
    for engine in engines:
        row = measured.comparison.get((scene.name, engine))
        why = str(row["reason"]) if row else measured.reasons.get((scene.name, engine), "")
        if why:
            known.setdefault(why, []).append(engine)
    return "\n".join(f"- {', '.join(names)}: {cell(why)}" for why, names in known.items())


def engine_link(scene: Scene, page: str, engine: str) -> str:
    """Engine linked to the page of its library."""
    return f"[{engine}]({link(page_of(scene.name), ENGINE_PAGES / f'{page}.md')})"


def comparison_rows(
    scene: Scene, names: list[tuple[str, str]], measured: MeasuredRecord
) -> tuple[tuple[str, ...], list[list[str]]]:
    """Head and rows of a compared scene."""
    head = (
        "engine",
        "setting",
        "outcome",
        "largest difference:",
        "reactions:",
        "detection limit:",
        "compared to:",
    )
    lines = []
    for page, engine in names:
        row = measured.comparison.get((scene.name, engine))
        if row is not None:
            name = engine_link(scene, page, engine)
            limit = "" if row["limit_s"] is None else compared_to(scene, row["limit_s"])
            numbers = [errors(row), short(row["reaction_N"], "N"), short(row["detection_limit"]), limit]
            lines.append([name, row["setting"], outcome_text(row["outcome"]), *numbers])
    return head, lines


def compared_to(scene: Scene, limit_s: float) -> str:
    """Predictability limit of a comparison."""
    if limit_s >= scene.run.duration_s * (1.0 - 1e-2):
        return "end"
    return f"{limit_s / scene.period_s:.2g} orbits" if scene.bound else short(limit_s, "s")


def stability_rows(
    scene: Scene, names: list[tuple[str, str]], measured: MeasuredRecord
) -> tuple[tuple[str, ...], list[list[str]]]:
    """Head and rows of a hard scene."""
    pairs = [(page, e, measured.stability.get((scene.name, e), "")) for page, e in names]
    lines = [[engine_link(scene, page, e), stability_text(word)] for page, e, word in pairs if word]
    return ("engine", "outcome"), lines
