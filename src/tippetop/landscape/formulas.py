"""The potential of a top in a variable that keeps its digits at both poles, and its minimal surface. [section 5, 8]

Instead of z = cos(theta) the formulas take q = tan(theta/2)^2, 0 < q < oo: 1 - z = 2q/(1 + q), 1 + z = 2/(1 + q), and
dz/dln(q) = -(1 - z^2)/2. The lean X = lambda sqrt(d) + R(alpha - z) D is carried by its values at the poles,
a ~ X(+1) and b ~ X(-1): with K from d = (1 - z^2)(h^2 + K), h linear in 1/sqrt(q) and sqrt(q),

    X/sqrt(1 - z^2) ~ (a + b q + k psi)/sqrt(q),    psi = K q/(h + sqrt(h^2 + K q)),

and nothing cancels, neither at the poles nor on the marked lines a = 0 and b = 0. K ~ -chi vanishes for sqrt(d) linear
in z. Heavy tops are the case K = 0, d = 1, seen upside down: q = cot(theta/2)^2. Squares are in joules.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..mechanics.contact.body import height_energy
from ..mechanics.doubledouble import Two, minus, plus, quotient, scaled, tidy, times, two
from ..mechanics.operand import Operand, formula, product_error, sqrt
from ..mechanics.systems import heavy_top, tippe_top


class Relief(NamedTuple):
    """What the potential of one body is made of; first and second momentum are (D, lambda), or (L3, Lz)."""

    floor: Two  # energy of weight at q = 0 [J]
    rise: Two  # what it gains up to q = oo [J]
    gamma: Two
    root_gamma: Two
    sigma: Two
    slant: Two  # sigma/gamma
    root_rise: Operand  # sqrt(gamma rise) [sqrt(J)]
    near: Two  # alpha - 1
    far: Two  # alpha + 1
    d0: Two  # sqrt(d) at q = 0
    d1: Two  # sqrt(d) at q = oo
    K: Two
    a1: Two  # a = a1 first + a2 second [sqrt(J)]
    a2: Two
    b1: Two
    b2: Two
    k: Two  # k second, times psi, is the bow of X [sqrt(J)]
    spin: Two  # (spin first)^2 - (skid second)^2 is gamma times what V has besides weight and X^2 [J]
    skid: Two


class Lean(NamedTuple):
    """A point (D, lambda) in the terms of the relief [sqrt(J)]."""

    a: Two
    b: Two
    k: Two
    spin: Two
    offset: Two  # what gamma V has besides weight and X^2 [J]


def tippe_top_relief(b) -> Relief:
    """The relief of a tippe top; feed a body of decimals, and no digit is lost (the marked lines cancel)."""
    gamma, sigma, alpha = b.I1 / b.I3, b.m * b.R**2 / b.I3, b.c / b.R
    d0, d1 = sqrt(tippe_top.d(1, b)), sqrt(tippe_top.d(-1, b))
    per = 2 * b.R * sqrt(2 * b.I1)
    return Relief(
        floor=height_energy(1, b),
        rise=2 * b.m * b.g * b.c,
        gamma=gamma,
        root_gamma=sqrt(gamma),
        sigma=sigma,
        slant=sigma / gamma,
        root_rise=sqrt(2 * gamma * b.m * b.g * b.c),
        near=alpha - 1,
        far=alpha + 1,
        d0=d0,
        d1=d1,
        K=(gamma - sigma * (1 - alpha) * (1 + alpha) - d0 * d1) / 2 + sigma * gamma,
        a1=(b.c - b.R) / per,
        a2=d0 / per,
        b1=(b.c + b.R) / per,
        b2=d1 / per,
        k=1 / per,
        spin=1 / sqrt(2 * b.I3),
        skid=sqrt(sigma / (2 * b.I3)) / b.R,
    )


def heavy_top_relief(b) -> Relief:
    """The relief of both heavy tops, seen upside down: q = cot(theta/2)^2, momenta (L3, Lz)."""
    zero, one, per = 0 * b.m, 1 + 0 * b.m, 2 * sqrt(2 * heavy_top.tip_inertia(b))
    return Relief(
        floor=b.m * b.g * b.c,
        rise=-2 * b.m * b.g * b.c,
        gamma=one,
        root_gamma=one,
        sigma=zero,
        slant=zero,
        root_rise=sqrt(-2 * b.m * b.g * b.c),
        near=zero,
        far=zero,
        d0=one,
        d1=one,
        K=zero,
        a1=1 / per,
        a2=1 / per,
        b1=-1 / per,
        b2=1 / per,
        k=zero,
        spin=1 / sqrt(2 * b.I3),
        skid=zero,
    )


def rounded(r: Relief) -> Relief:
    """A relief of decimals in doubles, single or twofold as its fields say."""
    parts: Any = (two(x) if Relief.__annotations__[name] is Two else float(x) for name, x in r._asdict().items())
    return Relief(*parts)


@formula
def lean(first, second, r):
    """The point (D, lambda) in the terms of the relief; exact to one rounding also where a or b nearly cancels."""
    spin, skid = scaled(first, r.spin), scaled(second, r.skid)
    return Lean(
        tidy(plus(scaled(first, r.a1), scaled(second, r.a2))),
        tidy(plus(scaled(first, r.b1), scaled(second, r.b2))),
        scaled(second, r.k),
        spin,
        minus(times(spin, spin), times(skid, skid)),
    )


@formula
def bow(q, p, r):
    """2 psi sqrt(q), twofold: the root of psi (psi + 2h) = 4 K q with h twice that of above, times sqrt(q)."""
    Kq = scaled(4 * q, r.K)
    h = plus(r.d0, scaled(q, r.d1))
    e = sqrt(h.head * h.head + Kq.head)
    he = h.head + e
    per = 1 / (he * e)
    psi = Kq.head * (e * per)
    u = plus(Two(psi, 0.0), scaled(2.0, h))
    rest = ((Kq.head - psi * u.head) - product_error(psi, u.head)) + (Kq.tail - psi * u.tail)
    return Two(psi, rest * (0.5 * he * per))


@formula
def squares(psi, q, p, r):
    """Y^2 + q offset [J], given the bow."""
    Y = plus(plus(p.a, scaled(q, p.b)), times(p.k, psi))
    return plus(times(Y, Y), scaled(q, p.offset))


@formula
def total(motion, q, p, r):
    """Weight and motion [J], given the squares."""
    t, gq = plus(Two(1.0, 0.0), Two(q, 0.0)), scaled(q, r.gamma)  # 1 + q = 2/(1 + z)
    per = 1 / (t.head * gq.head)
    weight = quotient(scaled(q, r.rise), t, gq.head * per)
    return plus(plus(r.floor, weight), quotient(motion, gq, t.head * per))


@formula
def potential(q, p, r):
    """V [J] at q of the point p, twofold: weight and (Y^2/q + offset)/gamma. [equal to T 4.12, 2.38]"""
    return total(squares(bow(q, p, r), q, p, r), q, p, r)


@formula
def rounded_total(motion, q, p, r):
    """Weight and motion [J] in one double, given the squares."""
    V = total(motion, q, p, r)
    return V.head + V.tail


@formula
def value(q, p, r):
    """V [J] at q of the point p, to one rounding."""
    V = potential(q, p, r)
    return V.head + V.tail


@formula
def excess(q, level, p, r):
    """V - level [J], to one rounding also where they nearly agree."""
    V = potential(q, p, r)
    return (V.head - level) + V.tail


@formula
def gradient(q, p, r):
    """dV/dD, dV/dlambda at q (for heavy tops dV/dL3, dV/dLz): that of the minimal surface where q is its minimum."""
    K, d0, d1q = r.K.head, r.d0.head, r.d1.head * q
    h = d0 + d1q
    bow = r.k.head * (4 * K * q / (h + sqrt(h * h + 4 * K * q)))
    t = 1 + q
    y1, y2 = r.a1.head + r.b1.head * q, r.a2.head + r.b2.head * q + bow  # Y by D and lambda
    Y = (p.a.head + q * p.b.head) + 4 * p.k.head * K * q / (h + sqrt(h * h + 4 * K * q))
    arm = r.far.head * q + r.near.head
    roll = arm * Y + 2 * q * r.root_gamma.head * p.spin.head
    per = 2 / (q * (r.gamma.head * t * t + r.sigma.head * (arm * arm + 4 * q * r.gamma.head)))
    twist = 2 * q * r.root_gamma.head
    by_Y, by_roll = t * t * Y, r.slant.head * roll
    by_spin = t * t * q * p.spin.head * r.spin.head
    return (
        per * (by_Y * y1 + by_spin + by_roll * (arm * y1 + twist * r.spin.head)),
        per * (by_Y * y2 + by_roll * (arm * y2)),
    )


class Frame(NamedTuple):
    """What the slopes at q are made of besides the point."""

    psi: Operand  # the bow of Y [sqrt(J)], and how it bends
    n: Operand
    s: Operand
    c: Operand  # (1 + z)/2


@formula
def frame(q, p, r):
    """The first stage of the slopes: all divisions, in one, and the root."""
    K, d0, d1q = r.K.head, r.d0.head, r.d1.head * q
    h = (d0 + d1q) / 2
    e = sqrt(h * h + K * q)
    he, t = h + e, 1 + q
    per = 1 / (e * he * t)
    per_e = he * t * per
    return Frame(2 * p.k.head * K * q * (e * t * per), h * per_e, (d1q - d0) * (0.25 * per_e), e * he * per)


@formula
def slopes_in(f, q, p, r):
    """The second stage of the slopes."""
    psi, n, s = f.psi, f.n, f.s
    turn = n * (0.25 - s * s)  # s'; n' = s (1 - n^2) and psi' = -s psi
    turn2 = s * ((1 - n * n) * (0.25 - s * s) - 2 * n * turn)
    a, bq = p.a.head, p.b.head * q
    Y, Y1 = (a + bq) + psi, (bq - a) / 2 - s * psi
    Y2, Y3 = (a + bq) / 4 + psi * (s * s - turn), (bq - a) / 8 + psi * (s * (3 * turn - s * s) - turn2)
    y = q * f.c
    yc = y * f.c
    weight = r.gamma.head * r.rise.head * q * yc
    return (
        weight + 2 * Y * Y1,
        weight * (f.c - y) + 2 * (Y1 * Y1 + Y * Y2),
        weight * (1 - 6 * yc) + 6 * Y1 * Y2 + 2 * Y * Y3,
    )


@formula
def slopes(q, p, r):
    """q gamma times the first three derivatives of V by ln(q) [J]; the first is -N(z)/(1 - z^2) but for a factor."""
    return slopes_in(frame(q, p, r), q, p, r)


@formula
def bend(q, p, r):
    """Second derivative of V by ln(q) [J]; at the minimum d2V/dtheta2 is 4/sin(theta)^2 times this."""
    return slopes(q, p, r)[1] / (q * r.gamma.head)


@formula
def tilt(p, r):
    """a and b with the bow of X added at the pole where it counts: there they are X(+-1)' in place of X(-+1)."""
    a, b = abs(p.a.head), abs(p.b.head)
    bow = 2 * p.k.head * r.K.head / ((r.d0.head * b + r.d1.head * a) * (a + b))
    return abs(p.a.head + bow * a * a), abs(p.b.head + bow * b * b)


