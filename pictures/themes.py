"""Colours of a picture in both themes."""

from __future__ import annotations

from reports.plotting.palette import COLOURS, PAPER

THEMES = {"light": 0, "dark": 1}
OF_SCENES = ("ink", "muted", "grid", "rule", "body", "accent")


def theme_css(theme: str = "", used: tuple[str, ...] = OF_SCENES) -> dict[str, str]:
    """Declarations of colours, light and dark; both the same if a theme is named."""
    by_theme = {
        name: ";".join([f"--paper:{PAPER[k]}", *(f"--{c}:{(COLOURS[c].light, COLOURS[c].dark)[k]}" for c in used)])
        for name, k in THEMES.items()
    }
    return by_theme if not theme else dict.fromkeys(THEMES, by_theme[theme])
