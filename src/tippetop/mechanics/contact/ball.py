"""A ball of the body that touches the plane at one point: what a force there does to that point.

The centre of the ball lies at `offset` along 3hat from the centre of mass: the body itself (alpha R, R), its stem
(alpha R + h, r), a cylinder in its plane. The contact arm is a = offset 3hat - radius zhat. Components are those along
e, 2hat, zhat (names without `vector`), singular at the poles, or of space (`Vector`), regular everywhere.
"""

from typing import NamedTuple

from ..operand import Operand, Vector, cross, dot, formula, plus, times


class Ball(NamedTuple):
    """m [kg], I1 and I3 [kg m^2] about the centre of mass, g [m/s^2], Coulomb's mu, offset and radius [m]."""

    m: Operand
    I1: Operand
    I3: Operand
    g: Operand
    mu: Operand
    offset: Operand  # varsigma: from the centre of mass to the centre of the ball, along 3hat; of any sign
    radius: Operand  # rho


class Components(NamedTuple):
    """Components of a vector along e, 2hat and zhat."""

    e: Operand
    t: Operand  # along 2hat = zhat x e
    z: Operand


class Mobility(NamedTuple):
    """K: acceleration of the contact point per force there, velocity per impulse [1/kg]; K_e2 = K_2z = 0."""

    ee: Operand
    zz: Operand
    ez: Operand
    tt: Operand  # K_22


# --- geometry and velocities ------------------------------------------------------------------------------------------


@formula
def height(z, ball):
    """H = radius - offset z [m]: the centre of mass above the contact."""
    return ball.radius - ball.offset * z


@formula
def gap(centre_height, z, ball):
    """The gap between ball and plane [m], from the height of the centre of mass."""
    return centre_height - height(z, ball)


@formula
def arm(u, ball):
    """a = offset 3hat - radius zhat, (3,) [m]: from the centre of mass to the contact."""
    return Vector(ball.offset * u.x, ball.offset * u.y, ball.offset * u.z - ball.radius)


@formula
def axis_rate(u, L, ball):
    """3hat' = L x 3hat/I1 [1/s]. [T 3.17]"""
    return times(1 / ball.I1, cross(L, u))


@formula
def angular_velocity(u, L, ball):
    """omega, (3,) [rad/s], of the axis and the momentum about the centre of mass."""
    return plus(times(1 / ball.I1, L), times((1 / ball.I3 - 1 / ball.I1) * dot(L, u), u))


@formula
def arm_velocity(u, L, ball):
    """omega x a, (3,) [m/s]: what the rotation adds to the velocity of the contact point."""
    u_dot, w = axis_rate(u, L, ball), angular_velocity(u, L, ball)
    return Vector(
        ball.offset * u_dot.x - ball.radius * w.y, ball.offset * u_dot.y + ball.radius * w.x, ball.offset * u_dot.z
    )


@formula
def contact_velocity(u, L, V, ball):
    """v_A = V + omega x a, (3,) [m/s]; V is the velocity of the centre of mass. In flight: of the lowest point."""
    return plus(V, arm_velocity(u, L, ball))


@formula
def centre_velocity(u, L, v, ball):
    """The velocity of the centre of mass, (3,) [m/s], where that of the contact point is v."""
    return plus(v, times(-1, arm_velocity(u, L, ball)))


@formula
def arm_components(s, z, theta_dot, phi_dot, omega3, ball):
    """omega x a [m/s]; s, z = sin(theta), cos(theta). [contact 0]"""
    across = s * (ball.radius * omega3 + phi_dot * (ball.offset - ball.radius * z))
    return Components(-(theta_dot * height(z, ball)), across, -(ball.offset * (theta_dot * s)))


@formula
def jellett(u, L, ball):
    """Jellett's integral -L.a = radius L_z - offset L_3 [kg m^3/s] of this ball: no force at its contact changes it."""
    return ball.radius * L.z - ball.offset * dot(L, u)


# --- what a force at the contact does ---------------------------------------------------------------------------------


@formula
def mobility(s, z, ball):
    """K by sin(theta), cos(theta). [contact 1]"""
    H, lever = height(z, ball), ball.offset * s
    return Mobility(
        1 / ball.m + H**2 / ball.I1,
        1 / ball.m + lever**2 / ball.I1,
        lever * H / ball.I1,
        1 / ball.m + (ball.offset - ball.radius * z) ** 2 / ball.I1 + (ball.radius * s) ** 2 / ball.I3,
    )


class Spin(NamedTuple):
    """What a torque about the vertical does: to v_2 and to Omega_z [1/(kg m), 1/(kg m^2)]."""

    across: Operand
    about: Operand


