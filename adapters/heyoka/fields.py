r"""Gravity fields in heyoka's equations: the central body, its oblateness and third bodies.

All accelerations are relative to a frame that falls like the chain's centre of mass in the same field. With z from the
attracting centre to the chain's, d the bar's offset, and

    y = |z|/|z + d| = 1/sqrt(1 + q),   q = (2 z + d)·d/|z|²,   1 - y = q y²/(1 + y),

a field that decreases with the power k + 1 of the distance differs between the two positions by

    z/|z|^(k+2) - (z + d)/|z + d|^(k+2) = (z (1 - y^(k+2)) - d y^(k+2))/|z|^(k+2)

where 1 - y^n = (1 - y)(1 + y + ... + y^(n-1)). A third body uses this twice: with z from the body to the central
one and d the chain's position for the frame, and again for each bar relative to the chain's centre.

*Second moment.* To second order in a bar's length, the potential -B/r^k per unit mass adds half of J times its second
derivative along the bar, -(B k/2)((k + 2) c² - 1) J/r^(k+2). Its derivatives, with p = (l/2) u and H = (l/2)², are

    force  (B k (k + 2) J/(2 H r^(k+4))) (2 (p·z) p + H z - (k + 4) (p·z)² z/r²)
    torque (B k (k + 2) J/(H r^(k+4))) (p·z)(p x z)

*Slender bar.* With its ends at distances a and b and S = a + b, the integral of mu s/|s|³ along it is, per unit mass,

    -G (z - (4/S²) (p·z) p),   G = 2 mu S/(a b (S² - l²)),   torque  m G (4/S²) (p·z)(p x z)

The ends are related to the chain's centre as bars' centres are above. With y1, y2 of the two ends, Y = y1 y2 and
e = l²/S² = 4 H Y²/(|z|² (y1 + y2)²),

    G = (mu/|z|³) 2 Y²/((y1 + y2)(1 - e)),
    mu/|z|³ - G = (mu/|z|³) (2 (1 - Y)(1 + Y) - (1 - y1) - (1 - y2) - e (y1 + y2))/((y1 + y2)(1 - e)),
    1 - Y = (1 - y1) + y1 (1 - y2)

so that the tide is as accurate as the ends' distances from the chain's centre.
"""

from __future__ import annotations

from dataclasses import dataclass

from adapters.heyoka.bars import Load, Pair, Symbol, SymbolicBar, cross


@dataclass(frozen=True)
class DistanceRatio:
    """Distance of a point from a centre relative to that of the chain's centre, which is at z from it."""

    q: Symbol
    """Square of the point's distance over |z|², less 1"""
    y: Symbol
    """|z| over the point's distance"""
    square: Symbol
    """y²"""

    @property
    def complement(self) -> Symbol:
        """Difference 1 - y."""
        return self.q * self.square / (1.0 + self.y)


def distance_ratio(z: Pair, r2: Symbol, d: Pair) -> DistanceRatio:
    """Distance ratio of the point at z + d."""
    q = ((2.0 * z[0] + d[0]) * d[0] + (2.0 * z[1] + d[1]) * d[1]) / r2
    y = (1.0 + q) ** -0.5
    return DistanceRatio(q, y, y * y)


def tide(z: Pair, pull: Symbol, d: Pair, near: DistanceRatio) -> tuple[Pair, Symbol]:
    """Acceleration at z + d less that at z by a point mass, and mu over the distance cubed; `pull` is mu/|z|³."""
    y, square = near.y, near.square
    cube = pull * (square * y)
    change = pull * (near.q * square * (square + y + 1.0) / (1.0 + y))
    return (z[0] * change - d[0] * cube, z[1] * change - d[1] * cube), cube


