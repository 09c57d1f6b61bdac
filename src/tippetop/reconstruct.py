"""The main equation as an equation of motion: from D(t) and E~(t) of a run back to theta(t). [T 4.40, 5.26]"""

from typing import Any

import numpy as np

from .system import System


TURNING_SPEED = 1e-6  # of the fastest z': below it the quotient that is 0/0 at a turning angle fades out
COMPLEX_STEP = 1e-30


def reconstruct(
    system: System, b: Any, times: np.ndarray, momenta: list[np.ndarray], energy: np.ndarray, z: float, z_dot: float
) -> np.ndarray:
    """z = cos(theta) at `times`, by integrating E~(t) = inertia(z) theta'^2 + V(z, *momenta(t)) from (z, z_dot).

    Only E~ and the momenta (as functions of time, rows in `times`) and the start are read. The first-order equation,
    z'^2 = Q(z, t), has a branch point at every turning angle, so its derivative is integrated, z'' = Q_z/2 + Q_t/(2 z');
    Q_t vanishes with z' there, and the sampled quotient fades out over a relative speed of TURNING_SPEED.
    """
    from scipy.integrate import solve_ivp
    from scipy.interpolate import make_interp_spline

    values = make_interp_spline(times, np.array([energy, *momenta]).T, k=7)
    rates = values.derivative()

    def square(z: Any, given: Any) -> Any:
        """Q(z, t) = z'^2."""
        w = (1 - z) * (1 + z)
        return w * (given[0] - system.potential(z, *given[1:], b)) / system.theta_inertia(z, b)

    def motion(t: float, y: np.ndarray) -> np.ndarray:
        given, change = values(t), rates(t)
        along_z = square(y[0] + 1j * COMPLEX_STEP, given).imag / COMPLEX_STEP
        along_t = square(y[0], given + 1j * COMPLEX_STEP * change).imag / COMPLEX_STEP
        return np.array([y[1], along_z / 2 + along_t * y[1] / (2 * (y[1] ** 2 + floor**2))])

    fastest = np.nanmax(square(np.linspace(-1, 1, 1001)[1:-1], values(times[0])))
    floor = TURNING_SPEED * float(np.sqrt(fastest))
    found = solve_ivp(motion, (times[0], times[-1]), [z, z_dot], "DOP853", times, rtol=1e-11, atol=1e-13)
    return found.y[0]
