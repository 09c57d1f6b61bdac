"""The laws of mechanics as functions: each yields (what, found, expected) for a case at its random
states.

A law that holds for some cases only says so by `only`: elsewhere it is not asked, and where it is
asked it must compare something.

Nothing here reads a formula that it judges: vectors, angular velocity, contact velocity and
reaction are built again from the axis and the angular momentum, and derivatives along the flow are
complex steps, exact to rounding.
"""

import math
from collections import namedtuple
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact.outline import Rim, Spheroid
from tippetop.mechanics.friction import Frictionless
from tippetop.mechanics.operand import leaves, refill
from tippetop.mechanics.systems import gliding_heavy_top, tippe_top
from tippetop.mechanics.variables import Variables


STEP = 1e-30  # complex step: exact for any step this small
# the states are of order one, the sums a few dozen terms; denominators are kept from zero
TOLERANCE = 3e-11
STATES = 60

Pairs = Iterator[tuple[str, Any, Any]]
ODD = {"phi", "psi", "phi_dot", "omega3", "nu_y", "y"}
"""The angles, rates and places that a reflection in the plane y = 0 reverses."""


class Pair(NamedTuple):
    """Axes 1 and 3 of a body."""

    first: Any
    third: Any


class Motion(NamedTuple):
    """A state as vectors in the space frame, (3, n) each, and the numbers that go with it."""

    u: np.ndarray  # the axis
    L: np.ndarray  # angular momentum about the centre of mass
    omega: np.ndarray
    arm: np.ndarray  # from the centre of mass to the contact
    s_dot: np.ndarray  # velocity of the centre of mass
    v: np.ndarray  # velocity of the contact point


@cache
def joint(names: tuple[str, ...]) -> Any:
    """A record of the state and the integrals."""
    return namedtuple("Joint", names)


@dataclass(frozen=True)
class Case:
    """A system in a form with a friction law, a random body and random states of it."""

    system: Any
    form: Any
    law: str
    body: Any
    angles: Any
    state: Any = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "state", self.of_angles(self.form, self.angles))

    def of_angles(self, form: Any, e: Any) -> Any:
        """The state of a form and its integrals, in one record: formulas read them by name."""
        variables = Variables(form, orientation=False)
        q, carried = variables.start({}, e, np.sin(e.theta), np.cos(e.theta), self.body)
        return joint(variables.names)(*q, *carried)

    def rates(self, q: Any, b: Any = None, form: Any = None) -> Any:
        """The rates of a state and its integrals, in one record."""
        form, b = form or self.form, self.body if b is None else b
        integrals = {integral.name: integral.rate(q, q, b) for integral in form.integrals}
        moving = form.rates(q, b)._asdict()
        return joint((*moving, *integrals))(*moving.values(), *integrals.values())

    def along(self, function: Callable, q: Any = None, rates: Any = None) -> Any:
        """Derivative of function(q) along the flow."""
        q = self.state if q is None else q
        rates = self.rates(q) if rates is None else rates
        shifted = refill(
            q, iter([x + 1j * STEP * r for x, r in zip(leaves(q), leaves(rates), strict=True)])
        )
        result = function(shifted)
        if isinstance(result, tuple):
            return refill(
                result, iter([np.imag(np.asarray(leaf)) / STEP for leaf in leaves(result)])
            )
        return np.imag(result) / STEP

    def quantity(self, name: str, q: Any = None) -> Any:
        """A quantity of the system."""
        scalars = self.form.scalars(self.state if q is None else q, self.body)
        return self.formulas[name](scalars, self.body)

    @property
    def formulas(self) -> dict[str, Callable]:
        """The formula of each quantity of the system."""
        return {quantity.name: quantity.formula for quantity in self.system.quantities}

    def motion(self, q: Any) -> Motion:
        """The state as vectors, from first principles."""
        b = self.body
        zero = 0 * q[0]
        vertical = np.array([zero, zero, zero + 1])
        if hasattr(q, "Mx"):
            u = np.array([q.ux, q.uy, q.uz])
            L = momentum_about_centre(u, q, b)
        elif hasattr(q, "ux"):
            u, L = np.array([q.ux, q.uy, q.uz]), np.array([q.Lx, q.Ly, q.Lz])
            if self.form.name == "contact" or self.system.name == "heavy-top":  # L is about the tip
                L3 = np.sum(L * u, axis=0)
                L = L3 * u + (L - L3 * u) * b.I1 / (b.I1 + b.m * b.c**2)
        else:
            if hasattr(q, "lam"):
                q = angles_of_integrals(q, b)
            planar = hasattr(q, "s")
            s, z = (q.s, q.z) if planar else (np.sin(q.theta), np.cos(q.theta))
            phi = zero if planar else q.phi
            phi_dot, omega3 = (zero, zero) if planar else (q.phi_dot, q.omega3)
            e = np.array([np.cos(phi), np.sin(phi), zero])
            node = np.array([-np.sin(phi), np.cos(phi), zero])
            u = s * e + z * vertical
            w = q.theta_dot * node - phi_dot * s * (z * e - s * vertical) + omega3 * u
            L = b.I1 * w + (b.I3 - b.I1) * omega3 * u
        if hasattr(q, "ix"):
            axes = frame_of(q)
            omega, arm = turned_by(L, axes, b), arm_of_frame(axes, b)
        else:
            omega = L / b.I1 + (1 / b.I3 - 1 / b.I1) * np.sum(L * u, axis=0) * u
            arm = arm_of(u, vertical, b)
        arm_speed = np.cross(omega, arm, axis=0)
        if self.system.frictional:
            rates = self.rates(q)
            s_dot = np.array([rates.x, getattr(rates, "y", zero), -arm_speed[2]])
        else:
            s_dot = -arm_speed
        return Motion(u, L, omega, arm, s_dot, s_dot + arm_speed)

    def derivative(self) -> Motion:
        """Derivatives of the vectors along the flow."""
        return self.along(self.motion)


