"""Bodies without an axis of symmetry: formulas of how they lie, for any convex outline.

Axes 1, 2 and 3 are the principal axes of inertia; the outline may be turned against them. In go
orientation and momentum; out come arm, velocities and the response at the contact. The motion in
contact takes only five functions of how a body lies: the arm, its rate, the height, the angular
velocity of an angular momentum, and the rates of the axes. `body` and `response` choose these
functions for an `Asymmetric` body (`by_body`), and those of a ball for others, which have the same
arguments. The functions lack `@formula`, because no function that numba compiles calls them.

Symbols
    b         the body, an `Asymmetric`; b.outline: its shape, such as an `Ellipsoid`
    u         how it lies, a `Frame`: axes 3 and 1, and so 2, in space
    x         a `body.Turning` (u, L); L: angular momentum about the centre of mass, in space
    a         the arm, from the centre of mass to the contact point
    up, zhat  unit vector upwards, along the axes of the body
    omega     angular velocity; I: tensor of inertia, diag(I1, I2, I3) along the axes of the body
    v, w      vectors; "along the axes": components along axes 1, 2, 3; otherwise in space
"""

from typing import Any, NamedTuple

from ..operand import Operand, Vector, cross, dot, minus, plus, sqrt, times


class Asymmetric(NamedTuple):
    """A body without an axis of symmetry, which `systems.ellipsoid` fills by position."""

    m: Operand  # [kg]
    I1: Operand  # I1, I2, I3: about the centre of mass, along axes 1, 2, 3 [kg m^2]
    I2: Operand
    I3: Operand
    g: Operand  # [m/s^2]
    friction: Any  # record of a law
    outline: Any  # its shape, with the methods of `Ellipsoid`
    clearance: Operand = ()  # as of a `body.Touch`
    lever: Operand = ()
    around: Any = ()


class Frame(NamedTuple):
    """How such a body lies: components in space of axis 3 (x, y, z) and of axis 1 (ix, iy, iz).

    Axis 3 comes first, so that u.x, u.y, u.z are the same as of other bodies.
    """

    x: Operand
    y: Operand
    z: Operand
    ix: Operand
    iy: Operand
    iz: Operand

    @property
    def axes(self) -> tuple[Vector, Vector, Vector]:
        """Return axes 1, 2 and 3, space frame."""
        first = Vector(self.ix, self.iy, self.iz)
        third = Vector(self.x, self.y, self.z)
        return first, cross(third, first), third


class Ellipsoid(NamedTuple):
    """Half axes a and b along axes 1 and 2, turned about axis 3 by delta, and c along axis 3.

    Its centre lies at x, y, z from the centre of mass. The arm is the gradient of its support
    function. Vectors are in the axes of the body.
    """

    a: Operand  # a, b, c [m]
    b: Operand
    c: Operand
    cos: Operand  # of delta
    sin: Operand
    x: Operand  # x, y, z [m]
    y: Operand
    z: Operand
    a11: Operand  # the matrix of squares of the half axes, along axes 1, 2, 3 [m^2]
    a12: Operand
    a22: Operand
    a33: Operand

    @property
    def size(self) -> Operand:
        """Return a length [m] by which small distances are measured: half axis c."""
        return self.c

    def half_axes(self, v: Vector) -> Vector:
        """Return the components along the half axes a, b, c of a vector along axes 1, 2, 3.

        `framed.start` and `framed.heading` make the same rotation; a change of one changes all.
        """
        along = self.cos * v.x + self.sin * v.y
        return Vector(along, self.cos * v.y - self.sin * v.x, v.z)

    def squares(self, v: Vector) -> Vector:
        """Return A v, where A = diag(a^2, b^2, c^2) along the half axes."""
        along = self.a11 * v.x + self.a12 * v.y
        return Vector(along, self.a12 * v.x + self.a22 * v.y, self.a33 * v.z)

    def edge(self, up: Vector) -> tuple[Vector, Operand]:
        """Return the highest point from the centre, (3,) [m], and its height above it [m].

        `up` is zhat along axes 1, 2, 3.
        """
        q = self.squares(up)
        k = sqrt(dot(up, q))
        return times(1 / k, q), k

    def arm(self, up: Vector) -> Vector:
        """Return the arm along axes 1, 2, 3, (3,) [m]: by the centre to the lowest point."""
        top, _ = self.edge(up)
        return minus(Vector(self.x, self.y, self.z), top)

    def arm_rate(self, up: Vector, turn: Vector) -> Vector:
        """Return the rate of the arm in the body, where zhat turns by turn = omega x zhat."""
        top, k = self.edge(up)
        return times(1 / k, minus(self.squares(turn), times(dot(turn, top), top)))


def along_axes(v: Vector, u: Frame) -> Vector:
    """Return the components along axes 1, 2, 3 of a vector v in space."""
    return Vector(*(dot(v, axis) for axis in u.axes))


