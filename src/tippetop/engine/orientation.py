"""Rotations as unit quaternions, which have no pole.

Axes of bodies go in, quaternions (w, x, y, z) come out, for `observables`.
"""

from typing import Any

import numpy as np


def quaternion(products: Any) -> np.ndarray:
    """Return the unit quaternion that turns body axes into space axes: v_space = q v_body q*.

    Parameters
    ----------
    products
        4 q q^t of the axes of the body (`mechanics.rotation.outer`), (4, 4, ...).

    Returns
    -------
    ndarray
        (4, ...), components w, x, y, z. Of q and -q, which are one rotation, the one with w >= 0 (w
        = 0: the first other component that is not 0 is positive), so that a row does not depend on
        those before it. To interpolate, flip the sign of a row whose scalar product with the row
        before is negative.

    Notes
    -----
    Each row of 4 q q^t is q times a number and linear in the matrix: the row whose number is
    largest is taken, so that no digits are lost. With additions, products and square roots alone,
    the bits of a row do not depend on its place.
    """
    rows = np.array(products)
    largest = np.argmax([rows[k, k] for k in range(4)], axis=0)
    q = np.take_along_axis(rows, largest[None, None], axis=0)[0]
    q /= np.sqrt((q[0] ** 2 + q[1] ** 2) + (q[2] ** 2 + q[3] ** 2))
    leading = np.take_along_axis(q, np.argmax(q != 0, axis=0)[None], axis=0)
    return np.where(leading < 0, -q, q)