def frame_of(q: Any) -> np.ndarray:
    """Axes 1, 2 and 3 of a body without an axis of symmetry, (3, 3, n)."""
    first, third = np.array([q.ix, q.iy, q.iz]), np.array([q.ux, q.uy, q.uz])
    return np.array([first, np.cross(third, first, axis=0), third])


def turned_by(L: np.ndarray, axes: np.ndarray, b: Any) -> np.ndarray:
    """I^-1 L, of three moments of inertia."""
    moments = b.I1, b.I2, b.I3
    return sum(np.sum(e * L, axis=0) / I * e for e, I in zip(axes, moments, strict=True))


def arm_of_frame(axes: np.ndarray, b: Any) -> np.ndarray:
    """The lowest point of an ellipsoid, by its matrix in space."""
    shape = b.outline
    one, two, three = axes
    half = (shape.cos * one + shape.sin * two, shape.cos * two - shape.sin * one, three)
    down = sum(A**2 * d[2] * d for A, d in zip((shape.a, shape.b, shape.c), half, strict=True))
    return shape.x * one + shape.y * two + shape.z * three - down / np.sqrt(down[2])


def arm_of(u: np.ndarray, vertical: np.ndarray, b: Any) -> np.ndarray:
    """The lowest point of a body, from its centre of mass: of a spheroid by its matrix, of a rim by
    the lowest point of its circle.
    """
    shape, z = b.outline, u[2]
    if isinstance(shape, Spheroid):
        down = shape.b**2 * vertical + (shape.a**2 - shape.b**2) * z * u
        return shape.c * u - down / np.sqrt(down[2])
    if isinstance(shape, Rim):
        across = vertical - z * u
        return shape.c * u - shape.tube * vertical - shape.ring * across / np.sqrt(across[2])
    return b.c * u - b.R * vertical


