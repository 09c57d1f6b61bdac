"""The potential of a top, in a variable that is exact at both poles, and its minimal surface.

In go the momenta (D, lambda) or (L3, Lz) and the coefficients of a body; out come V, its slopes by
ln(q), a first guess of its minimum, and the gradient of the minimal surface F. `kernels` compiles
them for grids; `potential` calls them with arrays. Instead of z = cos(theta) the formulas take q =
tan(theta/2)^2, 0 < q < oo: 1 - z = 2q/(1 + q), 1 + z = 2/(1 + q), and dz/dln(q) = -(1 - z^2)/2. X =
lambda sqrt(d) + R(alpha - z) D is carried by its values at the poles, a ~ X(+1) and b ~ X(-1): with
K from d = (1 - z^2)(h^2 + K), h linear in 1/sqrt(q) and sqrt(q),

    X/sqrt(1 - z^2) ~ (a + b q + k psi)/sqrt(q),    psi = K q/(h + sqrt(h^2 + K q)),

and nothing cancels, neither at the poles nor on the marked lines a = 0 and b = 0. K ~ -chi vanishes
for sqrt(d) linear in z. Heavy tops are the case K = 0, d = 1, seen upside down: q = cot(theta/2)^2.
Squares are in joules.

Symbols
    q         > 0, the variable; p: a `Point`, the two momenta; c: `PotentialCoefficients` of a body
    V, F      effective potential [J], its minimum over q [J]
    head, tail   of double-doubles, see `mechanics.doubledouble`
    Y         a + b q + k psi, X but for a factor; Y1, Y2, Y3: its derivatives by ln(q)
"""

from typing import NamedTuple

from ..mechanics.doubledouble import DoubleDouble, minus, plus, quotient, scaled, tidy, times
from ..mechanics.operand import Operand, formula, product_error, sqrt


class Point(NamedTuple):
    """A point (D, lambda), or (L3, Lz), as the formulas take it [sqrt(J)]."""

    a: DoubleDouble  # X at the pole q = 0
    b: DoubleDouble  # X at the pole q = oo
    k: DoubleDouble  # times psi: what X has in between
    spin: DoubleDouble
    offset: DoubleDouble  # what gamma V has besides weight and X^2 [J]


@formula
def at_momenta(first, second, c):
    """Return the `Point` of (D, lambda), or (L3, Lz), to one rounding also where a or b cancels."""
    spin = scaled(first, c.spin1)
    other = scaled(second, c.spin2)
    return Point(
        tidy(plus(scaled(first, c.a1), scaled(second, c.a2))),
        tidy(plus(scaled(first, c.b1), scaled(second, c.b2))),
        scaled(second, c.k),
        spin,
        minus(times(spin, spin), times(other, other)),
    )


@formula
def psi(q, p, c):
    """Return 2 psi sqrt(q), a double-double, with psi of the module's docstring.

    It is the root of psi (psi + 2h) = 4 K q with h twice that of above, times sqrt(q). `slopes` has
    the same psi in plain doubles.
    """
    Kq = scaled(4 * q, c.K)
    h = plus(c.sqrt_d0, scaled(q, c.sqrt_d1))
    e = sqrt(h.head * h.head + Kq.head)
    he = h.head + e
    per = 1 / (he * e)
    psi = Kq.head * (e * per)
    u = plus(DoubleDouble(psi, 0.0), scaled(2.0, h))
    rest = ((Kq.head - psi * u.head) - product_error(psi, u.head)) + (Kq.tail - psi * u.tail)
    return DoubleDouble(psi, rest * (0.5 * he * per))


@formula
def potential(q, p, c):
    """Return V [J] at q of the point p, a double-double: weight and (Y^2/q + offset)/gamma.

    [equal to T 4.12, 2.38]
    """
    Y = plus(plus(p.a, scaled(q, p.b)), times(p.k, psi(q, p, c)))
    motion = plus(times(Y, Y), scaled(q, p.offset))
    t = plus(DoubleDouble(1.0, 0.0), DoubleDouble(q, 0.0))  # 1 + q = 2/(1 + z)
    gq = scaled(q, c.gamma)
    per = 1 / (t.head * gq.head)
    weight = quotient(scaled(q, c.height_gain), t, gq.head * per)
    return plus(plus(c.height_energy, weight), quotient(motion, gq, t.head * per))


