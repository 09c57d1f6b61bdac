"""Corrections 25 to 36, of chapter 5 and appendix A: the gliding heavy top and its limit from the tippe top."""

import mpmath as mp
from errata import Erratum, Finding, Sides
from exact import UP, Jet, dot, rate, value

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import gliding
from tippetop.mechanics.friction import Viscous
from tippetop.mechanics.operand import cross
from tippetop.mechanics.systems import heavy_top, tippe_top
from tippetop.mechanics.theory.modes import linear_modes
from tippetop.mechanics.theory.thresholds import sleeping_spin


def momentum_about_the_vertical(L, L_A, J1, I3, phi_dot, omega3, s, c):
    return Sides(J1 * phi_dot * s**2 + I3 * omega3 * c, L.z, L_A.z)


def energy(E, m, l, g, J1, I3, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c, e, b):
    rest = (J1 * (theta_dot**2 + phi_dot**2 * s**2) + I3 * omega3**2) / 2 + m * g * l * c
    printed = m * (nu_x**2 + nu_y**2) / 2 + m * l * (nu_x * theta_dot * c + nu_y * phi_dot) + rest
    return Sides(E, printed, contact.energy(gliding.euler_scalars(e, b), b))


def rate_of_energy(E, m, l, g, J1, I3, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c):
    theta2, phi2, x_dot, y_dot = (rate(x) for x in (theta_dot, phi_dot, nu_x, nu_y))
    gliding = m * (nu_x * x_dot + nu_y * y_dot)
    along = x_dot * theta_dot * c + nu_x * theta2 * c - nu_x * theta_dot**2 * s
    spin = theta2 * theta_dot + phi2 * phi_dot * s**2
    printed = gliding + m * l * (along - y_dot * phi_dot + nu_x * phi2)
    printed += J1 * (spin + phi_dot**2 * s * c) - m * g * l * theta_dot * c
    across = y_dot * phi_dot * s + nu_y * phi2 * s + nu_y * phi_dot * theta_dot * c
    correct = gliding + m * l * (along + across)
    correct += J1 * (spin + phi_dot**2 * theta_dot * s * c) - m * g * l * theta_dot * s
    return Sides(rate(E), printed, correct)


def rate_by_5_23(E, E_tilde, m, l, v_A, omega, u, omega_a):
    printed = rate(E) - m * dot(v_A, v_A) / 2 - m * l * dot(v_A, cross(omega, u))
    part = E - m * dot(v_A, v_A) / 2 - m * l * dot(v_A, cross(omega, u))
    return Sides(m * dot(rate(v_A), omega_a), printed, rate(part))


def rate_of_modified_energy(
    E_tilde, m, l, theta_dot, phi_dot, nu_x, nu_y, s, c, u, v_A, scalars, b
):
    along = (rate(nu_x) - phi_dot * nu_y) * theta_dot * c
    printed = -m * l * (along + phi_dot * s * (phi_dot * rate(nu_y) + phi_dot * nu_x))
    pushes = dot(u, rate(v_A)), dot(cross(UP, u), rate(v_A))
    return Sides(rate(E_tilde), printed, contact.modified_energy_rate(*pushes, scalars, b))


def normal_force_without_gliding(m, l, g, I1, I3, theta_dot, phi_dot, omega3, s, c, scalars, e, b):
    b = b._replace(friction=Viscous(mp.mpf(0)))
    spin = c * (theta_dot**2 + phi_dot**2 * s**2) - I3 * omega3 * phi_dot * s**2
    printed = (m * g * I1 - m * l * I1 * spin) / (I1 + m * l**2 * s**2)
    return Sides(contact.g_n(scalars, b), printed, contact.g_n(gliding.euler_scalars(e, b), b))


def polynomial(m, l, g, I1, c):
    """C and g_n solve (5.41), C = l g_n cos^3/I1 and g_n cos = (m g I1 cos - m l I1 C)/(I1 + m l^2 sin^2)."""
    C = m * g * l * c**3 / (I1 + m * l**2 * (1 - c**2) + m * l**2 * c**2)
    g_n = I1 * C / (l * c**3)
    truth = (
        (m * g * I1 * c - m * l * I1 * C) / (I1 + m * l**2 * (1 - c**2))
        - g_n * c
        + m * g * l * c**3
    )
    printed = c**2 * (I1 * C + 2 * m * l**2 * C - m * l**2 * C * c**2)
    return Sides(truth, printed, (I1 + m * l**2) * C)


def acceleration_of_the_centre(s_dot, omega_a):
    """Of any motion with v_A = 0: here the tippe top in pure rolling."""
    turn = [x.rate for x in omega_a[:2]]
    return Sides([x.rate for x in s_dot[:2]], turn, [-x for x in turn])