def momentum_about_centre(u: np.ndarray, q: Any, b: Any) -> np.ndarray:
    """L of a body that rolls, by M about its contact: a.M = -lambda gives M_z, a linear system
    omega; D is not read.
    """
    arm = b.c * u - b.R * np.array([0 * u[0], 0 * u[0], 0 * u[0] + 1])
    M = np.array([q.Mx, q.My, -(q.lam + arm[0] * q.Mx + arm[1] * q.My) / arm[2]])
    one, I1, I3, m = np.eye(3), *(np.asarray(value)[..., None, None] for value in (b.I1, b.I3, b.m))
    axis, a = u.T[..., None], arm.T[..., None]
    own = I1 * one + (I3 - I1) * axis * np.swapaxes(axis, -1, -2)
    about = own + m * (np.sum(a * a, axis=-2, keepdims=True) * one - a * np.swapaxes(a, -1, -2))
    omega = np.linalg.solve(about, np.broadcast_to(M.T[..., None], a.shape))
    return (own @ omega)[..., 0].T


class Angles(NamedTuple):
    """What `motion` reads of Euler angles."""

    theta: Any
    theta_dot: Any
    phi: Any
    phi_dot: Any
    omega3: Any


def root_of_d(z: Any, b: Any) -> Any:
    """Return D/L_3 of a ball at z = cos(theta)."""
    gamma, sigma, alpha = b.I1 / b.I3, b.m * b.R**2 / b.I3, b.c / b.R
    return np.sqrt(gamma + sigma * (alpha - z) ** 2 + sigma * gamma * (1 - z**2))


def angles_of_integrals(q: Any, b: Any) -> Angles:
    """Euler angles of z, z', D, lambda: L_3 from D = L_3 sqrt(d), L_z from lambda = R
    L_z - c L_3.
    """
    s = np.sqrt(1 - q.z**2)
    L3 = q.D / root_of_d(q.z, b)
    Lz = (q.lam + b.c * L3) / b.R
    theta = np.pi / 2 - np.arcsin(q.z)  # complex steps go through arcsin
    return Angles(theta, -q.z_dot / s, q.phi, (Lz - L3 * q.z) / (b.I1 * s**2), L3 / b.I3)


# --- the laws -----------------------------------------------------------------------------------


def only(where: Callable[[Any, Any], bool]) -> Callable[[Callable], Callable]:
    """A law of the systems and forms for which where(system, form) is true."""

    def mark(law: Callable) -> Callable:
        law.where = where  # type: ignore[attr-defined]
        return law

    return mark


def chart_is_invertible(case: Case) -> Pairs:
    """Angles of the state of angles are those angles."""
    back = case.form.to_angles(case.state, case.state, case.body)
    yield from zip(back._fields, back, case.angles, strict=True)


def reference_form(system: Any) -> Any:
    """The form that the others are held against: the last one."""
    return next(reversed(system.forms.values()))


@only(lambda system, form: form is not reference_form(system))
def forms_agree(case: Case) -> Pairs:
    """Scalars of two forms agree through the chart, and the chart commutes with the flow."""
    reference = reference_form(case.system)
    e, b = case.angles, case.body
    mine, theirs = case.form.scalars(case.state, b), reference.scalars(e, b)
    for name in mine._fields:
        yield f"scalar {name}", getattr(mine, name), getattr(theirs, name)
    pushed = case.along(lambda x: case.of_angles(case.form, x), e, case.rates(e, form=reference))
    rates = case.rates(case.state)
    for name in rates._fields:
        yield f"rate of {name}", getattr(rates, name), getattr(pushed, name)