class Sketch(NamedTuple):
    """q of the minimum, roughly, and the a and b that it is sketched with."""

    q: Operand
    a: Operand
    b: Operand


@formula
def rough(p, r):
    """q of the minimum to a factor of about two: the root of q (b + g/(1 + q)) = a, a quadratic."""
    a, b = tilt(p, r)
    t = r.root_rise + b - a
    w = sqrt(t * t + 4 * a * b)
    above, below = (2 * a, t + w) if t > 0 else (w - t, 2 * b)
    return Sketch(above / below, a, b)


@formula
def sharper(k, p, r):
    """One of Halley's steps in ln(q) towards the minimum for K = 0: the root of (b q)^2 + (g q/(1 + q))^2 = a^2."""
    t = 1 + k.q  # the function times t^2, its derivatives times t^3, t^4
    bq, gq = k.b * k.q * t, r.root_rise * k.q
    B, G = bq * bq, gq * gq
    f0, f1, f2 = (B - (k.a * t) ** 2) + G, 2 * (B * t + G), 4 * (B * t * t + G) - 2 * G * k.q
    n, m = f0 * f1 * t, 2 * f1 * f1 - f0 * f2
    return Sketch(k.q * ((m - n) / (m + n)), k.a, k.b)


@formula
def sharpest(k, p, r):
    """The last stage of the guess."""
    return sharper(k, p, r).q


