"""Coefficients of the effective potential of a top.

They belong to a variable that keeps its digits at both poles.

The systems say what these numbers are for their bodies; `landscape.formulas` evaluates V from them.
"""

from typing import Any, NamedTuple

from .doubledouble import DoubleDouble, doubledouble
from .operand import Operand


class PotentialCoefficients(NamedTuple):
    """The numbers of one body; first and second momentum are (D, lambda), or (L3, Lz).

    `Landscape.coefficients` of a system makes them, and fulfils the law of `Landscape`. q, X, psi
    and d are those of `landscape.formulas`.
    """

    height_energy: DoubleDouble  # energy of weight at q = 0 [J]
    height_gain: DoubleDouble  # its gain up to q = oo [J]
    gamma: DoubleDouble  # V but for weight is a sum of squares over gamma: I1/I3, or 1
    root_gamma_gain: Operand  # sqrt(gamma height_gain) [sqrt(J)]
    sqrt_d0: DoubleDouble  # sqrt(d) at q = 0
    sqrt_d1: DoubleDouble  # sqrt(d) at q = oo
    K: DoubleDouble  # d = (1 - z^2)(h^2 + K) with h = (sqrt_d0 + sqrt_d1 q)/(2 sqrt(q))
    a1: DoubleDouble  # a = a1 first + a2 second [sqrt(J)]
    a2: DoubleDouble
    b1: DoubleDouble  # b likewise
    b2: DoubleDouble
    k: DoubleDouble  # k second, times psi, is what X has besides a and b [sqrt(J)]
    # (spin1 first)^2 - (spin2 second)^2 is gamma times what V has besides weight and X^2 [J]
    spin1: DoubleDouble
    spin2: DoubleDouble
    spin22_by_k: DoubleDouble  # spin2^2/k, 0 where spin2 is


def rounded(c: PotentialCoefficients) -> PotentialCoefficients:
    """Round coefficients of decimals to doubles or double-doubles, by the annotation of a field."""
    of = PotentialCoefficients.__annotations__
    parts: Any = (
        doubledouble(x) if of[name] is DoubleDouble else float(x) for name, x in c._asdict().items()
    )
    return PotentialCoefficients(*parts)
