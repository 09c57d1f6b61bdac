"""Corrections 6 to 18, of chapter 3: equations of the tippe top, its spinning and tumbling solutions."""

import random

import mpmath as mp
from errata import Erratum, Finding, Sides
from exact import UP, rate

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import gliding
from tippetop.mechanics.operand import cross, dot, plus, times
from tippetop.mechanics.theory.least_energy import arm_inertia, least_energy
from tippetop.mechanics.theory.modes import linear_modes
from tippetop.mechanics.theory.regimes import regime
from tippetop.mechanics.theory.thresholds import gamma_c, gamma_plus, lambda_s, lambda_u, spin_of
from tippetop.mechanics.theory.tumbling import tumbling_is_stable, tumbling_jellett


def along_e(m, R, alpha, mu, g_n, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c):
    theta_ddot, nu_x_dot = rate(theta_dot), rate(nu_x)
    bend = theta_ddot * (1 - alpha * c) + alpha * theta_dot**2 * s
    return Sides(
        -mu * g_n * nu_x,
        m * nu_x_dot
        - phi_dot * nu_y
        + R * (bend + phi_dot**2 * (alpha - c) + phi_dot * omega3 * s),
        m
        * (
            nu_x_dot
            - phi_dot * nu_y
            + R * (bend + s * (phi_dot**2 * (alpha - c) + phi_dot * omega3))
        ),
    )


def along_2(m, R, alpha, mu, g_n, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c):
    phi_ddot, omega3_dot, nu_y_dot = rate(phi_dot), rate(omega3), rate(nu_y)
    rest = (
        phi_ddot * s * (alpha - c)
        + theta_dot * omega3 * c
        + 2 * phi_dot * theta_dot * c * (alpha - c)
    )
    return Sides(
        -mu * g_n * nu_y,
        m * (nu_y_dot + phi_dot * nu_x - R * (rest + omega3_dot)),
        m * (nu_y_dot + phi_dot * nu_x - R * (rest + omega3_dot * s)),
    )


def rate_of_nu_x(m, R, alpha, mu, I1, I3, g_n, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c, e, b):
    first = R * phi_dot * omega3 * (I3 * (1 - alpha * c) - I1) + g_n * R**2 * alpha * (
        1 - alpha * c
    )
    first = s / I1 * (first - R * I1 * alpha * (theta_dot**2 + phi_dot**2 * s**2))
    friction = mu * g_n * nu_x / (m * I1) * (I1 + m * R**2 * (1 - alpha * c) ** 2 + m * R**2)
    return Sides(rate(nu_x), first - friction + phi_dot * nu_y, gliding.euler_rates(e, b).nu_x)


def normal_force(m, R, alpha, mu, g, I1, I3, g_n, theta_dot, phi_dot, omega3, nu_x, s, c, e, b):
    above = (
        m * g * I1
        + m * R * alpha * c * (I1 * phi_dot**2 * s**2 + I1 * theta_dot**2)
        - I3 * phi_dot * omega3 * s**2
    )
    below = I1 + m * R**2 * alpha**2 * s**2 - m * R**2 * alpha * s * (1 - alpha * c) * mu * nu_x
    return Sides(g_n, above / below, contact.g_n(gliding.euler_scalars(e, b), b))


def jellett(L, a, R, alpha, I1, I3, theta_dot, omega3, s, c, scalars, b):
    printed = R * I1 * theta_dot * s**2 - R * (alpha - c) * I3 * omega3
    return Sides(-dot(L, a), printed, contact.jellett(scalars, b))


def jellett_of_tumbling(lam, m, g, R, alpha, I1, I3, z, b):
    gamma = I3 / I1
    printed = mp.sqrt(R * alpha * m * g * I1 * gamma / (alpha + (gamma - 1) * z)) * R / gamma
    return Sides(lam, printed * ((alpha - z) ** 2 + gamma * (1 - z**2)), tumbling_jellett(z, b))


def remainder_of_energy(E, lam, L, omega, a, u, s_dot, m, I1, I3, c, b):
    """Printed: the same at a state with the same 3hat, s', lambda and the same L across the plane of 3hat and zhat."""
    in_plane = cross(a, cross(u, UP))  # across a, so that lambda = -L.a stays
    other = plus(L, times(1 / dot(in_plane, in_plane), in_plane))
    energy = m * dot(s_dot, s_dot) / 2 + dot(_angular_velocity(other, u, I1, I3), other) / 2
    printed = energy + contact.height_energy(c, b) - least_energy(c, lam, b)
    turn = plus(omega, times(lam / arm_inertia(c, b), a))  # omega - omega_lambda
    inertia = plus(times(I1, turn), times((I3 - I1) * dot(u, turn), u))
    return Sides(
        E - least_energy(c, lam, b), printed, m * dot(s_dot, s_dot) / 2 + dot(turn, inertia) / 2
    )


