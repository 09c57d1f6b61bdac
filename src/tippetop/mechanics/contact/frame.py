"""Bodies without an axis of symmetry: formulas of how they lie, for any convex outline.

Axes 1, 2 and 3 are the principal axes of inertia; the outline may be turned against them. The
motion in contact takes only five functions of how a body lies: the arm, its rate, the height, the
angular velocity of an angular momentum, and the rates of the axes.
"""

from typing import Any, NamedTuple

from ..operand import Operand, Vector, cross, dot, minus, plus, sqrt, times


class Asymmetric(NamedTuple):
    """A body without an axis of symmetry, `b` of every formula."""

    m: Operand  # [kg]
    I1: Operand  # about the centre of mass [kg m^2]
    I2: Operand
    I3: Operand
    g: Operand  # [m/s^2]
    friction: Any  # record of a law
    outline: Any
    clearance: Operand = ()  # as of a `body.Touch`
    lever: Operand = ()
    around: Any = ()


class Frame(NamedTuple):
    """How such a body lies: axis 3 as x, y, z, as of other bodies, and axis 1."""

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

    a: Operand
    b: Operand
    c: Operand
    cos: Operand  # of delta
    sin: Operand
    x: Operand
    y: Operand
    z: Operand

    @property
    def size(self) -> Operand:
        """Return the size [m]."""
        return self.c

    @property
    def reach(self) -> Operand:
        """Return a bound of the distance of its points from the centre of mass [m]."""
        return self.a + self.b + self.c + abs(self.x) + abs(self.y) + abs(self.z)

    def half_axes(self, v: Vector) -> Vector:
        """Return the components of a vector along its half axes."""
        along = self.cos * v.x + self.sin * v.y
        return Vector(along, self.cos * v.y - self.sin * v.x, v.z)

    def squares(self, v: Vector) -> tuple[Vector, Operand]:
        """Return A v and v.A v, where A = diag(a^2, b^2, c^2) in the half axes."""
        d = self.half_axes(v)
        q = Vector(self.a**2 * d.x, self.b**2 * d.y, self.c**2 * d.z)
        along = self.cos * q.x - self.sin * q.y
        return Vector(along, self.sin * q.x + self.cos * q.y, q.z), dot(d, q)

    def arm(self, up: Vector) -> Vector:
        """Return the arm, by the direction of zhat."""
        q, k2 = self.squares(up)
        return minus(Vector(self.x, self.y, self.z), times(1 / sqrt(k2), q))

    def arm_rate(self, up: Vector, turns: Vector) -> Vector:
        """Return the rate of the arm in the body where zhat turns there at this rate."""
        q, k2 = self.squares(up)
        q_dot, _ = self.squares(turns)
        return times(1 / sqrt(k2), minus(times(dot(up, q_dot) / k2, q), q_dot))


def parts(v: Vector, axes: tuple[Vector, Vector, Vector]) -> Vector:
    """Return the components of a vector along the axes of a body."""
    return Vector(*(dot(v, axis) for axis in axes))


def whole(v: Vector, axes: tuple[Vector, Vector, Vector]) -> Vector:
    """Return a vector in space of its components along the axes of a body."""
    one, two, three = axes
    return plus(plus(times(v.x, one), times(v.y, two)), times(v.z, three))


def up(axes: tuple[Vector, Vector, Vector]) -> Vector:
    """Return the components of zhat along the axes of a body."""
    return Vector(*(axis.z for axis in axes))


def moments(b: Asymmetric) -> Vector:
    """Return the principal moments of inertia."""
    return Vector(b.I1, b.I2, b.I3)


def over(v: Vector, by: Vector) -> Vector:
    """Return the quotients of components."""
    return Vector(v.x / by.x, v.y / by.y, v.z / by.z)


def arm(u, b):
    """Return the arm, (3,) [m]: from the centre of mass to the contact."""
    return whole(b.outline.arm(up(u.axes)), u.axes)


def height(u, b):
    """Return the height of the centre of mass above the plane that the body touches [m]."""
    return -arm(u, b).z


def momentum(omega, u, b):
    """Return L = I omega, (3,)."""
    along = zip(moments(b), parts(omega, u.axes), strict=True)
    return whole(Vector(*(moment * rate for moment, rate in along)), u.axes)


def turns(x, b):
    """Return omega = I^-1 L along the axes of the body [rad/s]."""
    return over(parts(x.L, x.u.axes), moments(b))


def angular_velocity(x, b):
    """Return omega, (3,) [rad/s]."""
    return whole(turns(x, b), x.u.axes)


def axis_rate(x, b):
    """Return the rates of axes 3 and 1 [1/s]."""
    one, two, three = x.u.axes
    omega = turns(x, b)
    third = minus(times(omega.y, one), times(omega.x, two))
    return Frame(*third, *minus(times(omega.z, two), times(omega.y, three)))


def arm_velocity(x, b):
    """Return omega x a, (3,) [m/s]."""
    axes = x.u.axes
    return whole(cross(turns(x, b), b.outline.arm(up(axes))), axes)


def inverse_times(v, a, b):
    """Return K^-1 v by the arm a, along the axes of the body.

    It is m (v - w x a), where (I + m (a^2 - a a)) w = m a x v.
    """
    about = Vector(*(one + b.m * dot(a, a) for one in moments(b)))
    w = over(cross(a, v), about)
    p = over(a, about)
    w = plus(w, times(b.m * dot(a, w) / (1 - b.m * dot(a, p)), p))
    return times(b.m, minus(v, times(b.m, cross(w, a))))


def mobility_inverse_times(u, x, b):
    """Return K^-1 x, (3,): the force or impulse for x at the contact."""
    axes = u.axes
    return whole(inverse_times(parts(x, axes), b.outline.arm(up(axes)), b), axes)


def bias(x, b):
    """Return I^-1(L x omega) x a + omega x a' - g zhat along the axes of the body [m/s^2]."""
    axes = x.u.axes
    n = up(axes)
    omega = turns(x, b)
    a = b.outline.arm(n)
    moves = plus(cross(omega, a), b.outline.arm_rate(n, cross(n, omega)))
    free = over(cross(parts(x.L, axes), omega), moments(b))
    return minus(plus(cross(free, a), cross(omega, moves)), times(b.g, n))


def bias_vector(x, b):
    """Return the acceleration of the contact point without a force there, (3,) [m/s^2]."""
    return whole(bias(x, b), x.u.axes)


def resting(x, b):
    """Return the force and torque (3,) on a body whose contact point stays at rest."""
    axes = x.u.axes
    F = whole(inverse_times(bias(x, b), b.outline.arm(up(axes)), b), axes)
    return times(-1, F), times(0, F)