def scalars_are_what_they_say(case: Case) -> Pairs:
    """The scalars, from the vectors."""
    q, b = case.state, case.body
    s, m = case.form.scalars(q, b), case.motion(q)
    u_dot = np.cross(m.omega, m.u, axis=0)
    yield "z", s.z, m.u[2]
    yield "s2", s.s2, 1 - m.u[2] ** 2
    yield "z_dot", s.z_dot, u_dot[2]
    yield "z_dot along the flow", s.z_dot, case.along(lambda x: case.form.scalars(x, b).z)
    yield "phi_dot_s2", s.phi_dot_s2, m.u[0] * u_dot[1] - m.u[1] * u_dot[0]
    yield "axis_speed2", s.axis_speed2, np.sum(u_dot**2, axis=0)
    yield "L3", s.L3, np.sum(m.L * m.u, axis=0)
    yield "speed2", s.speed2, np.sum(m.s_dot[: 3 if hasattr(s, "rise") else 2] ** 2, axis=0)
    if hasattr(s, "z_ddot_free"):
        yield "fall", s.z_ddot_free, np.cross(m.L, u_dot, axis=0)[2] / b.I1
    if hasattr(s, "Lz"):
        yield "Lz", s.Lz, m.L[2]
    if hasattr(s, "v2"):
        yield "v2", s.v2, np.sum(m.v[:2] ** 2, axis=0)
        yield "v_u", s.v_u, np.sum(m.v[:2] * m.u[:2], axis=0)
    if hasattr(s, "v_n"):
        yield "v_n", s.v_n, m.u[0] * m.v[1] - m.u[1] * m.v[0]
    if hasattr(q, "nu_x") and not hasattr(q, "s"):
        yield "|nu|", q.nu_x**2 + q.nu_y**2, np.sum(m.v[:2] ** 2, axis=0)
    if hasattr(q, "ux"):
        yield "|3hat| stays 1", case.along(lambda x: x.ux**2 + x.uy**2 + x.uz**2), 0 * q.ux


def reflected(e: Any, odd: set[str]) -> Any:
    """Return angles of which some are reversed."""
    return e._replace(**{name: -getattr(e, name) for name in odd & {*e._fields}})


def orientation_follows_the_angular_velocity(case: Case) -> Pairs:
    """Axes 1 and 3 of the body turn with omega; at the start they are R_z(phi) R_y(theta) R_z(psi)
    of those of space, psi comes back, and a mirror image has the mirrored axes.
    """
    form, b, e, m = case.form, case.body, case.angles, case.motion(case.state)
    psi = np.linspace(-3.0, 3.0, STATES)
    variables = Variables(form)

    def start(e: Any, psi: Any) -> Any:
        e = e._replace(psi=psi) if hasattr(e, "psi") else e
        data = {"phi": getattr(e, "phi", 0 * psi), "psi": psi}
        q, carried = variables.start(data, e, np.sin(e.theta), np.cos(e.theta), b)
        return joint(variables.names)(*q, *carried)

    q = start(e, psi)
    rates = joint(variables.names)(
        *form.rates(q, b), *(integral.rate(q, q, b) for integral in variables.integrals)
    )
    axes = form.orientation.axes(q, q, b)
    change = case.along(lambda x: Pair(*form.orientation.axes(x, x, b)), q, rates)
    for name, axis, rate in zip(("axis 1", "axis 3"), axes, change, strict=True):
        spun = np.cross(m.omega, np.array(np.broadcast_arrays(*axis)), axis=0)
        for i, letter in enumerate("xyz"):
            yield f"{name}'_{letter}", rate[i], spun[i]
    planar = not hasattr(e, "phi")
    phi, psi = (0 * psi, 0 * psi) if planar else (e.phi, psi)
    turned = Rotation.from_euler("ZYZ", np.stack([phi, e.theta, psi], axis=1)).as_matrix()
    first, _, third = turned.T
    for i, letter in enumerate("xyz"):
        yield f"axis 1 {letter}", axes[0][i], first[i]
        yield f"axis 3 {letter}", axes[1][i], third[i]
    if planar:
        return
    if hasattr(q, "fx"):
        along = case.along(lambda x: x.fx * x.ux + x.fy * x.uy + x.fz * x.uz, q, rates)
        yield "f stays transverse", along, 0 * along
        off = q._replace(
            **{f"f{c}": 1.3 * getattr(q, f"f{c}") + 0.2 * getattr(q, f"u{c}") for c in "xyz"}
        )
        for i, letter in enumerate("xyz"):
            yield (
                f"axis 1 {letter} of an f that rounding has moved",
                form.orientation.axes(off, off, b)[0][i],
                axes[0][i],
            )
    if form.orientation.psi:
        yield "psi", form.orientation.psi(*axes), psi
    mirrored = start(reflected(e, ODD), -psi)
    for axis, other in zip(axes, form.orientation.axes(mirrored, mirrored, b), strict=True):
        for i, sign in enumerate((1, -1, 1)):
            yield f"mirrored {'xyz'[i]}", other[i], sign * axis[i]