@formula
def guess(p, r):
    """q of the minimum to some 1e-3 where K is small."""
    return sharpest(sharper(rough(p, r), p, r), p, r)


@formula
def ends(first, second, p, r):
    """Is the infimum approached at q -> 0, at q -> oo? So it is on the marked lines, to a rounding of D and lambda."""
    little = 4 * 2.220446049250313e-16
    a = abs(p.a.head + 2 * p.k.head * r.K.head / r.d1.head)  # that of `tilt` for b = 0
    return (
        abs(p.a.head) <= little * abs(r.a2.head * second),
        (abs(p.b.head) <= little * abs(r.b2.head * second)) & (a >= r.root_rise),
    )


# what may be worked stage by stage: each takes the result of the one before it, then what the whole takes
STAGES: dict[str, tuple[Callable, ...]] = {
    "guess": (rough, sharper, sharpest),
    "slopes": (frame, slopes_in),
    "value": (bow, squares, rounded_total),
}


class Shape(NamedTuple):
    """How a system's potential is seen as a relief."""

    body: Callable  # body(parameters, friction) -> Body
    relief: Callable  # relief(body) -> Relief
    momenta: tuple[str, str]
    upright: int  # z at q = 0


SHAPES = {
    "tippe-top": Shape(tippe_top.body, tippe_top_relief, ("D", "lambda"), 1),
    "rolling-tippe-top": Shape(tippe_top.body, tippe_top_relief, ("D", "lambda"), 1),
    "heavy-top": Shape(heavy_top.body, heavy_top_relief, ("L3", "Lz"), -1),
    "gliding-heavy-top": Shape(heavy_top.body, heavy_top_relief, ("L3", "Lz"), -1),
}
