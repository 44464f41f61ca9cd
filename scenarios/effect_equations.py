"""The effects in words and equations, so that a program in any language applies the same ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios.scene import Scene

NOTATION = """\
A plane with inertial axes z1 and z2, the centre of the central body as origin. Angles count from z1, counter-clockwise.
SI units. Bar j = 1..N has mass m, length l, moment of inertia J about its centre; h = l/2; Z is the place and V the
velocity of its centre, r = |Z|; theta its angle, u = (cos theta, sin theta), n = (-sin theta, cos theta). Its right end
is Z + h u, its left end Z - h u. Joint j ties the right end of bar j to the left end of bar j+1 and leaves their
rotation free. Z0, V0: place and velocity of the centre of mass of the whole chain. a x b = a1 b2 - a2 b1.
mu: mu_m3_s2 of the central body."""

MOTION = """\
R_j is the force on bar j from bar j+1 (R_0 = R_N = 0), F the sum of all forces on bar j, K of all torques:
    m Z'' = F + R_j - R_{j-1}
    J theta'' = K + h n . (R_j + R_{j-1})
and the two ends at every joint stay together."""

LEVERS = (
    "The centre of mass of bar j is not midway: with a = com_share_j l and b = l - a its right end is Z + b u and its "
    "left end Z - a u, where the laws have Z + h u and Z - h u. J theta'' = K + n . (b R_j + a R_{j-1}), and alike for "
    "an impulse at an end: b u x I at the right one, -a u x I at the left one, and n . (b P_j + a P_{j-1}). Z and J "
    "belong to the centre of mass."
)
"""Law of bars whose ends are at unequal distances from the centre of mass"""

LAWS: dict[str, str] = {
    "gravity.none": "No gravity.",
    "gravity.point": "F = -mu m Z/r^3; no torque.",
    "gravity.gradient": "F = -mu m Z/r^3; K = 3 mu J (u.Z)(n.Z)/r^5.",
    "gravity.quadrupole": (
        "F = -mu m Z/r^3 + (3 mu J/(2 r^5)) (2 (u.Z) u + Z - 5 c^2 Z) with c = u.Z/r; K = 3 mu J (u.Z)(n.Z)/r^5."
    ),
    "gravity.slender": (
        "Exact force and torque on a uniform slender bar. With p = u.Z, q = n.Z, a and b the distances of the bar's "
        "ends from the origin, S = a + b: F = -(2 mu m/(a b)) ((p/S) u + (q S/(S^2 - l^2)) n); "
        "K = 2 mu m p q l^2/(a b S (S^2 - l^2))."
    ),
    "prescribed_rotation": (
        "Bar `bar` (from 1) turns by a law: with s = (t - start_s)/duration_s, clipped to 0..1, its angle is the one "
        "at t = 0 plus amplitude_rad times (cos 3 pi s - 9 cos pi s + 8)/16 (course = paper) or "
        "10 s^3 - 15 s^4 + 6 s^5 (quintic), plus the same of each turn in `further`. course = spline: the quintic in s "
        "with the rates rates_rad_s and accelerations accelerations_rad_s2 at its ends. frame = inertial: it is theta. "
        "frame = local_horizontal: it is theta - omega, omega the longitude of the bar's own centre. "
        "frame = previous_bar: it is theta less theta of the bar before. The torque that makes the bar follow is "
        "unknown like the reactions. actuator = external: it acts on the bar alone; joint: a motor in the joint to the "
        "bar before (bar 1: to bar 2), which that neighbour feels with the opposite sign."
    ),
    "oblateness": (
        "With B = mu j2 radius_m^2/2 each bar has the further acceleration -3 B Z/r^5. With gravity gradient, "
        "quadrupole or slender also K = 15 B J (u.Z)(n.Z)/r^7. With quadrupole or slender also the acceleration "
        "(15 B J/(2 m r^7)) (Z + 2 (u.Z) u - 7 c^2 Z), c = u.Z/r."
    ),
    "third_body": (
        "A body of mu_m3_s2 = b moves on a circle of radius distance_m: X = D (cos L, sin L), "
        "L = longitude_rad + rate_rad_s t. With Y = Z - X each bar has the further acceleration "
        "-b (Y/|Y|^3 + X/|X|^3). With gravity gradient, quadrupole or slender also K = 3 b J (u.Y)(n.Y)/|Y|^5. With "
        "quadrupole or slender also the force (3 b J/(2 |Y|^5)) (2 (u.Y) u + Y - 5 (u.Y/|Y|)^2 Y)."
    ),
    "drag": (
        "Flat bar of width_m = b in free-molecular flow. W = V - rotation_rad_s (-Z2, Z1); v = n.W, s = u.W, "
        "w = theta' - rotation_rad_s; rho = density_kg_m3 exp(-(r - R - altitude_m)/H), R the radius of the central "
        "body, H = scale_height_m; k = u.Z/(r H), I = l^3/12, I4 = l^5/80, Cn and Ct the coefficients. "
        "F = -(b/2) rho sign(v) (Cn (l v^2 + I w^2 - 2 k I v w) n + Ct s (l v - k I w) u); "
        "K = -(b/2) rho sign(v) Cn (2 I v w - k (I v^2 + I4 w^2))."
    ),
    "solar_pressure": (
        "With s the unit vector at sun_longitude_rad + sun_rate_rad_s t, k = |n.s|, n' = n where n.s > 0 and -n "
        "otherwise: F = -pressure_Pa width_m l k ((1 - reflectivity) s + 2 reflectivity k n'); no torque. With shadow: "
        "no light on the whole chain while Z0.s < 0 and |Z0 x s| < radius_m of the central body."
    ),
    "joint_spring_damper": (
        "Joint j turns bar j+1 by -stiffness (D - rest_rad) - damping D', D = theta_{j+1} - theta_j (not wrapped), and "
        "bar j by the opposite."
    ),
    "joint_torque": (
        "A motor in joint j = `joint` (from 1) turns bar j+1 by a torque and bar j by the opposite. "
        "The torque is linear between the points (times_s, torque_N_m), jumps where two instants are equal, and is "
        "zero outside."
    ),
    "thrust": (
        "Force at an end of bar `bar` (from 1): right Z + h u, left Z - h u. Its size is linear between the points "
        "(times_s, force_N) and zero outside. A sample where it jumps shows the motion just before; at t = 0, just "
        "after. Its direction is direction_rad from u (axes = body) or from z1 (inertial)."
    ),
    "impulse": (
        "At at_s velocities jump by an impulse impulse_N_s at an end of bar `bar`, with direction as a thrust's; "
        "joints hold: m dV = I + P_j - P_{j-1}, J dtheta' = +-h u x I + h n.(P_j + P_{j-1}), P_j the impulsive "
        "reaction on bar j from bar j+1; prescribed bars keep their law's rate. A sample at at_s shows "
        "the state just before."
    ),
}  # fmt: skip
"""Law of each kind of effect; of gravity, of each model"""


def laws_of(scene: Scene) -> dict[str, str]:
    """Laws of the effects that a scene has.

    Returns
    -------
    dict of str to str
        By the effect's key in the scene; gravity first, and before it `com_share` of a chain that has it.
    """
    effects = scene.effects
    others = [name for name in LAWS if not name.startswith("gravity.") and getattr(effects, name)]
    found = {"com_share": LEVERS} if scene.chain.com_share else {}
    return found | {"gravity": LAWS[f"gravity.{effects.gravity}"]} | {name: LAWS[name] for name in others}