def _angular_velocity(L, u, I1, I3):
    return plus(times(1 / I1, L), times((1 / I3 - 1 / I1) * dot(L, u), u))


def energy_of_tumbling(E, lam, m, g, R, alpha, gamma, I1, z, b):
    G = R**2 * (1 - z**2) + gamma * (alpha - z) ** 2
    return Sides(E, lam**2 / (2 * I1 * G) + m * g * R * (1 - alpha * z), least_energy(z, lam, b))


def body_of_ratio(gamma, alpha="0.3"):
    """The body of the source's figure 4.1 with another I1 = gamma I3."""
    m, R, alpha = mp.mpf("0.02"), mp.mpf("0.02"), mp.mpf(alpha)
    I3 = m * R**2 * 2 / 5
    return contact.Touch(m, R, alpha * R, mp.mpf(gamma) * I3, I3, mp.mpf("9.82"), None)


def curvature(z, b):
    """Whether E_lambda has a minimum by theta at the tumbling state z."""
    lam = tumbling_jellett(z, b)
    return bool(mp.diff(lambda theta: least_energy(mp.cos(theta), lam, b), mp.acos(z), 2) > 0)


def stability_of_tumbling():
    """Random tumbling states: does the condition say what the second derivative of E_lambda says?"""
    draw, transcribed, corrected, cases = random.Random(14), 0, 0, 300
    for _ in range(cases):
        alpha = mp.mpf(draw.uniform(0.05, 0.9))
        gamma, z = 1 - alpha + 2 * alpha * mp.mpf(draw.random()), mp.mpf(draw.uniform(-0.99, 0.99))
        b = body_of_ratio(gamma, alpha)
        stable = curvature(z, b)
        transcribed += stable == bool(
            z > 0 and gamma * (1 - alpha**2) * gamma / 3 < ((1 - gamma) * z - alpha) ** 2
        )
        corrected += stable == bool(tumbling_is_stable(float(z), floats(b)))
    return [
        Finding(
            f"of {cases} random tumbling states, the transcribed condition is right for",
            cases,
            None,
            transcribed,
        ),
        Finding(
            f"of {cases} random tumbling states, the corrected condition is right for",
            None,
            cases,
            corrected,
        ),
    ]


def jellett_by_3_64(lam, R, alpha, I1, I3, phi_dot, omega3, s, c, scalars, b):
    printed = R * (I1 * phi_dot * s**2 + I3 * omega3 * (alpha - c))
    return Sides(lam, printed, contact.jellett(scalars, b))


def jellett_by_3_66(lam, m, R, alpha, g, I1, I3, c, b):
    root = mp.sqrt(m * R**3 * alpha * g / (I3 * (alpha - c) + I1 * c))
    return Sides(
        lam,
        root * ((I1 - I3) * c**2 - 2 * alpha * I3 * c + I1 - I3 * alpha**2),
        tumbling_jellett(c, b),
    )


def tumbling_always_stable():
    b = body_of_ratio("0.75")
    least = round(float(gamma_plus(b.c / b.R)), 2)
    rows = [
        Finding(r"$\alpha=0.3$: the smallest $\gamma$ for which the claim holds", 0.7, 0.84, least)
    ]
    for theta in ("0.2", "0.4", "2"):
        case = rf"$\gamma=0.75$: the tumbling state at $\theta={theta}$ is stable"
        rows.append(Finding(case, True, theta == "2", curvature(mp.cos(mp.mpf(theta)), b)))
    return rows


def floats(b):
    """The body in double precision with the source's friction law."""
    from tippetop.mechanics.friction import Viscous

    return contact.Touch(*map(float, b[:6]), Viscous(0.3))


