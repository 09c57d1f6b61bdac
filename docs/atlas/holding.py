"""Formulas that hold as printed, typed from the source and evaluated like the corrections: both sides, by motion."""

from collections.abc import Callable
from functools import cache

import mpmath as mp
from errata_2 import frame
from exact import MOTIONS, UP, of_letters, rate, residual, value

from tippetop.mechanics.operand import cross, dot, plus, times


def angular_velocity(theta, phi, theta_dot, phi_dot, omega3, s):
    """-phi' sin 1hat + theta' 2hat + omega_3 3hat."""
    first, second, third = frame(theta, phi)
    return plus(plus(times(-(phi_dot * s), first), times(theta_dot, second)), times(omega3, third))


def general_potential(z, D, lam, d, m, g, R, alpha, I3, gamma, sigma):
    """The long form (4.12)."""
    X = lam * d.sqrt() + R * (alpha - z) * D
    first = X**2 * (sigma * (alpha - z) ** 2 + gamma) / (R**2 * gamma**2 * (1 - z**2))
    rest = D**2 * (sigma * (1 - z**2) + 1) + 2 * D * sigma * (alpha - z) * X / (R * gamma)
    return m * g * R * (1 - alpha * z) + (first + rest) / (2 * I3 * d)


def inertia_of_theta(alpha, c, s, I3, sigma, gamma):
    """g(cos theta) of (4.11)."""
    return I3 / 2 * (sigma * ((alpha - c) ** 2 + s**2) + gamma)


def force_in_vectors(m, R, alpha, mu, g, I1, u, L, v_A):
    """(3.16)."""
    L3, L2 = dot(L, u), dot(L, L)
    tilt, drag = alpha**2 * (1 - u.z**2), alpha * (alpha * u.z - 1) * mu * dot(v_A, u)
    return (m * g * I1**2 + m * R * alpha * (u.z * L2 - L.z * L3)) / (
        I1**2 + m * I1 * R**2 * (tilt + drag)
    )


def heavy_force_in_vectors(m, l, mu, g, I1, u, L, v_A):
    """(5.6)."""
    above = m * g * I1**2 + m * l * (dot(L, u) * L.z - u.z * dot(L, L))
    return above / (I1**2 + m * l**2 * I1 * (1 - u.z**2) + m * l**2 * I1 * mu * u.z * dot(v_A, u))


def delta(m, R, alpha, I1, I3, s, c):
    """I1 I3 + m R^2 I1 sin^2 + m R^2 I3 (alpha - cos)^2."""
    return I1 * I3 + m * R**2 * I1 * s**2 + m * R**2 * I3 * (alpha - c) ** 2