def in_space(v: Vector, u: Frame) -> Vector:
    """Return the vector in space that has the components v along axes 1, 2, 3."""
    one, two, three = u.axes
    return plus(plus(times(v.x, one), times(v.y, two)), times(v.z, three))


def up(u: Frame) -> Vector:
    """Return zhat along axes 1, 2, 3."""
    return Vector(*(axis.z for axis in u.axes))


def over(v: Vector, moments: Vector) -> Vector:
    """Return v divided by `moments`, component by component."""
    return Vector(v.x / moments.x, v.y / moments.y, v.z / moments.z)


def rates_of(v, b):
    """Return I^-1 v, (3,) [rad/s], the angular velocity of a momentum v; both along the axes."""
    return over(v, Vector(b.I1, b.I2, b.I3))


def turns(x, b):
    """Return omega = I^-1 L along the axes of the body, (3,) [rad/s]."""
    return rates_of(along_axes(x.L, x.u), b)


def local_arm(u, b):
    """Return the arm along the axes of the body, (3,) [m]."""
    return b.outline.arm(up(u))


def arm(u, b):
    """Return the arm, (3,) [m]: from the centre of mass to the contact."""
    return in_space(local_arm(u, b), u)


def momentum(omega, u, b):
    """Return L = I omega in space, (3,) [kg m^2/s]; omega in space too."""
    w = along_axes(omega, u)
    return in_space(Vector(b.I1 * w.x, b.I2 * w.y, b.I3 * w.z), u)


def angular_velocity(x, b):
    """Return omega in space, (3,) [rad/s]."""
    return in_space(turns(x, b), x.u)


def axis_rate(x, b):
    """Return the rates of axes 3 and 1 as a Frame [1/s]."""
    one, two, three = x.u.axes
    omega = turns(x, b)
    third = minus(times(omega.y, one), times(omega.x, two))
    return Frame(*third, *minus(times(omega.z, two), times(omega.y, three)))


def arm_velocity(x, b):
    """Return omega x a in space, (3,) [m/s]."""
    return in_space(cross(turns(x, b), local_arm(x.u, b)), x.u)


def held_force(torque, more, a, b):
    """Return the force at the contact point that holds it, (3,) [N].

    Without a force its acceleration is `more`, and I^-1 torque x a in addition, where `torque` is
    that about the centre of mass. The body turns with omega' = (I + m (a^2 - a a))^-1 (torque - m a
    x more), as about a contact at rest. All are along the axes of the body.
    """
    about_contact = minus(torque, times(b.m, cross(a, more)))
    ma2 = b.m * (a.x**2 + a.y**2 + a.z**2)
    moments = Vector(b.I1 + ma2, b.I2 + ma2, b.I3 + ma2)
    p = over(a, moments)
    share = b.m * dot(p, about_contact) / (1 - b.m * dot(p, a))
    turn = plus(over(about_contact, moments), times(share, p))
    return times(b.m, minus(cross(a, turn), more))


def mobility_inverse_times(u, x, b):
    """Return K^-1 x, (3,): the force that gives A the acceleration x.

    x is a vector in space; the impulse that gives the velocity x is the same. K is that of
    `response.gains`.
    """
    none = times(0, x)
    return in_space(held_force(none, along_axes(times(-1, x), u), local_arm(u, b), b), u)


def gyration(omega, b):
    """Return L x omega, (3,) [N m], along the axes of the body: I omega' without torque.

    omega is along the axes too.
    """
    yz = omega.y * omega.z
    zx = omega.z * omega.x
    xy = omega.x * omega.y
    return Vector(b.I2 * yz - b.I3 * yz, b.I3 * zx - b.I1 * zx, b.I1 * xy - b.I2 * xy)


def swing(x, b):
    """Return omega x a' - g zhat along the axes of the body [m/s^2].

    a' is the rate of the arm in space.

    It is the acceleration of the contact point without a force there and without omega'.
    """
    n = up(x.u)
    omega = turns(x, b)
    moves = plus(cross(omega, b.outline.arm(n)), b.outline.arm_rate(n, cross(omega, n)))
    return minus(cross(omega, moves), times(b.g, n))


def bias_vector(x, b):
    """Return the acceleration of the contact point without a force there, (3,) [m/s^2].

    It is the `response.own_bias` of such a body: on a level plane at rest, in still air.
    `response.bias_vector` includes surroundings.
    """
    free = rates_of(gyration(turns(x, b), b), b)
    return in_space(plus(cross(free, local_arm(x.u, b)), swing(x, b)), x.u)


def reaction(x, b):
    """Return the force of the plane on a body that rolls, (3,) [N].

    It is on a level plane at rest, in still air, and equal to `response.held_reaction` there.
    """
    torque = gyration(turns(x, b), b)
    return in_space(held_force(torque, swing(x, b), local_arm(x.u, b), b), x.u)
