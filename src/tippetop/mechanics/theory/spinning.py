"""The spinning states theta = 0, pi of a tippe top: marked lines on the minimal surface.

The minimal surface is F(D, lambda) = inf V(z, D, lambda) over z = cos(theta). [T 4.23-4.28]

Symbols
    b         the body, a `contact.body.Touch`; gamma = I1/I3, sigma = m R^2/I3, alpha = c/R
    z         +1 or -1: cos(theta) of the state; in `d` any cos(theta)
    lam       Jellett's integral lambda [kg m^3/s]; D: Routh's function [kg m^2/s]
    E~        energy of the state; X(z): see `tippe_top.X`
"""

from ..contact.body import height, height_energy
from ..operand import formula, sqrt
from ..units import JELLETT, ONE
from .thresholds import Threshold, sense, spin, spins_by_height, two_wells_from


@formula
def d(z, b):
    """Return d(z) = gamma + sigma (alpha - z)^2 + sigma gamma (1 - z^2), without unit.

    It gives D = L_3 sqrt(d). `tippe_top.coefficients` contains d too, by its values at both poles.

    [T 4.7]
    """
    return (
        b.I1 + b.m * ((b.c - b.R * z) ** 2 + b.R**2 * (b.I1 / b.I3) * ((1 - z) * (1 + z)))
    ) / b.I3


@formula
def slope(z, b):
    """Return rho = D/lambda of a spinning state [1/m], by X(z) = 0: the marked line."""
    return sqrt(d(z, b)) / (b.R * z - b.c)


@formula
def momentum(z, lam, b):
    """Return D = rho lambda of a spinning state [kg m^2/s]. [T 4.24, 4.25]"""
    return slope(z, b) * lam


@formula
def energy(z, lam, b):
    """Return E~ of a spinning state [J]: the end value V(z) on the marked line. [T 4.26-4.28]"""
    return height_energy(z, b) + b.I3 * spin(z, lam, b) ** 2 / 2


def lambda_pi(b):
    """Return |lambda| [kg m^3/s] from which on the spin with the centre of mass highest lies on the
    minimal surface: it is stable in pure rolling.
    """
    high = -sense(b)
    h = height(high, b)
    return 2 * h * sqrt(b.m * b.g * abs(b.c) * b.I3 * d(high, b)) / (1 + b.m * b.R * h / b.I3)


def rolling_thresholds(b) -> dict[str, Threshold]:
    """Return lambda_pi and gamma*, thresholds of the minimal surface and of pure rolling.

    Parameters
    ----------
    b
        The body, SI, floats.
    """
    return {
        "lambda_pi": Threshold(
            float(lambda_pi(b)), JELLETT, f"{spins_by_height(b)[1]} spin stable in rolling above"
        ),
        "gamma_star": Threshold(
            two_wells_from(b), ONE, "two wells of the potential are possible above"
        ),
    }