@formula
def value(q, p, c):
    """Return V [J] at q of the point p, a number, to one rounding."""
    V = potential(q, p, c)
    return V.head + V.tail


@formula
def excess(q, at, c):
    """Return V - level [J], where `at` is (p, level), to one rounding also where they nearly agree.

    Its zeros are the turning angles of a motion with E~ = level.
    """
    p, level = at
    V = potential(q, p, c)
    return (V.head - level) + V.tail


class MomentumSlopes(NamedTuple):
    """The derivatives of V by the two momenta at q, times q gamma/2, and how they vary with q."""

    first: DoubleDouble
    second: DoubleDouble
    first_rate: Operand  # with ln(q)
    second_rate: Operand
    away: Operand  # of ln(q), to the minimum


@formula
def momentum_slopes(q, p, c):
    """Return the derivatives of V by the momenta, times q gamma/2, as `MomentumSlopes`.

    Y is that of `potential` and h that of `psi`: a change of one is a change of both.
    Where X almost vanishes at the minimum, no q in doubles has the X of the minimum: `away` is the
    distance of the minimum from q, over which the derivatives are extrapolated.
    """
    root = psi(q, p, c)
    t = plus(DoubleDouble(1.0, 0.0), DoubleDouble(q, 0.0))
    h = plus(c.sqrt_d0, scaled(q, c.sqrt_d1))
    bq = scaled(q, p.b)
    Y = plus(plus(p.a, bq), times(p.k, root))
    e = plus(root, h)
    turn = quotient(minus(scaled(q, c.sqrt_d1), c.sqrt_d0), e, 1 / e.head)  # -2 psi'/psi
    Y1 = minus(minus(bq, p.a), times(turn, times(p.k, root)))  # 2 Y', as first1 and second1 below
    part = quotient(DoubleDouble(q, 0.0), t, 1 / t.head)
    slope = plus(times(times(c.gamma, c.height_gain), times(part, part)), times(Y, Y1))
    first = plus(c.a1, scaled(q, c.b1))
    second = plus(plus(c.a2, scaled(q, c.b2)), times(c.k, root))
    first1 = c.b1.head * q - c.a1.head
    second1 = c.b2.head * q - c.a2.head - turn.head * c.k.head * root.head
    return MomentumSlopes(
        plus(times(Y, first), scaled(q, times(p.spin, c.spin1))),
        minus(times(Y, second), scaled(q, times(p.k, c.spin22_by_k))),
        (Y1.head * first.head + Y.head * first1) / 2,
        (Y1.head * second.head + Y.head * second1) / 2,
        -(slope.head + slope.tail) / slopes(q, p, c)[1],
    )


NEXT_TO = 1e-8  # of ln(q) from a minimum: the search of `kernels.minima` ends nearer


@formula
def surface_gradient(q, p, c):
    """Return dF/dD, dF/dlambda of the minimal surface: V at its minimum next to the double q.

    They are extrapolated to the minimum if it is nearer than NEXT_TO.
    """
    s = momentum_slopes(q, p, c)
    per = 2 / (q * c.gamma.head)
    away = s.away if abs(s.away) < NEXT_TO else 0.0
    return (
        per * ((s.first.head + away * s.first_rate) + s.first.tail),
        per * ((s.second.head + away * s.second_rate) + s.second.tail),
    )


@formula
def slopes(q, p, c):
    """Return q gamma times the first three derivatives of V by ln(q) [J].

    The first is -N(z)/(1 - z^2) but for a factor. The search for a minimum takes ratios of the
    three, in which the factor q gamma cancels; `curvature` and `potential.potential` divide by it.
    """
    K = c.K.head
    d0 = c.sqrt_d0.head
    d1q = c.sqrt_d1.head * q
    h = (d0 + d1q) / 2
    e = sqrt(h * h + K * q)
    he = h + e
    t = 1 + q
    per = 1 / (e * he * t)  # the only division
    per_e = he * t * per
    k_psi = 2 * p.k.head * K * q * (e * t * per)  # in Y [sqrt(J)]
    n, s = h * per_e, (d1q - d0) * (0.25 * per_e)  # psi' = -s psi and n' = s (1 - n^2), by ln(q)
    cos2 = e * he * per  # cos(theta/2)^2 = (1 + z)/2
    turn = n * (0.25 - s * s)  # s'
    turn2 = s * ((1 - n * n) * (0.25 - s * s) - 2 * n * turn)
    a = p.a.head
    bq = p.b.head * q
    Y = (a + bq) + k_psi
    Y1 = (bq - a) / 2 - s * k_psi
    Y2 = (a + bq) / 4 + k_psi * (s * s - turn)
    Y3 = (bq - a) / 8 + k_psi * (s * (3 * turn - s * s) - turn2)
    y = q * cos2
    yc = y * cos2
    weight = c.gamma.head * c.height_gain.head * q * yc
    return (
        weight + 2 * Y * Y1,
        weight * (cos2 - y) + 2 * (Y1 * Y1 + Y * Y2),
        weight * (1 - 6 * yc) + 6 * Y1 * Y2 + 2 * Y * Y3,
    )