def newton_and_euler(case: Case) -> Pairs:
    """m s'' = F - m g zhat and L' = a x F with one F, which obeys the law of the contact."""
    b, q = case.body, case.state
    m, change = case.motion(q), case.derivative()
    F = b.m * change.s_dot + np.array([0 * b.m, 0 * b.m, b.m * b.g])
    torque = np.cross(m.arm, F, axis=0)
    for i, axis in enumerate("xyz"):
        yield f"L'_{axis}", change.L[i], torque[i]
        yield f"3hat'_{axis}", change.u[i], np.cross(m.omega, m.u, axis=0)[i]
    rates = case.rates(q)
    yield "impulse' = F_z", rates.impulse, F[2]
    yield "normal force", case.quantity("normal_force"), F[2]
    yield "the contact stays on the plane", m.v[2], 0 * F[2]
    if "horizontal_force" in case.formulas:
        yield "horizontal force", case.quantity("horizontal_force"), np.hypot(F[0], F[1])
    if "friction_needed" in case.formulas:
        yield "friction needed", case.quantity("friction_needed"), np.hypot(F[0], F[1]) / F[2]
    if case.system.frictional:
        expected = contact_law(case, m, change, F[2])
        yield "F_x", F[0], expected[0]
        yield "F_y", F[1], expected[1]
        power = -np.sum(F * m.v, axis=0)
        yield "work' = -F.v_A", rates.work, power
        yield "friction power", case.quantity("friction_power"), power
        yield "E' = -friction power", case.along(lambda x: case.quantity("energy", x)), -power
    else:
        for i, axis in enumerate("xy"):
            yield f"v_A {axis}", m.v[i], 0 * m.v[i]
            if hasattr(rates, axis):
                yield f"{axis}'", getattr(rates, axis), m.s_dot[i]


def contact_law(case: Case, m: Motion, change: Motion, N: Any) -> np.ndarray:
    """The horizontal force that the friction law asks for, written a second time.

    Only a law of another package is taken from that package.
    """
    law, v, z = case.body.friction, m.v[:2], m.u[2]
    v2 = np.sum(v**2, axis=0)
    if case.law == "modified":
        rolled = np.cross(change.omega, m.arm, axis=0) + np.cross(m.omega, change.arm, axis=0)
        return -case.body.m * rolled[:2] * law.v_k**2 / (law.v_k**2 + v2) - law.mu * v
    speed = np.sqrt(v2 + getattr(law, "eps", 0.0) ** 2)
    known = {
        "none": lambda: 0.0,
        "viscous": lambda: law.mu,
        "coulomb": lambda: law.mu / speed,
        "mixed": lambda: law.mu + law.mu_coulomb / speed,
        "stribeck": lambda: (
            (law.mu_static - (law.mu_static - law.mu) * (1 - np.exp(-v2 / law.v_s**2))) / speed
        ),
        "latitude": lambda: law.mu * (1 + z) / 2 + law.mu_stem * (1 - z) / 2,
    }
    if case.law in known:
        return -known[case.law]() * N * v
    other = case.system.laws[case.law]
    assert not other.__module__.startswith("tippetop."), f"write `{case.law}` here a second time"
    return -other.coefficient(v2, z, law) * N * v


