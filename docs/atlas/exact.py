"""Numbers of 50 digits that carry their time derivative: the formulas of the package, fed with them, are exact.

A `Jet` is a value and its rate along the motion. The motions here start at random states; their rates are those of the
vector form of the package, which is Newton and Euler's equations of the source, (3.12), (4.1), (2.24), (5.2), (6.1).
"""

import inspect
import random
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import mpmath as mp

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import gliding, rolling
from tippetop.mechanics.friction import Viscous
from tippetop.mechanics.operand import Vector, cross, dot, plus, times
from tippetop.mechanics.systems import cylinder, heavy_top, tippe_top


mp.mp.dps = 50


class Jet:
    """A value and its rate of change; + - * / ** and the functions that formulas call."""

    def __init__(self, value: Any, rate: Any = 0):
        self.value, self.rate = value, rate

    def __add__(self, other: Any) -> "Jet":
        x = jet(other)
        return Jet(self.value + x.value, self.rate + x.rate)

    def __mul__(self, other: Any) -> "Jet":
        x = jet(other)
        return Jet(self.value * x.value, self.rate * x.value + self.value * x.rate)

    def __truediv__(self, other: Any) -> "Jet":
        x = jet(other)
        ratio = self.value / x.value
        return Jet(ratio, (self.rate - ratio * x.rate) / x.value)

    def __pow__(self, n: int) -> "Jet":
        return Jet(self.value**n, n * self.value ** (n - 1) * self.rate)

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.rate)

    def __sub__(self, other: Any) -> "Jet":
        return self + (-jet(other))

    def __rsub__(self, other: Any) -> "Jet":
        return jet(other) - self

    def __rtruediv__(self, other: Any) -> "Jet":
        return jet(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def sqrt(self) -> "Jet":
        root = mp.sqrt(self.value)
        return Jet(root, self.rate / (2 * root))

    def sin(self) -> "Jet":
        return Jet(mp.sin(self.value), mp.cos(self.value) * self.rate)

    def cos(self) -> "Jet":
        return Jet(mp.cos(self.value), -mp.sin(self.value) * self.rate)

    def arctan2(self, other: Any) -> "Jet":
        x = jet(other)
        size2 = self.value**2 + x.value**2
        return Jet(
            mp.atan2(self.value, x.value), (x.value * self.rate - self.value * x.rate) / size2
        )


def jet(x: Any) -> Jet:
    """A number as one that stands still."""
    return x if isinstance(x, Jet) else Jet(x)


def rate(x: Any) -> Any:
    """The time derivative of a number or, component by component, of a vector."""
    return Vector(*map(rate, x)) if isinstance(x, tuple) else jet(x).rate


def value(x: Any) -> Any:
    """The number itself, without its rate; likewise of a vector."""
    return Vector(*map(value, x)) if isinstance(x, tuple) else jet(x).value


def moving(state: Any, rates: Any) -> Any:
    """The state as jets."""
    return type(state)(*map(Jet, map(value, state), map(value, rates)))


# --- random bodies and states -------------------------------------------------------------------

UP = Vector(0, 0, 1)
AT_ORIGIN = SimpleNamespace(x=0, y=0, work=0, impulse=0)


class _Drawn:
    """Random decimals, the same for the same seed."""

    def __init__(self, seed: int):
        self.random = random.Random(seed)

    def __call__(self, low: float, high: float) -> mp.mpf:
        return mp.mpf(self.random.randrange(10**12)) / 10**12 * (mp.mpf(high) - low) + low

    def angles(self) -> Any:
        """Angles and rates of order one, away from the poles, as jets that stand still."""
        spin = [self(0.3, 3) * self.random.choice((-1, 1)) for _ in range(5)]
        moments = (self(0.3, 2.8), *spin, self(0.2, 6))
        return type(gliding.ANGLES)(*map(Jet, moments), *[0] * 4)


def tippe_body(draw: _Drawn) -> SimpleNamespace:
    """The letters of a random tippe top of the inverting class."""
    alpha, I3 = draw(0.1, 0.6), draw(0.5, 1.5)
    letters = {
        "m": draw(0.5, 2),
        "R": draw(0.5, 2),
        "alpha": alpha,
        "I1": I3 * (1 + alpha * draw(-0.9, 0.9)),
        "I3": I3,
    }
    x = SimpleNamespace(**letters, g=draw(5, 12), mu=draw(0.05, 0.2))
    x.gamma, x.sigma = x.I1 / x.I3, x.m * x.R**2 / x.I3
    x.b = tippe_top.TippeTop.body_of(vars(x), Viscous(x.mu))
    return x


def heavy_body(draw: _Drawn) -> SimpleNamespace:
    """The letters of a random heavy top."""
    x = SimpleNamespace(
        m=draw(0.5, 2), l=draw(0.5, 2), I1=draw(0.5, 2), I3=draw(0.4, 1.5), g=draw(5, 12)
    )
    x.mu, x.R = draw(0.05, 0.2), mp.mpf(0)
    x.J1 = x.I1 + x.m * x.l**2  # I1*
    x.b = heavy_top.HeavyTop.body_of(vars(x), Viscous(x.mu))
    return x


def _angles(x: SimpleNamespace, e: Any) -> None:
    """Adds the letters of Euler angles."""
    x.theta, x.theta_dot, x.phi_dot, x.omega3, x.phi = (
        e.theta,
        e.theta_dot,
        e.phi_dot,
        e.omega3,
        e.phi,
    )
    x.s, x.c, x.e = e.theta.sin(), e.theta.cos(), e
    x.z = x.c
    if hasattr(e, "nu_x"):
        x.nu_x, x.nu_y = e.nu_x, e.nu_y


def _vectors(x: SimpleNamespace, q: Any) -> None:
    """Adds 3hat, L, omega, a and their kin."""
    x.u, x.L = Vector(q.ux, q.uy, q.uz), Vector(q.Lx, q.Ly, q.Lz)
    x.omega = contact.angular_velocity(x, x.b)
    x.a = plus(times(x.b.c, x.u), Vector(0, 0, -x.b.R))
    x.omega_a = cross(x.omega, x.a)


def _gliding(x: SimpleNamespace, start: Any) -> SimpleNamespace:
    """Any gliding body: its state and every letter of it."""
    still = gliding.vector_of_angles(start, start.theta.sin(), start.theta.cos(), x.b)
    x.q = moving(still, gliding.vector_rates(still, x.b))
    _angles(x, gliding.angles_of_vector(x.q, AT_ORIGIN, x.b))
    _vectors(x, x.q)
    x.v_A = gliding.sliding_velocity(x.q, x.b)
    x.s_dot = Vector(x.q.rx_dot, x.q.ry_dot, -dot(x.omega_a, UP))
    x.scalars = gliding.vector_scalars(x.q, x.b)
    x.g_n = contact.g_n(x.scalars, x.b)
    x.F = plus(times(x.g_n, UP), times(-(x.mu * x.g_n), x.v_A))
    x.E, x.E_tilde = contact.energy(x.scalars, x.b), contact.modified_energy(x.scalars, x.b)
    return x


def gliding_tippe_top(seed: int) -> SimpleNamespace:
    """A tippe top that rolls and glides."""
    draw = _Drawn(seed)
    x = _gliding(tippe_body(draw), draw.angles())
    x.lam, x.D, x.d = (
        contact.jellett(x.scalars, x.b),
        tippe_top.routh(x.scalars, x.b),
        tippe_top.d(x.c, x.b),
    )
    return x


def rolling_tippe_top(seed: int) -> SimpleNamespace:
    """A tippe top in pure rolling."""
    draw = _Drawn(seed)
    x, start = tippe_body(draw), draw.angles()
    e = type(rolling.ANGLES)(
        start.theta, start.theta_dot, start.phi_dot, start.omega3, start.phi, 0, 0, 0
    )
    still = rolling.vector_of_angles(e, start.theta.sin(), start.theta.cos(), x.b)
    x.q = moving(still, rolling.vector_rates(still, x.b))
    _angles(x, rolling.angles_of_vector(x.q, AT_ORIGIN, x.b))
    _vectors(x, x.q)
    x.scalars = rolling.vector_scalars(x.q, x.b)
    x.E, x.E_tilde = contact.energy(x.scalars, x.b), contact.modified_energy(x.scalars, x.b)
    x.lam, x.D, x.d = (
        contact.jellett(x.scalars, x.b),
        tippe_top.routh(x.scalars, x.b),
        tippe_top.d(x.c, x.b),
    )
    x.s_dot = times(-1, x.omega_a)
    return x


def gliding_heavy_top(seed: int) -> SimpleNamespace:
    """A heavy top whose tip glides; L is about the centre of mass, L_A about the tip."""
    draw = _Drawn(seed)
    x = _gliding(heavy_body(draw), draw.angles())
    x.L_3, x.L_z = heavy_top.L3(x.scalars, x.b), heavy_top.Lz(x.scalars, x.b)
    x.L_A = plus(x.L, times(x.m, cross(x.a, x.omega_a)))
    return x


def fixed_heavy_top(seed: int) -> SimpleNamespace:
    """A heavy top with a fixed tip; L_A is about the tip."""
    draw = _Drawn(seed)
    x, start = heavy_body(draw), draw.angles()
    e = type(heavy_top.ANGLES)(
        start.theta, start.theta_dot, start.phi_dot, start.omega3, start.phi, 0
    )
    still = heavy_top.vector_of_angles(e, start.theta.sin(), start.theta.cos(), x.b)
    x.q = moving(still, heavy_top.fixed_rates(still, x.b))
    _angles(x, heavy_top.angles_of_vector(x.q, AT_ORIGIN, x.b))
    x.u, x.L_A = Vector(x.q.ux, x.q.uy, x.q.uz), Vector(x.q.Lx, x.q.Ly, x.q.Lz)
    x.scalars = heavy_top.fixed_scalars(x.q, x.b)
    x.L_3, x.L_z = heavy_top.L3(x.scalars, x.b), heavy_top.Lz(x.scalars, x.b)
    x.E = contact.modified_energy(x.scalars, x.b)
    return x


def tumbling_tippe_top(seed: int) -> SimpleNamespace:
    """A tippe top that tumbles: v_A = 0 and a vertical reaction, at rest as far as theta and the spins go."""
    from tippetop.mechanics.theory.tumbling import tumbling

    draw = _Drawn(seed)
    x = tippe_body(draw)
    theta = draw(0.3, 2.8)
    x.s, x.c = mp.sin(theta), mp.cos(theta)
    x.z = x.c
    x.phi_dot, x.omega3 = tumbling(x.c, x.b)
    e = type(gliding.ANGLES)(*map(Jet, (theta, 0, x.phi_dot, x.omega3, 0, 0, 0)), *[0] * 4)
    x.q = gliding.vector_of_angles(e, jet(x.s), jet(x.c), x.b)
    x.scalars = gliding.vector_scalars(x.q, x.b)
    _vectors(x, x.q)
    x.lam = value(-dot(x.L, x.a))
    x.E = value(contact.energy(x.scalars, x.b))
    return x


def gliding_cylinder(seed: int) -> SimpleNamespace:
    """An eccentric cylinder that rolls and glides."""
    draw = _Drawn(seed)
    x = SimpleNamespace(
        m=draw(0.5, 2), R=draw(0.5, 2), alpha=draw(0.1, 0.6), I=draw(0.3, 2), g=draw(5, 12)
    )
    x.mu = draw(0.05, 0.2)
    theta, theta_dot, nu_x = Jet(draw(-3, 3)), Jet(draw(-3, 3)), Jet(draw(-2, 2))
    x.b = cylinder.Cylinder.body_of(vars(x), Viscous(x.mu))
    still = cylinder.State(theta.sin(), theta.cos(), theta_dot, nu_x)
    x.q = moving(still, cylinder.rates(still, x.b))
    x.s, x.c, x.theta_dot, x.nu_x = x.q
    x.scalars = cylinder.scalars(x.q, x.b)
    x.g_n = cylinder.normal_force(x.scalars, x.b)
    x.E = contact.energy(x.scalars, x.b)
    return x


MOTIONS: dict[str, Callable[[int], SimpleNamespace]] = {
    function.__name__.replace("_", " "): function
    for function in (
        gliding_tippe_top,
        rolling_tippe_top,
        gliding_heavy_top,
        fixed_heavy_top,
        tumbling_tippe_top,
        gliding_cylinder,
    )
}


def of_letters(function: Callable, letters: SimpleNamespace) -> Any:
    """A function whose arguments are named by letters of a motion, of that motion."""
    return function(*(getattr(letters, name) for name in inspect.signature(function).parameters))


# --- comparing ----------------------------------------------------------------------------------


def flat(x: Any) -> list:
    """The numbers of a number, a vector or a matrix."""
    return (
        [number for part in x for number in flat(part)]
        if isinstance(x, tuple | list)
        else [value(x)]
    )


def residual(left: Any, right: Any) -> mp.mpf:
    """|left - right| over the larger of the two, of numbers, vectors or matrices."""
    a, b = flat(left), flat(right)
    size = max(map(abs, [*a, *b])) or 1
    return max(abs(x - y) for x, y in zip(a, b, strict=True)) / size
