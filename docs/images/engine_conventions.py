"""Picture of docs/explanation/engine_conventions.md: two bars, ends, angles, the horizontal, a reaction.

``python docs/images/engine_conventions.py`` writes the picture beside this script. A test compares both.
"""

from __future__ import annotations

import math
from pathlib import Path

WIDTH, HEIGHT = 860, 540
LONGITUDE_DEG = 60.0
ANGLES_DEG = (10.0, -45.0)  # of the worked example; sizes and places are not to scale
HALVES = (110.0, 170.0)  # pixels
MASS_SHARES = (0.25, 0.75)
REACTION_DEG = 1.4
COM = (400.0, 230.0)
RADIUS = 300.0  # pixels from the centre of the body to the centre of mass
Point = tuple[float, float]

STYLE = """
  .line, .bar, .thin, .dashed { fill: none; stroke: #24292f; }
  .bar { stroke-width: 9; stroke-linecap: round; stroke: #57606a; }
  .line { stroke-width: 1.6; } .thin { stroke-width: 1; } .dashed { stroke-width: 1; stroke-dasharray: 6 4; }
  .angle { fill: none; stroke: #0969da; stroke-width: 1.6; } .force { fill: none; stroke: #cf222e; stroke-width: 2.4; }
  .dot { fill: #24292f; } .hinge { fill: #ffffff; stroke: #24292f; stroke-width: 2; }
  text { font: 15px sans-serif; fill: #24292f; } .angles { fill: #0969da; } .forces { fill: #cf222e; }
  @media (prefers-color-scheme: dark) {
    .line, .thin, .dashed { stroke: #e6edf3; } .bar { stroke: #8b949e; } .dot { fill: #e6edf3; }
    .angle { stroke: #58a6ff; } .force { stroke: #ff7b72; } .hinge { fill: #0d1117; stroke: #e6edf3; }
    text { fill: #e6edf3; } .angles { fill: #58a6ff; } .forces { fill: #ff7b72; }
  }
"""


def along(start: Point, angle_deg: float, distance: float) -> Point:
    """Point at a distance from another; angles count counter-clockwise, and pixels count downwards."""
    a = math.radians(angle_deg)
    return start[0] + distance * math.cos(a), start[1] - distance * math.sin(a)


def line(kind: str, start: Point, end: Point) -> str:
    """Straight line."""
    return f'<path class="{kind}" d="M {start[0]:.1f} {start[1]:.1f} L {end[0]:.1f} {end[1]:.1f}"/>'


def arrow(kind: str, start: Point, angle_deg: float, length: float) -> str:
    """Straight arrow."""
    end = along(start, angle_deg, length)
    return line(kind, start, end) + head(kind, end, angle_deg)


def head(kind: str, tip: Point, angle_deg: float) -> str:
    """Head of an arrow."""
    sides = (along(tip, angle_deg + turn, 10.0) for turn in (155.0, -155.0))
    return "".join(line(kind, tip, side) for side in sides)


def arc(centre: Point, radius: float, start_deg: float, end_deg: float, kind: str = "angle") -> str:
    """Arrow along an arc."""
    begin, end = along(centre, start_deg, radius), along(centre, end_deg, radius)
    rising = end_deg > start_deg
    path = f"M {begin[0]:.1f} {begin[1]:.1f} A {radius} {radius} 0 0 {0 if rising else 1} {end[0]:.1f} {end[1]:.1f}"
    turn = math.degrees(5.0 / radius)  # the head is straight: it points to where the arc is a little earlier
    return f'<path class="{kind}" d="{path}"/>' + head(kind, end, end_deg + (90.0 - turn if rising else turn - 90.0))


def label(at: Point, text: str, kind: str = "", anchor: str = "start") -> str:
    """Text; a name before `_` is set above its index."""
    name, _, rest = text.partition("_")
    index, _, more = rest.partition(" ")
    lowered = f'{name}<tspan dy="4" font-size="11">{index}</tspan><tspan dy="-4"> {more}</tspan>' if index else name
    return f'<text class="{kind}" x="{at[0]:.1f}" y="{at[1]:.1f}" text-anchor="{anchor}">{lowered}</text>'


def places() -> tuple[Point, Point, Point]:
    """Left end of bar 1, the joint, and the right end of bar 2."""
    left = COM
    for j, angle in enumerate(ANGLES_DEG):  # the weighted mean of the centres is the centre of mass
        share = MASS_SHARES[j] + 2.0 * sum(MASS_SHARES[j + 1 :])
        left = along(left, angle, -HALVES[j] * share)
    joint = along(left, ANGLES_DEG[0], 2.0 * HALVES[0])
    return left, joint, along(joint, ANGLES_DEG[1], 2.0 * HALVES[1])


