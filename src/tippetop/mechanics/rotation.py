"""Rotations as unit quaternions w, x, y, z.

They turn body axes into space axes: v_space = q v_body q*.
"""

from typing import NamedTuple

import numpy as np

from .operand import Operand, Vector, atan2, cos, cross, dot, formula, plus, sin, sqrt, times


class Quaternion(NamedTuple):
    """A rotation; of unit length."""

    w: Operand
    x: Operand
    y: Operand
    z: Operand


@formula
def after(a, b):
    """Return the rotation by b and then by a: the product a b of quaternions."""
    return Quaternion(
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
    )


@formula
def inverse(q):
    """Return the inverse rotation of a unit quaternion q: from space to body axes."""
    return Quaternion(q.w, -q.x, -q.y, -q.z)


@formula
def turn(axis, angle):
    """Return the rotation by `angle` [rad] about `axis`, a unit vector."""
    s = sin(angle / 2)
    return Quaternion(cos(angle / 2), s * axis.x, s * axis.y, s * axis.z)


@formula
def swing(u, v):
    """Return the smallest rotation that takes the unit vector u to v, which is not opposite."""
    w = 1 + dot(u, v)
    c = cross(u, v)
    k = 1 / sqrt(w * w + dot(c, c))
    return Quaternion(k * w, k * c.x, k * c.y, k * c.z)


@formula
def axes(q):
    """Return the axes 1, 2, 3 of the body in space, three Vectors, of a unit quaternion q.

    They are the columns of the rotation matrix.
    """
    w, x, y, z = q
    return (
        Vector(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        Vector(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
        Vector(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
    )


@formula
def rotated(q, v):
    """Return the vector v, (3,), turned by the unit quaternion q: from body axes to space."""
    u = Vector(q.x, q.y, q.z)
    t = times(2, cross(u, v))
    return plus(plus(v, times(q.w, t)), cross(u, t))


@formula
def outer(first, third):
    """Return 4 q q^t of the rotation that turns the body's axes 1 and 3 into these, four rows.

    Each row is q times a number.
    """
    (a, d, g), (b, e, h), (c, f, i) = first, cross(third, first), third
    return (
        Quaternion(1 + a + e + i, h - f, c - g, d - b),
        Quaternion(h - f, 1 + a - e - i, b + d, c + g),
        Quaternion(c - g, b + d, 1 - a + e - i, f + h),
        Quaternion(d - b, c + g, f + h, 1 - a - e + i),
    )


@formula
def cubic(a, da, b, db, s):
    """Return Hermite's cubic at the fraction s of an interval.

    a and b are its values at the ends, da and db its slopes times the length of the interval.
    """
    r = 1 - s
    return r * r * (a * (1 + 2 * s) + da * s) + s * s * (b * (3 - 2 * s) - db * r)


@formula
def between(p, wp, q, wq, h, s):
    """Return the rotation at the fraction s of an interval of length h between two rotations.

    The rotations p and q have the angular velocities wp and wq. Axis 3 is a cubic through both ends
    with their velocities; the turn about it is one too, with omega_3 as its slope, so that it may
    be many times around. Pages have it as JavaScript: it may use functions of `writing` only.
    """
    u = axes(p)[2]
    v = axes(q)[2]
    du = times(h, cross(wp, u))
    dv = times(h, cross(wq, v))
    rest = after(q, inverse(after(swing(u, v), p)))
    some = 2 * atan2(rest.x * v.x + rest.y * v.y + rest.z * v.z, rest.w)
    first = h * dot(wp, u)
    last = h * dot(wq, v)
    # the number of turns is that of the mean omega_3
    whole = some + 2 * np.pi * np.rint(((first + last) / 2 - some) / (2 * np.pi))
    w = Vector(*(cubic(a, da, b, db, s) for a, da, b, db in zip(u, du, v, dv, strict=True)))
    w = times(1 / sqrt(dot(w, w)), w)
    return after(turn(w, cubic(0, first, whole, last, s)), after(swing(u, w), p))