@formula
def spin_mobility(s, z, ball):
    """By sin(theta), cos(theta); an impulse along 2hat gives Omega_z as much as the torque gives v_2."""
    excess = 1 / ball.I3 - 1 / ball.I1
    return Spin(s * (ball.offset / ball.I1 + ball.radius * z * excess), s**2 / ball.I1 + z**2 / ball.I3)


@formula
def torque_acceleration(u, tau, ball):
    """(I^-1 tau) x a, (3,) [m/s^2]: what a torque about the centre of mass gives the contact point."""
    turn = plus(times(1 / ball.I1, tau), times((1 / ball.I3 - 1 / ball.I1) * dot(tau, u), u))
    return cross(turn, arm(u, ball))


@formula
def mobility_times(u, x, ball):
    """K x, (3,): x/m + (I^-1 (a x x)) x a."""
    return plus(times(1 / ball.m, x), torque_acceleration(u, cross(arm(u, ball), x), ball))


@formula
def mobility_inverse_times(u, x, ball):
    """K^-1 x, (3,): the force or impulse for x at the contact; K = kappa - a a/I1 + excess k k, k = zhat x 3hat."""
    return other_mobility_inverse_times(u, x, ball.radius**2 * (1 / ball.I3 - 1 / ball.I1), ball)


@formula
def other_mobility_inverse_times(u, x, excess, ball):
    """The same of another excess, which is what a torque about the vertical changes of K."""
    a = arm(u, ball)
    a2 = ball.offset**2 + ball.radius**2 - 2 * (ball.offset * ball.radius * u.z)
    kappa = 1 / ball.m + a2 / ball.I1
    across = u.x * x.y - u.y * x.x  # k.x
    along_k = -(excess * across) / (kappa + excess * (u.x * u.x + u.y * u.y))
    along_a = ball.m * dot(a, x) / ball.I1
    return Vector(
        (x.x + along_a * a.x - along_k * u.y) / kappa,
        (x.y + along_a * a.y + along_k * u.x) / kappa,
        (x.z + along_a * a.z) / kappa,
    )


@formula
def bias(s, z, theta_dot, phi_dot, omega3, ball):
    """b, the acceleration of the contact point without a force there [m/s^2]. [contact 1]"""
    H, q, swing = height(z, ball), ball.offset - ball.radius * z, theta_dot**2 + (phi_dot * s) ** 2
    return Components(
        s * phi_dot * omega3 * (ball.I3 * H / ball.I1 - ball.radius) - ball.offset * (s * swing),
        omega3 * theta_dot * (ball.I3 * q / ball.I1 + ball.radius * z),
        -ball.g - ball.offset * (z * swing - ball.I3 * (phi_dot * omega3 * s**2) / ball.I1),
    )


@formula
def bias_vector(u, L, ball):
    """b, (3,) [m/s^2]: (1/I3 - 1/I1) L_3 3hat' x a + offset 3hat'' - g zhat, 3hat'' of free rotation."""
    u_dot, L3 = axis_rate(u, L, ball), dot(L, u)
    turn = cross(u_dot, arm(u, ball))
    precession, swing = cross(u, u_dot), dot(u_dot, u_dot)
    spin, w3 = (1 / ball.I3 - 1 / ball.I1) * L3, L3 / ball.I3
    return Vector(
        spin * turn.x + ball.offset * (w3 * precession.x - swing * u.x),
        spin * turn.y + ball.offset * (w3 * precession.y - swing * u.y),
        spin * turn.z + ball.offset * (w3 * precession.z - swing * u.z) - ball.g,
    )


@formula
def contact_acceleration(b, K, F):
    """b + K F, Components [m/s^2]."""
    return Components(b.e + K.ee * F.e + K.ez * F.z, b.t + K.tt * F.t, b.z + K.ez * F.e + K.zz * F.z)


@formula
def contact_acceleration_vector(u, b, F, ball):
    """b + K F, (3,) [m/s^2]."""
    return plus(b, mobility_times(u, F, ball))


@formula
def euler_accelerations(s, z, theta_dot, phi_dot, omega3, F, ball):
    """theta'', phi'' and omega_3' [rad/s^2] with the force F, Components, at the contact; phi'' is 0/0 at a pole."""
    q = ball.offset - ball.radius * z
    theta_dot2 = (
        s * (phi_dot**2 * z - ball.I3 * omega3 * phi_dot / ball.I1)
        - (ball.offset * s * F.z + height(z, ball) * F.e) / ball.I1
    )
    phi_dot2 = (ball.I3 * omega3 * theta_dot + q * F.t) / (ball.I1 * s) - 2 * theta_dot * phi_dot * z / s
    return theta_dot2, phi_dot2, ball.radius * s * F.t / ball.I3