@formula
def slope(q, p, c):
    """Return q gamma dV/dln(q), the first of `slopes`: its zero is the minimum."""
    return slopes(q, p, c)[0]


@formula
def curvature(q, p, c):
    """Return the second derivative of V by ln(q) [J]; at the minimum d2V/dtheta2 sin(theta)^2/4."""
    return slopes(q, p, c)[1] / (q * c.gamma.head)


@formula
def pole_values(p, c):
    """Return |a| and |b| [sqrt(J)] with the part k psi of X, for a first guess of the minimum.

    `reaches_pole` has the limit of |a| for b = 0.

    k psi is that of q = a/b, where the two terms balance, and is split between them as a : b.
    """
    a = abs(p.a.head)
    b = abs(p.b.head)
    psi = 2 * p.k.head * c.K.head / ((c.sqrt_d0.head * b + c.sqrt_d1.head * a) * (a + b))
    return abs(p.a.head + psi * a * a), abs(p.b.head + psi * b * b)


class Sketch(NamedTuple):
    """q of the minimum, roughly, and the a and b that it is sketched with."""

    q: Operand
    a: Operand
    b: Operand


@formula
def rough(p, c):
    """Return q of the minimum to a factor of about two: the root of q (b + g/(1 + q)) = a."""
    a, b = pole_values(p, c)
    t = c.root_gamma_gain + b - a
    w = sqrt(t * t + 4 * a * b)
    above, below = (2 * a, t + w) if t > 0 else (w - t, 2 * b)
    return Sketch(above / below, a, b)


@formula
def sharper(k, c):
    """Make one step of Halley in ln(q) towards the minimum for K = 0; return the new `Sketch`.

    The minimum is the root of (b q)^2 + (g q/(1 + q))^2 = a^2; `k` is the present Sketch.
    """
    t = 1 + k.q  # the function times t^2, its derivatives times t^3, t^4
    bq = k.b * k.q * t
    gq = c.root_gamma_gain * k.q
    B = bq * bq
    G = gq * gq
    f0 = (B - (k.a * t) ** 2) + G
    f1 = 2 * (B * t + G)
    f2 = 4 * (B * t * t + G) - 2 * G * k.q
    n = f0 * f1 * t
    m = 2 * f1 * f1 - f0 * f2
    return Sketch(k.q * ((m - n) / (m + n)), k.a, k.b)


@formula
def guess(p, c):
    """Return q of the minimum to some 1e-3 where K is small: the start of a search."""
    return sharper(sharper(rough(p, c), c), c).q


@formula
def reaches_pole(first, second, p, c):
    """Return whether V approaches its infimum at the pole q = 0, and at the pole q = oo.

    The first happens on the marked line a = 0, the second on b = 0 if also a^2 >= gamma gain: near
    q = oo, V exceeds its limit by (a^2/gamma - gain)/q. Here a number is 0 if it is within four
    rounding errors of the part by lambda. `first` (D) is there for the signature that
    `tippetop_kernels.grid.minima` calls.
    """
    rounding = 4 * 2.220446049250313e-16
    a = abs(p.a.head + 2 * p.k.head * c.K.head / c.sqrt_d1.head)  # that of `pole_values` for b = 0
    return (
        abs(p.a.head) <= rounding * abs(c.a2.head * second),
        (abs(p.b.head) <= rounding * abs(c.b2.head * second)) & (a >= c.root_gamma_gain),
    )
