"""Corrections 19 to 24, of chapter 4: the rolling tippe top, its potential and surface, the main equation."""

import itertools

import mpmath as mp
from errata import Erratum, Finding, Sides
from errata_3 import body_of_ratio
from exact import UP, rate

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.operand import cross, dot
from tippetop.mechanics.systems import tippe_top
from tippetop.mechanics.theory import spinning
from tippetop.mechanics.theory.thresholds import lambda_de, two_wells_from


def surface_is_an_infimum():
    """On the line theta = 0 V falls all the way to z = 1, where it is not defined; its limit is the spinning energy."""
    b, lam = body_of_ratio("0.94"), mp.mpf("2e-6")
    D, end = spinning.momentum(1, lam, b), spinning.energy(1, lam, b)
    slopes = [
        mp.diff(lambda z: tippe_top.potential(z, D, lam, b), mp.mpf(k) / 50) for k in range(-49, 50)
    ]
    near = [tippe_top.potential(1 - mp.mpf(10) ** -k, D, lam, b) - end for k in (5, 10, 20)]
    interior = any(slope >= 0 for slope in slopes)
    return [
        Finding(r"on $D/\lambda=\rho_+$: $V$ has a minimum in $-1<z<1$", True, False, interior),
        Finding(
            r"$V$ exceeds the upright energy at $z=1-10^{-5,-10,-20}$",
            None,
            True,
            all(gap > 0 for gap in near),
        ),
        Finding(
            r"the last of these gaps is below $10^{-20}$ J",
            None,
            True,
            bool(near[-1] < mp.mpf("1e-20")),
        ),
    ]


def curvature(theta, D, lam, b):
    """The second derivative of V by theta."""
    return mp.diff(lambda angle: tippe_top.potential(mp.cos(angle), D, lam, b), mp.mpf(theta), 2)


def minima(D, lam, b, cells=600):
    """How many minima V has in (0, pi): where it falls, and then rises."""
    angles = (mp.pi * k / cells for k in range(1, cells))
    values = [tippe_top.potential(mp.cos(angle), D, lam, b) for angle in angles]
    steps = [second - first for first, second in itertools.pairwise(values)]
    return sum(first < 0 <= second for first, second in itertools.pairwise(steps))


def potential_is_convex():
    b, heavy = (
        body_of_ratio("0.94"),
        body_of_ratio("3")._replace(I3=mp.mpf("2e-6"), I1=mp.mpf("6e-6")),
    )
    zero, lam, small = (
        mp.mpf(0),
        spinning.lambda_pi(heavy) * mp.mpf("1.02"),
        spinning.lambda_pi(b) / 2,
    )
    D, off = (
        spinning.momentum(-1, small, b),
        spinning.momentum(-1, lam, heavy) * (1 + mp.mpf("1e-4")),
    )
    at_rest, on_line = (
        bool(curvature(*at, b) > 0) for at in (("2.5", zero, zero), ("3.1", D, small))
    )
    two = round(two_wells_from(heavy), 2)
    return [
        Finding(r"$V_{\theta\theta}>0$ at $\theta=2.5$, $D=\lambda=0$", True, False, at_rest),
        Finding(
            r"$V_{\theta\theta}>0$ at $\theta=3.1$, $D=\rho_-\lambda$, $\lambda=\lambda_\pi/2$",
            True,
            False,
            on_line,
        ),
        Finding("minima of $V$ there", 1, 1, minima(D, small, b)),
        Finding(
            r"the $\gamma$ from which $V$ can have two minima, $\alpha=0.3$, $\sigma=4$",
            None,
            1.97,
            two,
        ),
        Finding(
            r"$\gamma=3$, $\lambda=1.02\,\lambda_\pi$, $D\approx\rho_-\lambda$: minima",
            1,
            2,
            minima(off, lam, heavy),
        ),
    ]


def line_on_the_surface():
    b = body_of_ratio("0.94")
    limit = spinning.lambda_pi(b)
    rows = []
    for share in ("0.5", "0.9", "1.1"):
        lam = limit * mp.mpf(share)
        D, end = spinning.momentum(-1, lam, b), spinning.energy(-1, lam, b)
        least = min(tippe_top.potential(mp.cos(mp.pi * k / 400), D, lam, b) for k in range(1, 400))
        case = rf"$\lambda={share}\,\lambda_\pi$: the inverted spin lies on the surface"
        rows.append(Finding(case, True, share == "1.1", bool(end < least)))
    rows.append(
        Finding(
            r"$\chi$ of the figure's body, $I_1=\frac{235}{625}mR^2$", None, -0.015, _chi("0.94", b)
        )
    )
    later = _chi(mp.mpf(131) / 140, b)
    return [
        *rows,
        Finding(r"$\chi$ of the later papers' body, $I_1=\frac{131}{350}mR^2$", None, 0.0, later),
    ]


def _chi(gamma, b):
    """(1 - gamma)(1 + sigma) - sigma alpha^2: where it is 0, V is a simple rational function of z."""
    sigma, alpha = b.m * b.R**2 / b.I3, b.c / b.R
    return round(float((1 - mp.mpf(gamma)) * (1 + sigma) - sigma * alpha**2), 12)


