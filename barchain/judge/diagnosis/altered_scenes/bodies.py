"""Wrong masses, lengths and moments of inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.judge.diagnosis.altered_scenes.changes import part, per_bar, reversed_tuple, times
from barchain.judge.diagnosis.mistake import SceneMistake

if TYPE_CHECKING:
    from scenarios import Scene

SECTION = "masses-lengths-and-inertia"


def inertia_about_end(scene: Scene, bar: int) -> float:
    """Moment of inertia about the bar's end, kg m²."""
    return scene.chain.inertia_kg_m2[bar] + scene.chain.mass_kg[bar] * scene.chain.length_m[bar] ** 2 / 4.0


def slender_inertia(scene: Scene, bar: int) -> float:
    """Moment of inertia of a slender uniform bar, m l²/12, kg m²."""
    return scene.chain.mass_kg[bar] * scene.chain.length_m[bar] ** 2 / 12.0


def slender_inertia_about_end(scene: Scene, bar: int) -> float:
    """Moment of inertia of a slender uniform bar about its end, m l²/3, kg m²."""
    return 4.0 * slender_inertia(scene, bar)


def inertia_of_opposite_mass(scene: Scene, bar: int) -> float:
    """Moment of inertia that the bar has with the mass of the bar at the same place from the other end, kg m²."""
    mass = scene.chain.mass_kg
    return scene.chain.inertia_kg_m2[bar] * mass[scene.bars - 1 - bar] / mass[bar]


def mean_mass(scene: Scene, _: int) -> float:
    """Mean mass of the bars, kg."""
    return scene.mass_kg / scene.bars


def mean_length(scene: Scene, _: int) -> float:
    """Mean length of the bars, m."""
    return scene.size_m / scene.bars


ALL_REVERSED = part(
    "chain", mass_kg=reversed_tuple("mass_kg"), length_m=reversed_tuple("length_m"),
    inertia_kg_m2=reversed_tuple("inertia_kg_m2"),
)  # fmt: skip
MISTAKES = (
    SceneMistake(
        "masses-in-reversed-order", "the masses are in reversed order", SECTION,
        part("chain", mass_kg=reversed_tuple("mass_kg")),
    ),
    SceneMistake(
        "lengths-in-reversed-order", "the lengths are in reversed order", SECTION,
        part("chain", length_m=reversed_tuple("length_m")),
    ),
    SceneMistake(
        "inertias-in-reversed-order", "the moments of inertia are in reversed order", SECTION,
        part("chain", inertia_kg_m2=reversed_tuple("inertia_kg_m2")),
    ),
    SceneMistake(
        "masses-and-inertias-in-reversed-order", "the masses and moments of inertia are in reversed order", SECTION,
        part("chain", mass_kg=reversed_tuple("mass_kg"), inertia_kg_m2=reversed_tuple("inertia_kg_m2")),
    ),
    SceneMistake(
        "masses-reversed-with-inertias", "the masses are in reversed order, in the moments of inertia too", SECTION,
        part("chain", mass_kg=reversed_tuple("mass_kg"), inertia_kg_m2=per_bar(inertia_of_opposite_mass)),
    ),
    SceneMistake(
        "properties-in-reversed-order", "the masses, lengths and moments of inertia are in reversed order", SECTION,
        ALL_REVERSED,
    ),
    SceneMistake("mean-masses", "the bars all have the mean mass", SECTION, part("chain", mass_kg=per_bar(mean_mass))),
    SceneMistake(
        "mean-lengths", "the bars all have the mean length", SECTION, part("chain", length_m=per_bar(mean_length))
    ),
    SceneMistake(
        "inertia-about-end", "the moments of inertia are those about the bars' ends", SECTION,
        part("chain", inertia_kg_m2=per_bar(inertia_about_end)),
    ),
    SceneMistake(
        "inertia-slender", "the moments of inertia are those of slender bars, not the given ones", SECTION,
        part("chain", inertia_kg_m2=per_bar(slender_inertia)),
    ),
    SceneMistake(
        "inertia-slender-about-end", "the moments of inertia are those of slender bars about their ends", SECTION,
        part("chain", inertia_kg_m2=per_bar(slender_inertia_about_end)),
    ),
    *(
        SceneMistake(
            f"inertia-{name}", f"the moments of inertia are {word} the right values", SECTION,
            part("chain", inertia_kg_m2=times("inertia_kg_m2", factor)),
        )
        for factor, name, word in ((0.25, "quarter", "a quarter of"), (0.5, "half", "half"), (2.0, "twice", "twice"))
    ),
    *(
        SceneMistake(
            f"lengths-{word}", f"the lengths are {word} the right values", SECTION,
            part("chain", length_m=times("length_m", factor)),
        )
        for factor, word in ((0.5, "half"), (2.0, "twice"))
    ),
)  # fmt: skip