def quantities_are_what_they_say(case: Case) -> Pairs:
    """Energies, Jellett's integral, Routh's function, L_3 and L_z, from the vectors."""
    b, m = case.body, case.motion(case.state)
    rotation = np.sum(m.omega * m.L, axis=0) / 2
    height = -(b.m * b.g * m.arm[2])
    arm_speed = np.cross(m.omega, m.arm, axis=0)
    yield "E", case.quantity("energy"), b.m * np.sum(m.s_dot**2, axis=0) / 2 + rotation + height
    if "modified_energy" in case.formulas:
        expected = b.m * np.sum(arm_speed**2, axis=0) / 2 + rotation + height
        yield "E~", case.quantity("modified_energy"), expected
    if "spin" in case.formulas:
        yield "spin", case.quantity("spin"), m.omega[2]
    L3 = np.sum(m.L * m.u, axis=0)
    if "jellett" in case.formulas:
        yield "lambda", case.quantity("jellett"), -np.sum(m.L * m.arm, axis=0)
        rate, s = (
            case.along(lambda x: case.quantity("jellett", x)),
            case.form.scalars(case.state, b),
        )
        yield "lambda'", rate, -np.sum(m.L * case.derivative().arm, axis=0)
        bend = contact.touching(s, b).bend if b.outline else 0.0
        yield "lambda' by the bend", rate, -bend * s.z_dot * (L3 - m.u[2] * m.L[2])
    if "routh" in case.formulas:
        yield "D", case.quantity("routh"), L3 * root_of_d(m.u[2], b)
    if "Lz" in case.formulas:
        about_tip = m.L + b.m * np.cross(m.arm, arm_speed, axis=0)
        yield "L_z", case.quantity("Lz"), about_tip[2]
        yield "L_3", case.quantity("L3"), L3


@only(lambda system, form: bool(system.integrals))
def integrals_are_constant(case: Case) -> Pairs:
    """What is called an integral has rate zero."""
    for name in case.system.integrals:
        rate = case.along(lambda x, name=name: case.quantity(name, x))
        yield f"{name}'", rate, 0 * rate


@only(lambda system, form: "modified_energy" in {one.name for one in system.quantities})
def main_equation(case: Case) -> Pairs:
    """E~ = inertia theta'^2 + V identically; D', L_z' and E~' by dv_A/dt.

    [T 4.17, 4.18, 4.22, 5.24, 5.26]
    """
    system, b, q = case.system, case.body, case.state
    m, change = case.motion(q), case.derivative()
    arm_speed = np.cross(m.omega, m.arm, axis=0)
    rate = b.m * np.sum(arm_speed[:2] * change.v[:2], axis=0)
    yield "E~'", case.along(lambda x: case.quantity("modified_energy", x)), rate
    s = case.form.scalars(q, b)
    b = contact.touching(s, b)
    v_u = np.sum(m.u[:2] * change.v[:2], axis=0)  # (dv_A/dt).3hat
    v_n = m.u[0] * change.v[1] - m.u[1] * change.v[0]  # (zhat x 3hat).dv_A/dt
    yield "E~' as a formula", contact.modified_energy_rate(v_u, v_n, s, b), rate
    if system.potential is None:
        return
    if system.frictional and system.momenta:
        yield "(dv_A/dt).3hat", contact.push_u(s, b), v_u
        yield "(dv_A/dt).(zhat x 3hat)", contact.push_n(s, b), v_n
    z, s2 = m.u[2], 1 - m.u[2] ** 2
    V = system.potential(z, *(case.quantity(name) for name in system.momenta), b)
    yield "METT", case.quantity("modified_energy"), system.theta_inertia(z, b) * s.z_dot**2 / s2 + V
    if "routh" in case.formulas:
        yield "D'", case.along(lambda x: case.quantity("routh", x)), tippe_top.routh_rate(z, v_n, b)
    elif case.system.frictional and "Lz" in case.formulas:
        found = case.along(lambda x: case.quantity("Lz", x))
        yield "L_z' by dv_A/dt", gliding_heavy_top.Lz_rate(v_n, b), found


def mirrored(b: Any) -> Any:
    """Return the mirror image of a body: delta and y of an ellipsoid are reversed."""
    if not hasattr(b, "I2"):
        return b
    turned = {name: -getattr(b.outline, name) for name in ("sin", "a12", "y")}
    return b._replace(outline=b.outline._replace(**turned))