def limit_of_energy(m, l, g, I3, b, omega3):
    """E of the spinning states, where the motion may end; printed: 0."""
    still = {
        "z_dot": 0,
        "z_ddot_free": 0,
        "phi_dot_s2": 0,
        "axis_speed2": 0,
        "v_u": 0,
        "v_n": 0,
        "v2": 0,
        "speed2": 0,
    }
    L3 = I3 * omega3
    ends = [contact.Scalars(z=z, s2=0, L3=L3, Lz=L3 * z, **still) for z in (1, -1)]
    correct = [L3**2 / (2 * I3) + sign * m * g * l for sign in (1, -1)]
    return Sides([contact.energy(end, b) for end in ends], [mp.mpf(0)] * 2, correct)


def upright_gliding_heavy_top():
    b = heavy_top.HeavyTop.body_of(
        {"m": 0.02, "l": 0.04, "I1": 8e-6, "I3": 3.2e-6, "g": 9.82}, Viscous(0.3)
    )
    rows = []
    for factor in (1.1, 3.0, 10.0):
        grows = bool(linear_modes(factor * sleeping_spin(b), b)[0].real > 0)
        case = (
            rf"$L_{{\hat3}}={factor:g}\cdot2\sqrt{{mglI_1^*}}$: small tilts of the upright top grow"
        )
        rows.append(Finding(case, False, True, grows))
    inverted = bool(linear_modes(3 * sleeping_spin(b), b, inverted=True)[0].real > 0)
    return [
        *rows,
        Finding(
            r"at $\theta=\pi$, $3\cdot2\sqrt{mglI_1^*}$: small tilts grow", False, False, inverted
        ),
    ]


def expansion_of_d(d, m, R, alpha, I1, I3, s, c):
    l = -R * alpha
    J1 = I1 + m * l**2
    square = I1 * s**2 + I3 * c**2
    return Sides(
        d,
        J1 / I3 * (1 + 2 * m * l * R * c / J1 + m * R**2 / J1 * square),
        J1 / I3 * (1 + 2 * m * l * R * c / J1 + m * R**2 / (J1 * I3) * square),
    )


def third_term(m, l, I1, I3, J1, g, phi_dot, omega3, s, c):
    """The O(R) term of [R(alpha - z) lambda sqrt(d) D + R^2 (alpha - z)^2 D^2] m/(I1 I3 d) at R = 0: its rate in R."""
    phi_dot, omega3, s, z = (value(x) for x in (phi_dot, omega3, s, c))
    b = contact.Touch(m, Jet(mp.mpf(0), mp.mpf(1)), -l, I1, I3, g, None)
    L3, d = I3 * omega3, tippe_top.d(z, b)
    lam, D, q = b.R * (I1 * phi_dot * s**2 + L3 * z) - b.c * L3, L3 * d.sqrt(), b.c - b.R * z
    term = m / (I1 * I3) * (q * lam * d.sqrt() * D + q**2 * D**2) / d
    lam, L_z = lam.value, J1 * phi_dot * s**2 + L3 * z
    printed = m / (I1 * J1) * (lam**2 * J1 * z / (l * I3) + I1 / I3 * lam * L_z)
    return Sides(term.rate, printed, m * lam / (J1 * I3) * (z * lam / l - L_z))


M, B, S = "misprint", "bracket", "statement"
TOP = "gliding heavy top"