TIPPE: dict[str, Callable] = {
    "3.7": lambda E, m, g, R, alpha, s_dot, omega, L, c: (
        E, m * dot(s_dot, s_dot) / 2 + dot(omega, L) / 2 + m * g * R * (1 - alpha * c)),
    "3.8": lambda E, F, v_A: (rate(E), value(dot(F, v_A))),
    "3.11": lambda L, mu, g_n, R, alpha, s, nu_y: (rate(L.z), -mu * g_n * R * alpha * s * nu_y),
    "3.12": lambda L, a, F: (rate(L), cross(a, F)),
    "3.13": lambda s_dot, omega_a: (s_dot.z, -omega_a.z),
    "3.14": lambda F, m, g, omega_a: (F.z, m * g - m * rate(omega_a).z),
    "3.16": lambda g_n, m, R, alpha, mu, g, I1, u, L, v_A: (g_n, force_in_vectors(m, R, alpha, mu, g, I1, u, L, v_A)),
    "3.18": lambda L, a, R, alpha, u: (-dot(L, a), R * (L.z - alpha * dot(L, u))),
    "3.21": lambda omega, theta, phi, theta_dot, phi_dot, omega3, s: (
        omega, angular_velocity(theta, phi, theta_dot, phi_dot, omega3, s)),
    "3.22": lambda u, theta, phi, theta_dot, phi_dot, s: (
        rate(u), plus(times(theta_dot, frame(theta, phi)[0]), times(phi_dot * s, frame(theta, phi)[1]))),
    "3.24": lambda R, alpha, mu, g_n, I1, I3, theta_dot, phi_dot, omega3, nu_y, s, c: (
        R * (alpha - c) * mu * g_n * nu_y,
        -I1 * rate(phi_dot) * s - 2 * I1 * phi_dot * theta_dot * c + I3 * omega3 * theta_dot),
    "3.25": lambda R, alpha, mu, g_n, I1, I3, theta_dot, phi_dot, omega3, nu_x, s, c: (
        -R * alpha * g_n * s + R * mu * g_n * nu_x * (1 - alpha * c),
        I1 * rate(theta_dot) - I1 * phi_dot**2 * s * c + I3 * omega3 * phi_dot * s),
    "3.26": lambda I3, omega3, R, mu, g_n, nu_y, s: (I3 * rate(omega3), -R * mu * g_n * nu_y * s),
    "3.29": lambda R, alpha, mu, g_n, I1, I3, theta_dot, phi_dot, omega3, nu_x, s, c: (
        rate(theta_dot),
        s / I1 * (I1 * phi_dot**2 * c - I3 * omega3 * phi_dot - R * alpha * g_n)
        + R * mu * g_n * nu_x / I1 * (1 - alpha * c)),
    "3.30": lambda R, alpha, mu, g_n, I1, I3, theta_dot, phi_dot, omega3, nu_y, s, c: (
        rate(phi_dot),
        (I3 * theta_dot * omega3 - 2 * I1 * theta_dot * phi_dot * c - mu * g_n * nu_y * R * (alpha - c)) / (I1 * s)),
    "3.33": lambda m, R, alpha, mu, g_n, I1, I3, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c: (
        rate(nu_y),
        -mu * g_n * nu_y / (m * I1 * I3) * delta(m, R, alpha, I1, I3, s, c)
        + omega3 * theta_dot * R / I1 * (I3 * (alpha - c) + I1 * c) - phi_dot * nu_x),
    "3.36": lambda L, m, a, v_A, omega_a, g: (
        rate(L), times(m, cross(a, plus(plus(rate(v_A), times(-1, rate(omega_a))), times(g, UP))))),
    "4.14": lambda D, omega3, m, R, alpha, I1, I3, s, c: (D, omega3 * delta(m, R, alpha, I1, I3, s, c).sqrt()),
    "4.15": lambda E_tilde, m, g, R, alpha, omega_a, omega, L, c: (
        E_tilde, m * dot(omega_a, omega_a) / 2 + dot(omega, L) / 2 + m * g * R * (1 - alpha * c)),
    "4.16": lambda E, E_tilde, m, v_A, omega_a: (E, m * dot(v_A, v_A) / 2 - m * dot(v_A, omega_a) + E_tilde),
    "4.17": lambda D, d, gamma, m, R, s, phi_dot, nu_x, nu_y: (
        rate(D), gamma * m * R * s / d.sqrt() * (phi_dot * nu_x + rate(nu_y))),
    "4.18": lambda E_tilde, m, omega_a, v_A: (rate(E_tilde), m * dot(omega_a, rate(v_A))),
    "4.21": lambda E_tilde, theta_dot, z, D, lam, d, m, g, R, alpha, I3, gamma, sigma, s, c: (
        E_tilde,
        inertia_of_theta(alpha, c, s, I3, sigma, gamma) * theta_dot**2
        + general_potential(z, D, lam, d, m, g, R, alpha, I3, gamma, sigma)),
}  # fmt: skip

