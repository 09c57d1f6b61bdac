"""Numbers that separate the regimes of a top: lambda_u, lambda_s, gamma_c and others.

A body goes in, numbers come out; `thresholds` returns all of them with unit and meaning, for
`systems.outlook`. Published theory has alpha > 0. A peg, alpha < 0, is the body with its axis
turned round: alpha, theta, omega_3, D become -alpha, pi - theta, -omega_3, -D, while lambda, phi'
and all energies stay. `shape`, `sense` and `spins_by_height` make that change for all of theory.

Symbols
    b         the body in SI units, a `contact.body.Touch` of floats, or of arrays
    lambda    Jellett's integral [kg m^3/s]; E~: energy
    alpha, gamma, sigma, beta   see `Shape`; alpha = c/R without sign there
    spins     states with a vertical axis: upright (theta = 0) and inverted (theta = pi); the lowest
              and the highest one by the height of the centre of mass
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..contact.body import Touch, tip_inertia
from ..operand import formula, sqrt
from ..units import JELLETT, ONE, RADIAN_PER_SECOND, Unit


class Threshold(NamedTuple):
    """A number that separates regimes: value (SI), unit, and meaning."""

    value: float
    unit: Unit
    long_name: str


class Shape(NamedTuple):
    """|alpha|, gamma = I1/I3, sigma = m R^2/I3, beta = sqrt(m g R^3 |alpha| I3) of a tippe top."""

    alpha: Any
    gamma: Any
    sigma: Any
    beta: Any


def shape(b: Touch) -> Shape:
    """Return the numbers on which thresholds depend, a `Shape`; beta in kg m^3/s.

    They do not depend on the sign of alpha: where it counts, `sense` has it.
    """
    alpha = np.abs(b.c) / b.R
    return Shape(
        alpha, b.I1 / b.I3, b.m * b.R**2 / b.I3, np.sqrt(b.m * b.g * b.R**3 * alpha * b.I3)
    )


SPINS = {"upright": 1, "inverted": -1}
"""cos(theta) of the spinning states: they are named after the axis, of a peg too."""


def sense(b: Touch) -> Any:
    """Return cos(theta) of the pole where the centre of mass is lowest: 1, or -1 of a peg."""
    return np.where(b.c < 0, -1, 1)


def spins_by_height(b: Touch) -> tuple[str, str]:
    """Return the names of the spins with the centre of mass lowest and highest, keys of SPINS.

    Of a peg they are exchanged. Many bodies are pegs if most are: the points of a map over alpha
    reach beyond its numbers, which have one sign, by half a cell.
    """
    low, high = SPINS
    return (high, low) if np.mean(b.c < 0) > 0.5 else (low, high)


# --- spinning states ----------------------------------------------------------------------------


def lambda_u(b: Touch) -> Any:
    """Return |lambda| [kg m^3/s] below which the spin with the centre of mass lowest is stable.

    It is infinite if the spin is always stable.

    [T Theorem 3.3.2]
    """
    alpha, gamma, _, beta = shape(b)
    return _over_root(beta * (1 - alpha) ** 2, alpha + gamma - 1)


def lambda_s(b: Touch) -> Any:
    """Return |lambda| [kg m^3/s] above which the spin with the centre of mass highest is stable.

    It is infinite if the spin is never stable.

    [T 4.30]
    """
    alpha, gamma, _, beta = shape(b)
    return _over_root(beta * (1 + alpha) ** 2, 1 + alpha - gamma)


def _over_root(number: Any, x: Any) -> Any:
    """Return number/sqrt(x), infinite where x is not positive."""
    with np.errstate(divide="ignore"):
        return number / np.sqrt(np.maximum(x, 0.0))


def lambda_de(b: Touch) -> Any:
    """Return |lambda| [kg m^3/s] above which the spin with the centre of mass highest has less E~
    than the one with it lowest. [T 4.29]
    """
    alpha = b.c / b.R
    return np.sqrt(b.m * b.g * b.R**3 * b.I3) * (1 - alpha**2)


def gamma_c(alpha: float) -> float:
    """Return gamma_c(|alpha|): lambda_s > lambda_u if and only if gamma > gamma_c."""
    return (1 - alpha**2) * (1 + 3 * alpha**2) / (1 + 6 * alpha**2 + alpha**4)


def gamma_plus(alpha: float) -> float:
    """Return gamma_plus(|alpha|): all tumbling states are stable iff gamma >= gamma_plus."""
    return (1 - alpha) * (7 + alpha + sqrt(1 + 14 * alpha + alpha**2)) / 8


def gamma_de(alpha: Any) -> Any:
    """Return gamma_de(|alpha|): lambda_s > lambda_de if and only if gamma > gamma_de. [T 4.31-4.34]

    It is below 1 - alpha for alpha > 3 - sqrt(8).
    """
    return (1 + alpha) * (1 - 3 * alpha) / (1 - alpha) ** 2


def two_wells_from(b: Touch) -> float:
    """Return gamma*, above which the potential can have two minima; infinite where it never can.

    The landscape scans for the lower one from there on (`Landscape.two_wells`).
    """
    alpha, _, sigma, _ = shape(b)
    h = 1 + alpha
    below = 2 * sigma * h * (1 + sigma) - 1 - sigma * h
    above = sigma * h * (h * (1 + sigma * h) + 2 * (1 + sigma - sigma * alpha**2))
    return float(above / below) if below > 0 else math.inf


@formula
def spin(z, lam, b):
    """Return omega_3 of the spinning state z = +1 or -1 with Jellett's integral lambda [rad/s].

    [T 4.23]
    """
    return lam / (b.I3 * (b.R * z - b.c))


def spin_of(lam: float, b: Touch, *, inverted: bool = False) -> float:
    """Return omega_3 of the upright (or inverted) spin with Jellett's integral lam [rad/s]."""
    return spin(-1 if inverted else 1, lam, b)


