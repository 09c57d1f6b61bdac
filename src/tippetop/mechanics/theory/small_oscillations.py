"""Small oscillations of an ellipsoid that rolls and spins about its half axis c, a vertical.

Symbols
    b         the body in SI units, a `contact.frame.Asymmetric`
    q         a state of the form `framed.ROLLS`; u: axis 3, L: angular momentum
"""

import numpy as np

from ..contact import framed
from ..contact.frame import Asymmetric


STEP = 1e-30


def oscillations(spin: float, up: int, b: Asymmetric) -> tuple[np.ndarray, np.ndarray]:
    """Return the complex rates [1/s] of pitch and roll, (k,), fastest first, and their shapes.

    k is less than two where the body does not oscillate. Shapes (4, k) are those of ux, uy, Lx, Ly,
    seen from the body. `spin` is about the vertical [rad/s]; axis 3, on which the centre of the
    ellipsoid lies, points along `up` = 1 or -1.
    """
    # a state that leans by an infinitesimal part of each variable: complex steps give the matrix
    x, y, Lx, Ly = 1j * STEP * np.eye(4)
    # axis 1 is (1, 0, -up x), perpendicular to axis 3 to first order
    q = framed.ROLLS.units._make((x, y, up, 1.0, 0.0, -up * x, Lx, Ly, b.I3 * spin))
    q_dot = framed.ROLLS.rates(q, b)
    matrix = np.imag([q_dot.ux, q_dot.uy, q_dot.Lx, q_dot.Ly]) / STEP
    turning = spin * np.kron(np.eye(2), [[0, 1], [-1, 0]])  # of the body against space
    rates, shapes = np.linalg.eig(matrix + turning)
    order = np.argsort(-rates.imag)[: np.count_nonzero(rates.imag > 0)]
    return rates[order], shapes[:, order]
