"""Rotation matrices as unit quaternions, which have no pole."""

import numpy as np

from ..mechanics.operand import Vector
from ..mechanics.rotation import outer


def quaternion(first: np.ndarray, third: np.ndarray) -> np.ndarray:
    """The unit quaternion that turns body axes into space axes: v_space = q v_body q*.

    Parameters
    ----------
    first, third
        Axes 1 and 3 of the body in the space frame, (3, n).

    Returns
    -------
    ndarray
        (n, 4), components w, x, y, z. Of q and -q, which are one rotation, the one with w >= 0 (w =
        0: the first other component that is not 0 is positive), so that a row does not depend on
        those before it. To interpolate, flip the sign of a row whose scalar product with the row
        before is negative.

    Notes
    -----
    Each row of 4 q q^t is q times a number and linear in the matrix: the row whose number is
    largest is taken, so that no digits are lost. With additions, products and square roots alone,
    the bits are the same wherever a row stands.
    """
    products = outer(Vector(*first), Vector(*third))
    parts, most = list(products[0]), products[0][0]
    for k in range(1, 4):
        number = products[k][k]
        more = number > most
        parts = [
            np.where(more, other, part) for part, other in zip(parts, products[k], strict=True)
        ]
        most = np.where(more, number, most)
    q = np.array(parts)
    q /= np.sqrt((q[0] ** 2 + q[1] ** 2) + (q[2] ** 2 + q[3] ** 2))
    leading = q[0]
    if not leading.all():
        leading = np.take_along_axis(q, np.argmax(q != 0, axis=0)[None], axis=0)[0]
    return np.where(leading < 0, -q, q).T