ROLLING: dict[str, Callable] = {
    "3.38": lambda L, m, a, omega_a, g: (rate(L), times(m, cross(a, plus(times(g, UP), times(-1, rate(omega_a)))))),
    "4.2": lambda m, R, alpha, g, I1, I3, theta_dot, phi_dot, omega3, s, c: (
        rate(theta_dot),
        s / (I1 + m * R**2 * ((alpha - c) ** 2 + s**2))
        * (phi_dot**2 * (I1 * c - m * R**2 * (alpha - c) * (1 - alpha * c))
           - phi_dot * omega3 * (m * R**2 * (1 - alpha * c) + I3)
           - theta_dot**2 * m * R**2 * alpha - m * g * R * alpha)),
    "4.3": lambda m, R, alpha, I1, I3, theta_dot, phi_dot, omega3, s, c: (
        rate(phi_dot),
        omega3 * theta_dot * (I3**2 + m * R**2 * I3 * (1 - alpha * c)) / (s * delta(m, R, alpha, I1, I3, s, c))
        - 2 * theta_dot * phi_dot * c / s),
    "4.4": lambda m, R, alpha, I1, I3, theta_dot, omega3, s, c: (
        rate(omega3),
        -omega3 * theta_dot * s * (m * R**2 * I1 * c + m * R**2 * I3 * (alpha - c)) / delta(m, R, alpha, I1, I3, s, c)),
    "4.6": lambda E, m, g, R, alpha, I1, I3, theta_dot, phi_dot, omega3, s, c: (
        E,
        m * R**2 / 2 * ((alpha - c) ** 2 * (theta_dot**2 + phi_dot**2 * s**2)
                        + s**2 * (theta_dot**2 + omega3**2 + 2 * omega3 * phi_dot * (alpha - c)))
        + (I1 * phi_dot**2 * s**2 + I1 * theta_dot**2 + I3 * omega3**2) / 2 + m * g * R * (1 - alpha * c)),
    "4.9": lambda omega3, phi_dot, D, lam, d, R, alpha, I1, I3, s, c: (
        (value(omega3), value(phi_dot)),
        (value(D / (I3 * d.sqrt())), value((lam + R * (alpha - c) * D / d.sqrt()) / (R * I1 * s**2)))),
    "4.12": lambda E, theta_dot, z, D, lam, d, m, g, R, alpha, I3, gamma, sigma, s, c: (
        E,
        inertia_of_theta(alpha, c, s, I3, sigma, gamma) * theta_dot**2
        + general_potential(z, D, lam, d, m, g, R, alpha, I3, gamma, sigma)),
}  # fmt: skip

FIXED: dict[str, Callable] = {
    "2.22": lambda u, L_A, J1: (rate(u), times(1 / J1, cross(L_A, u))),
    "2.24": lambda u, L_A, m, g, l: (rate(L_A), cross(times(l, u), times(-m * g, UP))),
    "2.33": lambda E, J1, I3, theta_dot, phi_dot, omega3, m, g, l, s, c: (
        E, J1 / 2 * (theta_dot**2 + phi_dot**2 * s**2) + I3 / 2 * omega3**2 + m * g * l * c),
    "2.34": lambda L_A, J1, I3, phi_dot, omega3, s, c: (L_A.z, J1 * s**2 * phi_dot + I3 * c * omega3),
    "2.35": lambda L_A, u, I3, omega3: (dot(L_A, u), I3 * omega3),
    "2.36": lambda phi_dot, L_z, L_3, J1, s, c: (phi_dot, (L_z - L_3 * c) / (J1 * s**2)),
    "2.38": lambda E, J1, I3, theta_dot, L_z, L_3, m, g, l, s, c: (
        E, J1 / 2 * theta_dot**2 + L_3**2 / (2 * I3) + (L_z - L_3 * c) ** 2 / (2 * J1 * s**2) + m * g * l * c),
}  # fmt: skip