def only_the_inverted_state():
    b = floats(body_of_ratio("0.72"))
    lam = float((lambda_s(b) + lambda_u(b)) / 2)
    grows = bool(linear_modes(spin_of(lam, b), b)[0].real > 0)
    below, states = bool(lambda_u(b) < lambda_s(b)), len(regime(lam, b).attractors)
    return [
        Finding(r"$\alpha=0.3$, $\gamma=0.72<\gamma_c$: $\lambda_u<\lambda_s$", True, False, below),
        Finding(
            r"the upright spin of $\lambda=\frac12(\lambda_s+\lambda_u)$ is unstable",
            True,
            False,
            grows,
        ),
        Finding(r"number of stable states at that $\lambda$", 1, 2, states),
        Finding(r"$\gamma_c$ at $\alpha=0.3$", None, 0.7465, round(gamma_c(0.3), 4)),
    ]


M, B, S = "misprint", "bracket", "statement"
TOP = "gliding tippe top"
EULER = '`tt.run(..., form="euler")`'

ERRATA = (
    Erratum(
        6, "(3.27)", B,
        r"m\dot\nu_x-\dot\varphi\nu_y+R\big(\ddot\theta(1-\alpha\cos\theta)+\alpha\dot\theta^2\sin\theta+\dot\varphi^2"
        r"(\alpha-\cos\theta)+\dot\varphi\omega_3\sin\theta\big)=-\mu g_n\nu_x",
        r"m\Big\{\dot\nu_x-\dot\varphi\nu_y+R\big(\ddot\theta(1-\alpha\cos\theta)+\alpha\dot\theta^2\sin\theta+\sin"
        r"\theta\,[\dot\varphi^2(\alpha-\cos\theta)+\dot\varphi\omega_3]\big)\Big\}=-\mu g_n\nu_x",
        EULER, along_e, TOP,
    ),
    Erratum(
        7, "(3.28)", M,
        r"m\Big\{\dot\nu_y+\dot\varphi\nu_x-R\big(\ddot\varphi\sin\theta(\alpha-\cos\theta)+\dot\omega_3+\dot\theta"
        r"\omega_3\cos\theta+2\dot\varphi\dot\theta\cos\theta(\alpha-\cos\theta)\big)\Big\}=-\mu g_n\nu_y",
        r"m\Big\{\dots+\dot\omega_3\sin\theta+\dots\Big\}=-\mu g_n\nu_y\qquad\text{as in (3.49)}",
        EULER, along_2, TOP,
    ),
    Erratum(
        8, "(3.32), again as (5.62)", M,
        r"-\frac{\mu g_n\nu_x}{mI_1}\big(I_1+mR^2(1-\alpha\cos\theta)^2+mR^2\big)",
        r"-\frac{\mu g_n\nu_x}{mI_1}\big(I_1+mR^2(1-\alpha\cos\theta)^2\big)\qquad\text{as in (6.4)}",
        EULER, rate_of_nu_x, TOP,
    ),
    Erratum(
        9, "(3.34)", B,
        r"g_n=\frac{mgI_1+mR\alpha\cos\theta\,(I_1\dot\varphi^2\sin^2\theta+I_1\dot\theta^2)-I_3\dot\varphi\omega_3"
        r"\sin^2\theta}{I_1+mR^2\alpha^2\sin^2\theta-mR^2\alpha\sin\theta(1-\alpha\cos\theta)\mu\nu_x}",
        r"g_n=\frac{mgI_1+mR\alpha\big[\cos\theta\,(I_1\dot\varphi^2\sin^2\theta+I_1\dot\theta^2)-I_3\dot\varphi\omega_3"
        r"\sin^2\theta\big]}{\dots}\qquad\text{as in (3.50)}",
        "the column `normal_force`", normal_force, TOP,
    ),
    Erratum(
        10, "(3.35)", M,
        r"\lambda=RI_1\dot\theta\sin^2\theta-R(\alpha-\cos\theta)I_3\omega_3",
        r"\lambda=RI_1\dot\varphi\sin^2\theta-R(\alpha-\cos\theta)I_3\omega_3\qquad\text{as in (4.5)}",
        "the column `jellett`", jellett, TOP,
    ),
    Erratum(
        11, "(3.42) and the line below it", "misprint or bracket",
        r"\gamma=I_3/I_1",
        r"\gamma=I_1/I_3,\qquad\lambda=\frac R\gamma\sqrt{\frac{R\alpha mgI_1\gamma}{\alpha+(\gamma-1)\hat3_{\hat z}}}"
        r"\,\big[(\alpha-\hat3_{\hat z})^2+\gamma(1-\hat3_{\hat z}^2)\big]",
        "`tt.theory.asymptotic_states`", jellett_of_tumbling, "tumbling tippe top",
    ),
    Erratum(
        12, "(3.43)", S,
        r"E-E_\lambda(\hat3_{\hat z})=E_\perp(\hat3,L_\perp,\dot r)",
        r"E-E_\lambda(\hat3_{\hat z})=\tfrac12m|\dot s|^2+\tfrac12(\omega-\omega_\lambda)\cdot\mathbf I(\omega-"
        r"\omega_\lambda),\qquad\omega_\lambda=-\frac{\lambda\,a}{a\cdot\mathbf Ia}",
        "`tt.theory.least_energy`", remainder_of_energy, TOP,
        "the remainder is not negative and vanishes at the solutions of Proposition 3.3.1 alone, so Theorem 3.3.1 and "
        "the use made of $E_\\lambda$ stand. It has one more part, of the component of $L$ in the plane of $\\hat3$ "
        "and $\\hat z$ across $a$: as printed the second state below would have the same remainder as the first.",
    ),
    Erratum(
        13, "(3.44)", M,
        r"G=R^2(1-\hat3_{\hat z}^2)+\gamma(\alpha-\hat3_{\hat z})^2",
        r"G=R^2\big[(1-\hat3_{\hat z}^2)+(\alpha-\hat3_{\hat z})^2/\gamma\big]",
        "`tt.theory.least_energy`", energy_of_tumbling, "tumbling tippe top",
    ),
    Erratum(
        14, "Theorem 3.3.2, third item", "misprint or bracket",
        r"0<\hat3_{\hat z}<1,\qquad\tfrac13\big(\gamma(1-\alpha^2)\,\gamma\big)<\big((1-\gamma)\hat3_{\hat z}-\alpha"
        r"\big)^2",
        r"-1<\hat3_{\hat z}<1,\qquad\tfrac13\,\gamma(1-\alpha^2-\gamma)<\big((1-\gamma)\hat3_{\hat z}-\alpha\big)^2",
        "`tt.theory.asymptotic_states`, `tt.theory.regime`", stability_of_tumbling,
    ),
    Erratum(
        15, "(3.64)", M,
        r"\lambda=R\big(I_1\dot\varphi\sin^2\theta+I_3\omega_3(\alpha-\cos\theta)\big)",
        r"\lambda=R\big(I_1\dot\varphi\sin^2\theta-I_3\omega_3(\alpha-\cos\theta)\big)",
        "the column `jellett`", jellett_by_3_64, "tumbling tippe top",
    ),
    Erratum(
        16, "(3.66)", M,
        r"\lambda=\sqrt{\frac{mR^3\alpha g}{I_3(\alpha-\cos\theta)+I_1\cos\theta}}\,\big((I_1-I_3)\cos^2\theta-2\alpha "
        r"I_3\cos\theta+I_1-I_3\alpha^2\big)",
        r"\lambda=\sqrt{\dots}\,\big((I_3-I_1)\cos^2\theta-2\alpha I_3\cos\theta+I_1+I_3\alpha^2\big)",
        "`tt.theory.asymptotic_states`", jellett_by_3_66, "tumbling tippe top",
    ),
    Erratum(
        17, "section 3.3.3, figure 3.3", S,
        r"1-\alpha<\gamma<1+\alpha\ \Rightarrow\ \text{every tumbling state is stable}",
        r"\gamma\ge\gamma_+=\tfrac18(1-\alpha)\big(7+\alpha+\sqrt{1+14\alpha+\alpha^2}\big)\ \Leftrightarrow\ "
        r"\text{every tumbling state is stable}",
        "`tt.theory.thresholds` (`gamma_plus`), `tt.theory.asymptotic_states`", tumbling_always_stable,
    ),
    Erratum(
        18, "chapter 1, section 3.3.3, section 4.2", S,
        r"\lambda>\lambda_s\ \Rightarrow\ \text{only the inverted spin is stable}",
        r"\begin{gathered}\lambda>\max(\lambda_s,\lambda_u)\ \Rightarrow\ \text{only the inverted spin is stable}\\"
        r"\lambda_u<\lambda_s\iff\gamma>\gamma_c=\frac{(1-\alpha^2)(1+3\alpha^2)}{1+6\alpha^2+\alpha^4}\end{gathered}",
        "`tt.theory.regime`, `tt.theory.thresholds` (`gamma_c`, `lambda_u`, `lambda_s`)", only_the_inverted_state,
    ),
)  # fmt: skip