def thresholds(b: Touch, states: tuple[str, str] | None = None) -> dict[str, Threshold]:
    """Return every threshold of a tippe top: name -> value (SI), unit and meaning.

    Parameters
    ----------
    b
        The body, SI, floats; its friction law plays no part.
    states
        As `spins_by_height` returns them; must be given where the numbers of the body are symbols,
        which cannot be compared.

    Notes
    -----
    The names are those that `check`, `tippetop.theory.thresholds` and the playground show.
    """
    low, high = states or spins_by_height(b)
    alpha, gamma, *_ = shape(b)

    def spin_at(state: str, lam: Any) -> Any:
        """Return |omega_3| [rad/s] of the spinning state, a key of SPINS, that has this lambda."""
        return np.abs(spin(SPINS[state], lam, b))

    return {
        "lambda_u": Threshold(lambda_u(b), JELLETT, f"{low} spin stable below"),
        "lambda_s": Threshold(lambda_s(b), JELLETT, f"{high} spin stable above"),
        "lambda_de": Threshold(
            lambda_de(b), JELLETT, f"{high} spin has less energy than {low} spin above"
        ),
        f"spin_{low}": Threshold(
            spin_at(low, lambda_u(b)), RADIAN_PER_SECOND, f"{low} spin stable below"
        ),
        f"spin_{high}": Threshold(
            spin_at(high, lambda_s(b)), RADIAN_PER_SECOND, f"{high} spin stable above"
        ),
        "spin_full": Threshold(
            spin_at(low, lambda_s(b)),
            RADIAN_PER_SECOND,
            f"initial {low} spin from which the {high} one is stable",
        ),
        "gamma": Threshold(gamma, ONE, "I1/I3"),
        "gamma_c": Threshold(gamma_c(alpha), ONE, "lambda_s > lambda_u above"),
        "gamma_plus": Threshold(gamma_plus(alpha), ONE, "every tumbling state stable from here on"),
    }


def sleeping_spin(b: Touch) -> float:
    """Return |omega_3| above which the upright heavy top with a fixed tip is stable [rad/s].

    It is 2 sqrt(m g l I1*)/I3, with l = -c. [T 5.54]
    """
    return 2 * math.sqrt(b.m * b.g * -b.c * tip_inertia(b)) / b.I3


def thresholds_of_sleeping(b: Touch) -> dict[str, Threshold]:
    """Return the threshold of an upright heavy top with a fixed tip."""
    words = "upright spin of a fixed tip stable above"
    return {"spin_sleeping": Threshold(sleeping_spin(b), RADIAN_PER_SECOND, words)}
