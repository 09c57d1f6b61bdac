"""Corrections 1 to 5, of chapter 2: rigid body, Euler angles, heavy symmetric top."""

import mpmath as mp
from errata import Erratum, Sides
from exact import UP, jet

from tippetop.mechanics.contact.body_axes import axes_of_angles
from tippetop.mechanics.operand import Vector, cross, dot, plus, times


def transformation_matrix(theta, phi, omega3):
    """omega3 serves as a random psi; phi of the source is ours + pi/2, psi ours - pi/2."""
    th, ph, ps = (angle.value for angle in (theta, phi + mp.pi / 2, omega3))

    def about(axis, angle):
        """The rotations (2.14) to (2.16)."""
        s, c = mp.sin(angle), mp.cos(angle)
        return mp.matrix(
            [[c, s, 0], [-s, c, 0], [0, 0, 1]]
            if axis == "z"
            else [[1, 0, 0], [0, c, s], [0, -s, c]]
        )

    s, c, sf, cf, sp, cp = mp.sin(th), mp.cos(th), mp.sin(ph), mp.cos(ph), mp.sin(ps), mp.cos(ps)
    printed = [
        [cf * cp - c * sf * sp, -cf * sp - c * sf * cp, s * sf],
        [sf * cp + c * cf * sp, -sf * sp + c * cf * cp, -s * cf],
        [s * sp, s * cp, c],
    ]
    first, third = axes_of_angles(jet(s), jet(c), jet(ph - mp.pi / 2), jet(ps + mp.pi / 2))
    rows = [first, cross(third, first), third]
    return Sides((about("z", ps) * about("x", th) * about("z", ph)).tolist(), printed, rows)


def frame(theta, phi):
    """1hat, 2hat and 3hat."""
    along, nodal = Vector(phi.cos(), phi.sin(), 0), Vector(-phi.sin(), phi.cos(), 0)
    third = plus(times(theta.sin(), along), times(theta.cos(), UP))
    return cross(nodal, third), nodal, third


def inertia_tensor(theta, phi, omega, L, I1, I3):
    first, second, third = frame(theta, phi)
    by_axes = plus(plus(times(I1 * dot(first, omega), first), times(I1 * dot(second, omega), second)),
                   times(I3 * dot(third, omega), third))  # fmt: skip
    printed = plus(times(I1, omega), times((I3 - I1) / I1 * dot(third, omega), third))  # no braces
    return Sides(by_axes, printed, L)


def inertia_tensor_above_3_2(theta, phi, omega, L, I1, I3):
    third = frame(theta, phi)[2]
    printed = times(I1, plus(omega, times((I3 - I1) / I3 * dot(third, omega), third)))
    return Sides(inertia_tensor(theta, phi, omega, L, I1, I3).truth, printed, L)


def torque_of_weight(u, L_A, m, g, l):
    weight = times(-m * g, UP)
    return Sides(
        Vector(*(x.rate for x in L_A)), times(-l, cross(u, weight)), times(l, cross(u, weight))
    )


def which_way_a_points(L, L_A, omega, a, m):
    return Sides(
        L_A,
        plus(L, times(m, cross(times(-1, a), cross(omega, times(-1, a))))),
        plus(L, times(m, cross(a, cross(omega, a)))),
    )


ERRATA = (
    Erratum(
        1,
        "(2.17), section 2.1.1",
        "misprint",
        r"R=\begin{pmatrix}\cos\varphi\cos\psi-\cos\theta\sin\varphi\sin\psi&-\cos\varphi\sin\psi-\cos\theta\sin\varphi"
        r"\cos\psi&\sin\theta\sin\varphi\\ \sin\varphi\cos\psi+\cos\theta\cos\varphi\sin\psi&-\sin\varphi\sin\psi+"
        r"\cos\theta\cos\varphi\cos\psi&-\sin\theta\cos\varphi\\ \sin\theta\sin\psi&\sin\theta\cos\psi&\cos\theta"
        r"\end{pmatrix}",
        r"R_\psi R_\theta R_\varphi\ \text{is the transpose of this matrix; its rows are the axes of the body}",
        "the columns `psi` and `orientation` of a run (`tt.run(..., orientation=True)`)",
        transformation_matrix,
        "gliding tippe top",
    ),
    Erratum(
        2,
        "(2.20), likewise (2.21), (2.23)",
        "bracket",
        r"\mathbf I=I_1\,\mathrm{Id}+\tfrac{I_3-I_1}{I_1}\,\hat3\hat3^t",
        r"\mathbf I=I_1\Big\{\mathrm{Id}+\tfrac{I_3-I_1}{I_1}\,\hat3\hat3^t\Big\}",
        "the column `L` of a run",
        inertia_tensor,
        "gliding tippe top",
    ),
    Erratum(
        3,
        "section 3.1, the inertia tensor above (3.2)",
        "misprint",
        r"\mathbf I=I_1\Big\{\mathrm{Id}+\tfrac{I_3-I_1}{I_3}\,\hat3\hat3^t\Big\}",
        r"\mathbf I=I_1\Big\{\mathrm{Id}+\tfrac{I_3-I_1}{I_1}\,\hat3\hat3^t\Big\},\qquad "
        r"\mathbf I^{-1}=\tfrac1{I_1}\Big\{\mathrm{Id}-\tfrac{I_3-I_1}{I_3}\,\hat3\hat3^t\Big\}",
        "the column `L` of a run",
        inertia_tensor_above_3_2,
        "gliding tippe top",
    ),
    Erratum(
        4,
        "(2.30), (2.31)",
        "misprint",
        r"\dot L_A=-l\,\hat3\times(-mg\hat z)",
        r"\dot L_A=+l\,\hat3\times(-mg\hat z)\qquad\text{as in (2.24)}",
        '`tt.extending.SYSTEMS["heavy-top"].forms["vector"]`',
        torque_of_weight,
        "fixed heavy top",
        "with either sign the torque has no part along $\\hat3$ nor along $\\hat z$, so $L_{\\hat3}$ and $L_{\\hat z}$ "
        "are integrals as stated.",
    ),
    Erratum(
        5,
        "section 2.1, text before (2.8)",
        "misprint",
        r"a\ \text{is the vector from}\ A\ \text{to the centre of mass}",
        r"a\ \text{is the vector from the centre of mass to}\ A\ \text{(everywhere else)}",
        "the columns `Lz` and `L3` of a heavy top",
        which_way_a_points,
        "gliding heavy top",
        "(2.8) and (2.9) are quadratic in $a$.",
    ),
)