def mirror(case: Case) -> Pairs:
    """Reflection in the vertical plane y = 0 maps motions to motions; some quantities
    change sign.
    """
    odd = {"theta", "theta_dot", "nu_x", "x"} if hasattr(case.state, "s") else ODD
    image = replace(case, body=mirrored(case.body), angles=reflected(case.angles, odd))
    q = image.state
    pseudo = {"jellett", "routh", "L3", "Lz", "spin", "heading", "roll"}
    for quantity in case.system.quantities:
        sign = -1 if quantity.name in pseudo else 1
        yield quantity.name, image.quantity(quantity.name), sign * case.quantity(quantity.name)
    if case.form.name in ("euler", "angle"):
        signs = {**dict.fromkeys(odd, -1), "s": -1 if "theta" in odd else 1}
    else:
        signs = dict.fromkeys(
            ("uy", "iy", "Lx", "Lz", "Mx", "L3", "ry_dot", "vy", "y", "phi", "D", "lam"), -1
        )
    mine, theirs = case.rates(case.state), image.rates(q)
    for name in mine._fields:
        yield f"rate of {name}", getattr(theirs, name), signs.get(name, 1) * getattr(mine, name)


class Scale(NamedTuple):
    """Another system of units."""

    mass: float = 1.7
    length: float = 0.6
    time: float = 1.3

    def of(self, unit: Any) -> float:
        """The factor of a unit."""
        return math.prod(k**power for k, power in zip(self, unit.powers, strict=True))


def units(case: Case) -> Pairs:
    """Every formula keeps its unit: in other units of mass, length and time it gives the same, in
    those units.
    """
    scale = Scale()
    law = case.system.laws[case.law].units() if case.system.frictional else case.body.friction

    def scaled(record: Any, unit: Any) -> Any:
        return refill(record, (x * scale.of(u) for x, u in zip(leaves(record), unit, strict=True)))

    units = Variables(case.form, orientation=False).units
    b = scaled(case.body, leaves(case.system.body_units(law)))
    q = scaled(case.state, units.values())
    rates, other = case.rates(case.state), case.rates(q, b)
    for name, unit in units.items():
        yield (
            f"rate of {name}",
            getattr(other, name),
            getattr(rates, name) * scale.of(unit) / scale.time,
        )
    s = case.form.scalars(q, b)
    for quantity in case.system.quantities:
        found = quantity.formula(s, b)
        yield quantity.name, found, case.quantity(quantity.name) * scale.of(quantity.unit)


def events_are_zero_where_they_should(case: Case) -> Pairs:
    """turning has the sign of its sense times theta', equator vanishes with z, inverted at pi -
    0.1.
    """
    s = case.form.scalars(case.state, case.body)
    z, m = s.z, case.motion(case.state)
    for event in case.system.events:
        value = event.formula(s, case.body)
        if event.name == "turning":
            u_dot = np.cross(m.omega, m.u, axis=0)
            speed = case.angles.theta_dot if event.sense > 0 else u_dot[2]
            yield event.name, value, speed
        elif event.name == "equator":
            yield event.name, value, z
        elif event.name == "inverted":
            yield event.name, value, z - np.cos(np.pi - 0.1)
        elif event.name == "liftoff":
            yield event.name, value, case.quantity("normal_force")
        elif event.name == "settled" and case.system.name != "gliding-cylinder":
            yield event.name, value, case.quantity("friction_power") / case.quantity("normal_force")
        elif event.name == "settled":
            yield event.name, value, np.sum(m.v[:2] ** 2, axis=0)
    for event in (e for e in case.system.events if e.name == "settled"):
        still = case.angles._replace(
            **{name: 0 * z for name in case.angles._fields if name.startswith("nu_")}
        )
        s = case.form.scalars(case.of_angles(case.form, still), case.body)
        yield "settled, in units of 1e-12", 1e12 * event.formula(s, case.body), -1.0


@only(lambda system, form: bool(form.domains))
def domains_are_what_they_say(case: Case) -> Pairs:
    """The jam is the denominator of g_n: upward contact acceleration per unit of force; the pole is
    sin^2.
    """
    s, b, m = case.form.scalars(case.state, case.body), case.body, case.motion(case.state)
    for domain in case.form.domains:
        value = domain.formula(s, b)
        if "jam" not in domain.meaning:
            yield "pole", value, 1 - m.u[2] ** 2 - (1e-6 if "flat" in domain.meaning else 0)
        elif case.law != "modified":
            N = case.quantity("normal_force")
            F = contact_law(case, m, m, N) / N
            push = np.array([F[0], F[1], 1 + 0 * N])
            torque = np.cross(m.arm, push, axis=0)
            spin = torque / b.I1 + (1 / b.I3 - 1 / b.I1) * np.sum(torque * m.u, axis=0) * m.u
            unit = b.m
            if hasattr(b, "I2"):
                spin, unit = turned_by(torque, frame_of(case.state), b), 1
            yield "jam", value, unit / b.m + unit * np.cross(spin, m.arm, axis=0)[2]
        else:
            yield "jam", value, 1.0