@dataclass(frozen=True)
class Attractor:
    """A point mass in one of the models of gravity."""

    z: Pair
    """Vector from the point mass to the chain's centre"""
    r2: Symbol
    pull: Symbol
    """mu/|z|³"""
    model: str
    """``point``, ``gradient``, ``quadrupole`` or ``slender``"""

    def load(self, bar: SymbolicBar) -> Load:
        """Load on a bar; its transverse acceleration is about the attracting centre."""
        if self.model == "slender":
            return self.slender_load(bar)
        z, d, reach = self.z, bar.offset, bar.reach
        near = distance_ratio(z, self.r2, d)
        push, cube = tide(z, self.pull, d, near)
        if self.model == "point":
            return Load(push)
        # rho: radial unit vector; psi: angle from rho to the bar; torque K = -3 (mu/r³) J sin(psi) cos(psi)
        x, y = z[0] + d[0], z[1] + d[1]
        to_sine, to_cosine = y * reach[0] - x * reach[1], x * reach[0] + y * reach[1]
        turn = Load(push, bar.slender * (to_sine * to_cosine * (cube * (near.square / self.r2))))
        if self.model == "gradient":
            return turn
        fifth = cube * (near.square / self.r2)
        return Load(push, turn.torque) + second_moment_push(bar, (x, y), fifth, near.square / self.r2, 1.0)

    def slender_load(self, bar: SymbolicBar) -> Load:
        """Exact gravity on a uniform bar."""
        (zx, zy), (dx, dy), (px, py) = self.z, bar.offset, bar.reach
        left, right = (distance_ratio(self.z, self.r2, d) for d in ((dx - px, dy - py), (dx + px, dy + py)))
        both, total = left.y * right.y, left.y + right.y
        ratio = 4.0 * (both * both / (self.r2 * total * total))  # 4/S²
        short = bar.half * bar.half * ratio
        scale = self.pull / (total * (1.0 - short))
        g = 2.0 * both * both * scale
        apart = left.complement + left.y * right.complement  # 1 - y1 y2
        change = scale * (2.0 * apart * (1.0 + both) - (left.complement + right.complement) - short * total)
        x, y = zx + dx, zy + dy
        along = g * ratio * (x * px + y * py)
        push = (zx * change - g * dx + along * px, zy * change - g * dy + along * py)
        transverse_acceleration = along * (x * py - y * px)
        return Load(push, -bar.mass * transverse_acceleration, transverse_acceleration)


def second_moment_push(bar: SymbolicBar, at: Pair, strength: Symbol, inverse2: Symbol, k: float) -> Load:
    """Force of a bar's second moment in the field of -B/r^k, at `at` from its centre.

    `strength` is B/r^(k+4), `inverse2` 1/r². `slender` is 3 J/H, and so k (k + 2) enters by its third: 1 or 5.
    """
    (x, y), (px, py) = at, bar.reach
    weight = 0.5 * THIRD[k] * (bar.slender / bar.mass) * strength
    along = x * px + y * py
    outward = weight * (bar.half * bar.half - (k + 4.0) * (along * along * inverse2))
    inward = weight * (2.0 * along)
    return Load((outward * x + inward * px, outward * y + inward * py), 0.0, inward * (x * py - y * px))


THIRD = {1.0: 1.0, 3.0: 5.0}  # k (k + 2)/3


@dataclass(frozen=True)
class Flattening:
    """Oblateness of the central body, -B/r³ per unit mass, to the order of the gravity model."""

    z: Pair
    r2: Symbol
    fifth: Symbol
    """B/|z|⁵"""
    model: str

    @property
    def frame(self) -> Pair:
        """Acceleration of the frame."""
        return -3.0 * self.fifth * self.z[0], -3.0 * self.fifth * self.z[1]

    def load(self, bar: SymbolicBar) -> Load:
        """Load on a bar."""
        (zx, zy), (dx, dy), (px, py) = self.z, bar.offset, bar.reach
        near = distance_ratio(self.z, self.r2, bar.offset)
        y, square = near.y, near.square
        power = 3.0 * self.fifth * (square * square * y)
        change = 3.0 * self.fifth * near.complement * (1.0 + y + square * (1.0 + y + square))
        push = Load((zx * change - dx * power, zy * change - dy * power))
        if self.model == "point":
            return push
        at = zx + dx, zy + dy
        inverse2 = square / self.r2
        seventh = self.fifth * (square * square * y) * inverse2
        torque = THIRD[3.0] * bar.slender * seventh * (at[0] * px + at[1] * py) * (at[1] * px - at[0] * py)
        push = push + Load((0.0, 0.0), torque)
        return push if self.model == "gradient" else push + second_moment_push(bar, at, seventh, inverse2, 3.0)


@dataclass(frozen=True)
class Companion:
    """A third body, relative to the central one."""

    frame: Pair
    """Acceleration of the chain's centre by the body less that of the central body"""
    attractor: Attractor

    def load(self, bar: SymbolicBar) -> Load:
        """Load on a bar."""
        found = self.attractor.load(bar)
        whole = (self.frame[0] + found.push[0], self.frame[1] + found.push[1])
        return Load(found.push, found.torque, cross(bar.position, whole))


def companion(centre: Pair, body: Pair, distance2: Symbol, pull: Symbol, model: str) -> Companion:
    """Third body at `body`; `pull` is mu_b/D³. Its gravity on slender bars is that of their second moment."""
    back = (-body[0], -body[1])
    frame, near_pull = tide(back, pull, centre, distance_ratio(back, distance2, centre))
    z = (centre[0] + back[0], centre[1] + back[1])
    attractor = Attractor(z, z[0] * z[0] + z[1] * z[1], near_pull, "quadrupole" if model == "slender" else model)
    return Companion(frame, attractor)