ERRATA = (
    Erratum(
        25, "text before (5.19)", M,
        r"L\cdot\hat z=I_1^*\dot\varphi\sin^2\theta+I_3\omega_3\cos\theta",
        r"L_A\cdot\hat z=I_1^*\dot\varphi\sin^2\theta+I_3\omega_3\cos\theta",
        "the column `Lz` of a heavy top", momentum_about_the_vertical, TOP,
    ),
    Erratum(
        26, "(5.20), again in (5.50)", M,
        r"ml(\nu_x\dot\theta\cos\theta+\nu_y\dot\varphi)",
        r"ml(\nu_x\dot\theta\cos\theta+\nu_y\dot\varphi\sin\theta)",
        "the column `energy`", energy, TOP,
    ),
    Erratum(
        27, "(5.21)", M,
        r"ml(\dots-\dot\nu_y\dot\varphi+\nu_x\ddot\varphi)+I_1^*(\dots+\dot\varphi^2\sin\theta\cos\theta)-mgl\dot\theta"
        r"\cos\theta",
        r"ml(\dots+\dot\nu_y\dot\varphi\sin\theta+\nu_y\ddot\varphi\sin\theta+\nu_y\dot\varphi\dot\theta\cos\theta)+"
        r"I_1^*(\dots+\dot\varphi^2\dot\theta\sin\theta\cos\theta)-mgl\dot\theta\sin\theta",
        "the column `friction_power` ($-\\dot E$)", rate_of_energy, TOP,
        "$\\dot E=v_A\\cdot F$ is right.",
    ),
    Erratum(
        28, "(5.23)", B,
        r"\tfrac{d}{dt}E-\tfrac12mv_A^2-mlv_A\cdot(\omega\times\hat3)=m\dot v_A\cdot(\omega\times a)",
        r"\tfrac{d}{dt}\big(E-\tfrac12mv_A^2-mlv_A\cdot(\omega\times\hat3)\big)=m\dot v_A\cdot(\omega\times a)",
        "the column `modified_energy`", rate_by_5_23, TOP,
    ),
    Erratum(
        29, "(5.24)", M,
        r"\dot{\tilde E}=-ml\big[(\dot\nu_x-\dot\varphi\nu_y)\dot\theta\cos\theta+\dot\varphi\sin\theta(\dot\varphi\dot"
        r"\nu_y+\dot\varphi\nu_x)\big]",
        r"\dot{\tilde E}=-ml\big[(\dot\nu_x-\dot\varphi\nu_y)\dot\theta\cos\theta+\dot\varphi\sin\theta(\dot\nu_y+\dot"
        r"\varphi\nu_x)\big]",
        "the column `modified_energy`", rate_of_modified_energy, TOP,
    ),
    Erratum(
        30, "(5.33)", M,
        r"g_n=\frac{mgI_1-mlI_1\big(\cos\theta(\dot\theta^2+\dot\varphi^2\sin^2\theta)-I_3\omega_3\dot\varphi\sin^2"
        r"\theta\big)}{I_1+ml^2\sin^2\theta}",
        r"g_n=\frac{mgI_1-ml\big[I_1\cos\theta(\dot\theta^2+\dot\varphi^2\sin^2\theta)-I_3\omega_3\dot\varphi\sin^2"
        r"\theta\big]}{I_1+ml^2\sin^2\theta}",
        "the column `normal_force`", normal_force_without_gliding, TOP,
    ),
    Erratum(
        31, "(5.42)", M,
        r"\cos^2\theta\,(I_1C+2ml^2C-ml^2C\cos^2\theta-mgl\cos\theta)=0",
        r"(I_1+ml^2)\,C=mgl\cos^3\theta",
        "this entry", polynomial, TOP,
        "either way $\\cos\\theta$ solves a polynomial equation, so $\\theta$ is constant.",
    ),
    Erratum(
        32, "(5.46)", M,
        r"\ddot r=(\omega\times a)^{\boldsymbol\cdot}_{\hat x,\hat y}=0",
        r"\ddot r=-(\omega\times a)^{\boldsymbol\cdot}_{\hat x,\hat y}=0",
        "the columns `x`, `y`", acceleration_of_the_centre, "rolling tippe top",
        "the constraint says that it vanishes.",
    ),
    Erratum(
        33, "Proposition 5.4.1, its proof, and the text before Lemma 1", M,
        r"E(p)=\lim_{m\to\infty}E(\tilde y(t_m))=0,\qquad E\ge0",
        r"E(p)=\lim_{m\to\infty}E(\tilde y(t_m))=\tfrac{L_{\hat3}^2}{2I_3}\pm mgl,\qquad E\ge-mgl",
        "the column `energy`", limit_of_energy, TOP,
        "the proof uses only that $E$ is constant on the limit set and bounded from below.",
    ),
    Erratum(
        34, "(5.52) to (5.54)", S,
        r"L_{\hat3}^2>4mglI_1^*\ \Rightarrow\ \text{the upright spinning gliding top is asymptotically stable}",
        r"\begin{gathered}(I_1p^2-iL_{\hat3}p-mgl)(p+\mu g)+\mu mgl^2p^2=0\\\text{has a root with}\ \mathrm{Re}\,p>0\ "
        r"\text{for every}\ \mu>0,\ L_{\hat3}\end{gathered}",
        '`tt.theory.linear_modes`, `tippetop check` of a `gliding-heavy-top`', upright_gliding_heavy_top,
    ),
    Erratum(
        35, "(5.72)", M,
        r"\frac{mR^2}{I_1+ml^2}\,(I_1\sin^2\theta+I_3\cos^2\theta)",
        r"\frac{mR^2}{(I_1+ml^2)\,I_3}\,(I_1\sin^2\theta+I_3\cos^2\theta)",
        "the column `routh`", expansion_of_d, "gliding tippe top",
        "the term is of order $R^2$ and leaves the limit alone.",
    ),
    Erratum(
        36, "(A.12)", M,
        r"\frac m{I_1I_1^*}\Big(\lambda^2\frac{I_1^*Rz}{lI_3}+\frac{RI_1}{I_3}\lambda L_{\hat z}\Big)+O(R^2)",
        r"\frac{mR\lambda}{I_1^*I_3}\Big(\frac{z\lambda}l-L_{\hat z}\Big)+O(R^2)",
        "this entry", third_term, TOP,
        "it tends to zero either way.",
    ),
)  # fmt: skip