LAWS: tuple[Callable[[Case], Pairs], ...] = (
    chart_is_invertible,
    forms_agree,
    scalars_are_what_they_say,
    orientation_follows_the_angular_velocity,
    newton_and_euler,
    quantities_are_what_they_say,
    integrals_are_constant,
    main_equation,
    mirror,
    units,
    events_are_zero_where_they_should,
    domains_are_what_they_say,
)


# --- random bodies and states -------------------------------------------------------------------


def cases(systems: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Every system x form x friction law of a contact that is a point, by name."""
    for name, system in systems.items():
        for form in system.forms:
            for law in [law for law, rules in system.laws.items() if not rules.regions] or (
                "none",
            ):
                yield name, form, law


def asked(systems: dict[str, Any]) -> Iterator[tuple[str, str, str, Callable]]:
    """Every one of these cases with each law that has something to compare for it."""
    for name, form, friction in cases(systems):
        for law in LAWS:
            where = getattr(law, "where", lambda system, form: True)
            if where(systems[name], systems[name].forms[form]):
                yield name, form, friction, law


def case(system: Any, form: str, law: str, rng: np.random.Generator) -> Case:
    """Random bodies and states of order one, kept from the poles and from a jammed contact."""
    n = STATES
    parameters = {name: rng.uniform(0.6, 1.5, n) for name in system.parameters}
    if "alpha" in parameters:
        parameters["alpha"] = rng.uniform(0.1, 0.9, n)
    for offset in {*("xyh" if "delta" in parameters else "c")} & {*parameters}:
        parameters[offset] = rng.uniform(-0.5, 0.5, n)
    if "mu" in (record := system.laws[law]._fields if system.frictional else ()):
        friction = system.laws[law](*(rng.uniform(0.02, 0.2, n) for _ in record))
        speeds = {
            name: rng.uniform(0.3, 1.0, n) for name in record if name in ("eps", "v_s", "v_k")
        }
        friction = friction._replace(**speeds)
    else:
        friction = Frictionless()
    ranges = {"theta": (0.2, np.pi - 0.2), "phi": (-3.0, 3.0)}
    names = type(system.angles)._fields
    bounds = [ranges.get(name, (-1.5, 1.5)) for name in names]
    angles = type(system.angles)(*(rng.uniform(low, high, n) for low, high in bounds))
    return Case(system, system.forms[form], law, system.body(parameters, friction), angles)


def lane(record: Any, i: int) -> Any:
    """Return a record of arrays at one of its random states, as floats."""
    return refill(record, iter([float(np.broadcast_to(x, STATES)[i]) for x in leaves(record)]))


def assert_holds(law: Callable[[Case], Pairs], made: Case) -> None:
    """Check that there are pairs, and that all agree. A failure names the state of the first."""
    what = None
    for what, found, expected in law(made):
        found, expected = np.broadcast_arrays(np.asarray(found), np.asarray(expected))
        size = 1 + np.max(np.abs(expected))
        error = np.abs(found - expected) / size
        if not np.all(error < TOLERANCE):
            i = int(np.argmax(np.where(np.isfinite(error), error, np.inf)))
            said = " ".join((law.__doc__ or "").split())
            pytest.fail(
                f"{law.__name__}: {said}\n"
                f"{what} is {float(found.flat[i])!r}, must be {float(expected.flat[i])!r} "
                f"(error {error.flat[i]:.1e})\n"
                f"at {lane(made.state, i)}\nwith {lane(made.body, i)}",
                pytrace=False,
            )
    assert what is not None, f"{law.__name__}: nothing was compared"