def rate_of_phi(phi_dot, lam, D, d, R, alpha, I1, s, c, b):
    root = d.sqrt()
    printed = (lam * root + R * (alpha - c) * D) / (I1 * root * s**2)
    return Sides(phi_dot, printed, tippe_top.X(c, D, lam, b) / (R * I1 * root * s**2))


def rate_of_modified_energy(
    E_tilde, m, R, alpha, theta_dot, phi_dot, omega3, nu_x, nu_y, s, c, u, v_A, scalars, b
):
    across, along = phi_dot * nu_x + rate(nu_y), rate(nu_x) - phi_dot * nu_y
    printed = (
        m
        * R
        * (s * (phi_dot * (alpha - c) + omega3) * across + theta_dot * (1 - alpha * c) * along)
    )
    pushes = dot(u, rate(v_A)), dot(cross(UP, u), rate(v_A))
    return Sides(rate(E_tilde), printed, contact.modified_energy_rate(*pushes, scalars, b))


def energy_threshold(m, g, R, alpha, I3, b):
    """The lambda at which both spinning states have the same energy, from their energies."""
    height = [contact.height_energy(z, b) for z in (1, -1)]
    spin = [spinning.energy(z, mp.mpf(1), b) - h for z, h in zip((1, -1), height, strict=True)]
    equal = mp.sqrt((height[1] - height[0]) / (spin[0] - spin[1]))
    return Sides(equal, mp.sqrt(m * g * R**3 * I3 * (1 - alpha**2)), lambda_de(b))


M, S = "misprint", "statement"
TOP = "gliding tippe top"

ERRATA = (
    Erratum(
        19, "(4.13)", S,
        r"F(D,\lambda)=\min_{z\in(-1,1)}V(z,D,\lambda)",
        r"F(D,\lambda)=\inf_{z\in(-1,1)}V(z,D,\lambda)",
        "`tt.landscapes.minimal_surface` (its `status`), `tippetop surface`", surface_is_an_infimum, "",
        "the surface is the same; on the line $\\theta=0$, and on $\\theta=\\pi$ for $|\\lambda|\\ge\\lambda_\\pi$, "
        "the least value is approached at the pole and is the energy of the spinning state.",
    ),
    Erratum(
        20, "after (4.12), after (4.40)", S,
        r"V(\cos\theta,D,\lambda)\ \text{is convex for}\ \theta\in(0,\pi)",
        r"V\ \text{has one minimum in}\ (0,\pi)\ \text{for}\ 1-\alpha<\gamma<1+\alpha;\ "
        r"\text{it is not convex in general}",
        "`tt.landscapes.potential` (`V`, `V_z`, `V_zz`), `tippetop check` (`gamma_star`)", potential_is_convex, "",
        "what is used of convexity, two turning angles and one band of nutation, needs one minimum only.",
    ),
    Erratum(
        21, "figure 4.1", S,
        r"\text{the line}\ \theta=\pi\ \text{lies on the surface; }I_1=\tfrac{235}{625}mR^2",
        r"\text{it does iff}\ |\lambda|\ge\lambda_\pi=\frac{2R(1+\alpha)\sqrt{mgR\alpha I_3}\sqrt{\gamma+\sigma(1+"
        r"\alpha)^2}}{1+\sigma(1+\alpha)};\quad\text{later papers: }I_1=\tfrac{131}{350}mR^2",
        "`tt.landscapes.marked_lines`, `tippetop surface --figure`", line_on_the_surface,
    ),
    Erratum(
        22, "(4.19)", M,
        r"\dot\varphi=\frac{\lambda\sqrt{d(\cos\theta)}+R(\alpha-\cos\theta)D}{I_1\sqrt{d(\cos\theta)}\,\sin^2\theta}",
        r"\dot\varphi=\frac{\lambda\sqrt{d(\cos\theta)}+R(\alpha-\cos\theta)D}{RI_1\sqrt{d(\cos\theta)}\,\sin^2\theta}"
        r"\qquad\text{as in (4.9)}",
        "the column `phi_dot`", rate_of_phi, TOP,
    ),
    Erratum(
        23, "(4.22)", M,
        r"\dot{\tilde E}=mR\big[\sin\theta(\dot\varphi(\alpha-\cos\theta)+\omega_3)(\dot\varphi\nu_x+\dot\nu_y)+\dot"
        r"\theta(1-\alpha\cos\theta)(\dot\nu_x-\dot\varphi\nu_y)\big]",
        r"\begin{gathered}\dot{\tilde E}=mR\big[\dots-\dot\theta(1-\alpha\cos\theta)(\dot\nu_x-\dot\varphi\nu_y)\big]\\"
        r"\text{as follows from its vector form, which is right}\end{gathered}",
        "the column `modified_energy`", rate_of_modified_energy, TOP,
    ),
    Erratum(
        24, "(4.29) and the text before it", "bracket and misprint",
        r"\lambda_{de}=\sqrt{mgR^3I_3(1-\alpha^2)},\qquad\lambda=L_0(1-\alpha)",
        r"\lambda_{de}=\sqrt{mgR^3I_3}\,(1-\alpha^2),\qquad\lambda=RL_0(1-\alpha)",
        "`tt.theory.thresholds` (`lambda_de`)", energy_threshold, TOP,
    ),
)  # fmt: skip
