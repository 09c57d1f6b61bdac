"""The laws of the planar contact force: F_h = -k(|v_A|) g_n v_A. To add a law: a record, its k, a line in LAWS."""

from typing import Any, NamedTuple

from .operand import Operand, formula, select, sqrt
from .system import METRE_PER_SECOND, ONE, SECOND_PER_METRE, Parameter


class Viscous(NamedTuple):
    """F = -mu g_n v_A, the law of the source [T 3.1]; mu in s/m."""

    mu: Operand


class Coulomb(NamedTuple):
    """F = -mu g_n v_A/sqrt(|v_A|^2 + eps^2); mu without dimension, eps in m/s decides when a top inverts."""

    mu: Operand
    eps: Operand


class Mixed(NamedTuple):
    """The sum of both (Or 1994): viscous mu in s/m, Coulomb mu_coulomb without dimension, eps in m/s."""

    mu: Operand
    mu_coulomb: Operand
    eps: Operand


class Frictionless(NamedTuple):
    """No friction: a vertical reaction alone."""


@formula
def viscous(v2, law):
    """k = mu [s/m]."""
    return law.mu


@formula
def coulomb(v2, law):
    """k = mu/sqrt(v^2 + eps^2) [s/m]."""
    return law.mu / sqrt(v2 + law.eps * law.eps)


@formula
def mixed(v2, law):
    """k = mu + mu_coulomb/sqrt(v^2 + eps^2) [s/m]."""
    return law.mu + law.mu_coulomb / sqrt(v2 + law.eps * law.eps)


@formula
def frictionless(v2, law):
    """k = 0."""
    return 0.0


slip_coefficient = select({Viscous: viscous, Coulomb: coulomb, Mixed: mixed, Frictionless: frictionless})
"""k(v2, law) [s/m], with F_h = -k g_n v_A and v2 = |v_A|^2, for any law."""


class Law(NamedTuple):
    """What a person names in [friction]: the record of the law and the numbers that it takes."""

    record: type
    parameters: dict[str, Parameter]
    long_name: str

    def units(self) -> Any:
        """The law's record filled with units."""
        return self.record(*(p.unit for p in self.parameters.values()))


_VISCOUS = Parameter(SECOND_PER_METRE, "viscous friction coefficient mu", least=0)
_COULOMB = Parameter(ONE, "Coulomb friction coefficient mu", least=0)
_EPS = Parameter(METRE_PER_SECOND, "regularisation speed eps", above=0)

LAWS = {
    "viscous": Law(Viscous, {"mu": _VISCOUS}, "F = -mu g_n v_A"),
    "coulomb": Law(Coulomb, {"mu": _COULOMB, "eps": _EPS}, "F = -mu g_n v_A/sqrt(v_A^2 + eps^2)"),
    "mixed": Law(Mixed, {"mu": _VISCOUS, "mu_coulomb": _COULOMB, "eps": _EPS}, "viscous and Coulomb together"),
    "none": Law(Frictionless, {}, "no friction"),
}