def picture() -> str:
    """Text of the SVG file."""
    parts = [*orbit(), *angles(), *bars(), *reaction()]
    size = f'width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"'
    body = "\n".join(f"  {part}" for part in parts)
    title = "<title>Two bars with their ends, angles, horizontal, joint and reaction</title>"
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n{title}\n<style>{STYLE}</style>\n{body}\n</svg>\n'


def orbit() -> list[str]:
    """Central body with the axes, the centre of mass, its velocity and its horizontal."""
    centre = along(COM, LONGITUDE_DEG, -RADIUS)
    return [
        arrow("line", centre, 0.0, 110.0), label((centre[0] + 116.0, centre[1] + 5.0), "z_1 "),
        arrow("line", centre, 90.0, 110.0), label((centre[0] - 6.0, centre[1] - 118.0), "z_2 "),
        f'<circle class="dot" cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="4"/>',
        label((centre[0] - 12.0, centre[1] + 24.0), "centre of the body", anchor="middle"),
        line("dashed", centre, COM), arc(centre, 52.0, 0.0, LONGITUDE_DEG),
        label((centre[0] + 54.0, centre[1] - 28.0), "longitude", "angles"),
        f'<circle class="dot" cx="{COM[0]:.1f}" cy="{COM[1]:.1f}" r="4"/>',
        label((COM[0] - 28.0, COM[1] + 26.0), "centre of mass", anchor="end"),
        arrow("line", COM, LONGITUDE_DEG + 90.0, 48.0),
        label((COM[0] - 46.0, COM[1] - 6.0), "v_0 ", anchor="end"),
        line("dashed", COM, along(COM, LONGITUDE_DEG - 90.0, 250.0)),
        label((COM[0] + 224.0, COM[1] + 126.0), "horizontal: radial direction − 90°"),
    ]  # fmt: skip


def bars() -> list[str]:
    """Both bars, their ends and centres, and the joint."""
    left, joint, right = places()
    centres = along(left, ANGLES_DEG[0], HALVES[0]), along(joint, ANGLES_DEG[1], HALVES[1])
    return [
        line("bar", left, joint), line("bar", joint, right),
        *(f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="3"/>' for x, y in centres),
        f'<circle class="hinge" cx="{joint[0]:.1f}" cy="{joint[1]:.1f}" r="7"/>',
        label((joint[0] - 4.0, joint[1] - 44.0), "joint 1", anchor="middle"),
        label((left[0], left[1] - 16.0), "left end", anchor="middle"),
        label((right[0] - 16.0, right[1] + 12.0), "right end", anchor="end"),
        label((centres[0][0] - 8.0, centres[0][1] - 14.0), "bar 1", anchor="middle"),
        label((centres[1][0] - 14.0, centres[1][1] + 26.0), "bar 2", anchor="end"),
    ]  # fmt: skip


def angles() -> list[str]:
    """Inertial angle of each bar from its left end, the initial angle of bar 1, and the sense of a positive rate."""
    left, joint, right = places()
    return [
        arrow("thin", left, 0.0, 200.0), line("dashed", left, along(left, LONGITUDE_DEG - 90.0, 130.0)),
        arc(left, 150.0, 0.0, ANGLES_DEG[0]), label((left[0] + 150.0, left[1] + 18.0), "θ_1 &gt; 0", "angles"),
        arc(left, 84.0, LONGITUDE_DEG - 90.0, ANGLES_DEG[0]),
        label((left[0] + 92.0, left[1] + 34.0), "φ_1 ", "angles"),
        arrow("thin", joint, 0.0, 330.0), arc(joint, 100.0, 0.0, ANGLES_DEG[1]),
        label((joint[0] + 102.0, joint[1] + 44.0), "θ_2 &lt; 0", "angles"),
        arc(right, 40.0, ANGLES_DEG[1] - 40.0, ANGLES_DEG[1] + 40.0),
        label((right[0] + 48.0, right[1] + 22.0), "rate &gt; 0", "angles"),
    ]  # fmt: skip


def reaction() -> list[str]:
    """The reaction on bar 1 from bar 2; bar 2 has the opposite one."""
    _, joint, _ = places()
    above = joint[0], joint[1] - 20.0
    return [
        arrow("force", above, REACTION_DEG, 90.0),
        label((above[0] + 98.0, above[1] + 2.0), "R_1 on bar 1 from bar 2, at joint 1", "forces"),
    ]


if __name__ == "__main__":
    Path(__file__).with_suffix(".svg").write_text(picture(), encoding="utf-8")
