"""Which way the whole body is turned: its axes 1 and 3 in the space frame, and so the Euler angle
psi.

Angles are phi, theta, psi about z, y, z: the body's axes are R_z(phi) R_y(theta) R_z(psi) of those
of space, so that axis 3 is 3hat with azimuth phi, and axis 1 is 1hat cos(psi) + 2hat sin(psi) with
1hat = cos(theta) e - sin(theta) zhat. (The angles of the source are about z, x, z: its phi is ours
+ pi/2, its psi ours - pi/2.)

Forms that pass the poles carry a transverse unit vector f that follows the axis without spin about
it, and the angle `turn` from f to axis 1, zero at the start, turn' = omega_3. Both are regular
everywhere, and f is as slow as the axis.
"""

from collections.abc import Callable
from typing import Any

from ..operand import Vector, atan2, cos, cross, dot, formula, plus, sin, sqrt, times
from ..system import Integral, Orientation
from ..units import ONE, RADIAN
from .body import axis


PSI = "turn psi of the body about its axis, from 1hat, in (-pi, pi]; undefined (NaN) at a pole"


@formula
def transport(f, u, u_dot):
    """Return f' = -(f.3hat') 3hat [1/s]: f stays transverse, without spin about the axis.

    u is 3hat and u_dot its rate, (3,) each; the rate of the integrals fx, fy, fz.
    """
    return times(-dot(f, u_dot), u)


@formula
def turned(f, turn, u):
    """Return the unit vector at the angle `turn` [rad] from f about the unit vector u, (3,).

    f, (3,), is made transverse to u and of length 1 first.
    """
    across = plus(f, times(-dot(f, u), u))
    v = plus(times(cos(turn), across), times(sin(turn), cross(u, across)))
    return times(1 / sqrt(dot(v, v)), v)


@formula
def axes_of_angles(s, z, phi, psi):
    """Return axes 1 and 3 of the body, (3,) each.

    s, z are sin(theta), cos(theta); phi, psi are angles [rad]. `psi_of_axes` returns this psi.
    """
    ex = cos(phi)
    ey = sin(phi)
    along = cos(psi)
    across = sin(psi)
    first = Vector(along * (z * ex) - across * ey, along * (z * ey) + across * ex, -(along * s))
    return first, Vector(s * ex, s * ey, z)


@formula
def psi_of_axes(first, u):
    """Return psi in (-pi, pi] [rad], from axes 1 (`first`) and 3 (u), (3,) each.

    Like phi, it is 0/0 in meaning exactly at a pole.
    """
    return atan2(u.x * first.y - u.y * first.x, -first.z)


def axis_1(data: dict[str, Any], s: Any, z: Any) -> Vector:
    """Return axis 1 at the start, (3,).

    s, z are sin(theta), cos(theta). `data`, the initial numbers of the user as `Integral.start`
    gets them, may have phi and psi, which are 0 otherwise.
    """
    phi, psi = (data.get(name, 0 * z) for name in ("phi", "psi"))  # 0 of the type of z
    first, _ = axes_of_angles(s, z, phi, psi)
    return first


def carried_along(axis_rate: Callable, spin: Callable) -> Orientation:
    """Return the orientation in a form that passes the poles, whose state has 3hat.

    Parameters
    ----------
    axis_rate
        axis_rate(q, b) -> 3hat' [1/s].
    spin
        spin(q, b) -> omega_3 [rad/s].
    """

    def f(carried: Any) -> Vector:
        """Return f from the record of integrals, (3,)."""
        return Vector(carried.fx, carried.fy, carried.fz)

    def axes(q: Any, carried: Any, b: Any) -> tuple[Vector, Vector]:
        """Return axes 1 and 3 of the body, (3,) each: f turned by the angle `turn`, and 3hat."""
        return turned(f(carried), carried.turn, axis(q)), axis(q)

    text = "transverse unit vector that follows the axis without spin, {} component"
    transverse = (
        Integral(
            f"f{c}",
            ONE,
            text.format(c),
            lambda q, carried, b, k=k: transport(f(carried), axis(q), axis_rate(q, b))[k],
            lambda data, s, z, k=k: axis_1(data, s, z)[k],
        )
        for k, c in enumerate("xyz")
    )
    turn = Integral("turn", RADIAN, "angle from f to body axis 1", lambda q, carried, b: spin(q, b))
    return Orientation(axes, (*transverse, turn), psi_of_axes)


def by_angles(theta: Callable, rate: Any = None) -> Orientation:
    """Return the orientation in a form of angles, whose integral phi it reads.

    Parameters
    ----------
    theta
        theta(q) -> sin(theta), cos(theta).
    rate
        rate(q, carried, b) -> psi' = omega_3 - phi' cos(theta) [rad/s]. None: that of a cylinder,
        which turns by theta about the horizontal y. This is phi = psi = 0 of a top.
    """

    def axes(q: Any, carried: Any, b: Any) -> tuple[Vector, Vector]:
        """Return axes 1 and 3 of the body, (3,) each, from theta, phi and psi."""
        s, z = theta(q)
        phi, psi = (getattr(carried, name, 0 * z) for name in ("phi", "psi"))
        return axes_of_angles(s, z, phi, psi)

    if rate is None:
        return Orientation(axes)
    text = "turn psi of the body about its axis, not wrapped"
    psi = Integral("psi", RADIAN, text, rate, lambda data, s, z: data.get("psi", 0 * z))
    return Orientation(axes, (psi,), psi_of_axes)