GLIDING: dict[str, Callable] = {
    "5.1": lambda L_A, L, m, a, omega_a: (L_A, plus(L, times(m, cross(a, omega_a)))),
    "5.2": lambda L, a, F: (rate(L), cross(a, F)),
    "5.4": lambda L_A, a, m, g, v_A: (rate(L_A), cross(times(m, a), plus(times(g, UP), rate(v_A)))),
    "5.6": lambda g_n, m, l, mu, g, I1, u, L, v_A: (g_n, heavy_force_in_vectors(m, l, mu, g, I1, u, L, v_A)),
    "5.8": lambda L_A, m, a, v_A: (rate(L_A.z), m * cross(value(a), rate(v_A)).z),
    "5.12": lambda E, F, v_A: (rate(E), value(dot(F, v_A))),
    "5.14": lambda I1, I3, l, mu, g_n, theta_dot, phi_dot, omega3, nu_x, s, c: (
        rate(theta_dot),
        (I1 * phi_dot**2 * s * c - I3 * omega3 * phi_dot * s + l * mu * g_n * nu_x * c + l * g_n * s) / I1),
    "5.15": lambda I1, I3, l, mu, g_n, theta_dot, phi_dot, omega3, nu_y, s, c: (
        rate(phi_dot), (I3 * omega3 * theta_dot - 2 * I1 * theta_dot * phi_dot * c + l * mu * g_n * nu_y) / (I1 * s)),
    "5.17": lambda m, I1, I3, l, mu, g_n, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c: (
        rate(nu_x),
        l * s / I1 * (I3 * omega3 * phi_dot * c + I1 * (theta_dot**2 + phi_dot**2 * s**2) - l * g_n * c)
        - mu * g_n * nu_x / (m * I1) * (I1 + m * l**2 * c**2) + nu_y * phi_dot),
    "5.18": lambda m, I1, J1, I3, l, mu, g_n, theta_dot, phi_dot, omega3, nu_x, nu_y: (
        rate(nu_y), -l * I3 * omega3 * theta_dot / I1 - J1 / (m * I1) * mu * g_n * nu_y - nu_x * phi_dot),
    "5.19": lambda L_z, I1, J1, I3, m, l, mu, g_n, theta_dot, omega3, nu_y, s: (
        rate(L_z), I3 * s / I1 * m * l**2 * omega3 * theta_dot + J1 * s / I1 * l * mu * g_n * nu_y),
    "5.22": lambda g_n, m, g, l, theta_dot, s, c: (g_n / m + l * (rate(theta_dot) * s + theta_dot**2 * c), g),
    "5.26": lambda E_tilde, J1, I3, theta_dot, L_z, L_3, m, g, l, s, c: (
        E_tilde, J1 / 2 * theta_dot**2 + L_3**2 / (2 * I3) + (L_z - L_3 * c) ** 2 / (2 * J1 * s**2) + m * g * l * c),
}  # fmt: skip

CYLINDER: dict[str, Callable] = {
    "6.3": lambda I, R, alpha, mu, g_n, theta_dot, nu_x, s, c: (
        I * rate(theta_dot), R * mu * g_n * nu_x * (1 - alpha * c) - R * alpha * g_n * s),
    "6.4": lambda m, I, R, alpha, mu, g_n, theta_dot, nu_x, s, c: (
        rate(nu_x),
        R**2 * alpha * g_n / I * s * (1 - alpha * c) - mu * g_n * nu_x / (m * I) * (I + m * R**2 * (1 - alpha * c) ** 2)
        - R * alpha * theta_dot**2 * s),
    "6.5": lambda g_n, m, g, I, R, alpha, mu, theta_dot, nu_x, s, c: (
        g_n,
        (m * g * I + m * R * alpha * I * theta_dot**2 * c)
        / (I + m * R**2 * alpha**2 * s**2 - m * R**2 * alpha * s * (1 - alpha * c) * mu * nu_x)),
}  # fmt: skip

HOLDING = {
    "gliding tippe top": TIPPE,
    "rolling tippe top": ROLLING,
    "fixed heavy top": FIXED,
    "gliding heavy top": GLIDING,
    "gliding cylinder": CYLINDER,
}


@cache
def worst(states: int = 6) -> dict[str, mp.mpf]:
    """The largest relative residual of each formula, by its number."""
    found: dict[str, mp.mpf] = {}
    for motion, formulas in HOLDING.items():
        letters = [MOTIONS[motion](seed) for seed in range(states)]
        for number, sides in formulas.items():
            found[number] = max(residual(*of_letters(sides, x)) for x in letters)
    return found
