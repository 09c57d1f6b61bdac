"""The laws of the planar contact force: F_h = -k g_n v_A. To add a law: a record, its k, an entry in LAWS.

k may depend on the sliding speed and on z = cos(theta), which says where on the body the contact lies.
The fields of a `Law` decide how its contact behaves: no code tests its name or its record.
"""

import re
from collections import namedtuple
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import and_
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, names_its_faults
from .disc_friction import REGIONS, STOPS_ROLLING, Region, inside, rolling, torque
from .operand import Operand, Vector, exp, formula, select, sqrt
from .parameter import rules_faults
from .readonly import freeze
from .system import Parameter
from .units import METRE, METRE_PER_SECOND, ONE, SECOND_PER_METRE


class Viscous(NamedTuple):
    """F = -mu g_n v_A, the law of the thesis [T 3.1]; mu in s/m."""

    mu: Operand


class Coulomb(NamedTuple):
    """F = -mu g_n v_A/sqrt(|v_A|^2 + eps^2); mu without dimension, eps in m/s decides when a top inverts."""

    mu: Operand
    eps: Operand


class SetValued(NamedTuple):
    """Coulomb's law itself: |F| = mu g_n against v_A where the contact slides, |F| <= mu g_n where it does not."""

    mu: Operand


class Contensou(NamedTuple):
    """Coulomb's law at each point of a contact disc under Hertz's pressure, which slides and turns; and rolling
    resistance. mu without dimension; patch, the radius of the disc, and mu_r in m. (Contensou 1963, Zhuravlev 1998)"""

    mu: Operand
    patch: Operand
    mu_r: Operand


class Mixed(NamedTuple):
    """The sum of both (Or 1994): viscous mu in s/m, Coulomb mu_coulomb without dimension, eps in m/s."""

    mu: Operand
    mu_coulomb: Operand
    eps: Operand


class Stribeck(NamedTuple):
    """Coulomb friction that weakens with speed: mu_static at rest falls to mu over the speed v_s (Stribeck 1902)."""

    mu: Operand
    mu_static: Operand
    v_s: Operand
    eps: Operand


class Latitude(NamedTuple):
    """Viscous friction of a body of two materials: mu on the heavy cap (contact at z = 1), mu_stem on the stem's side
    (z = -1), linear in z between; both in s/m."""

    mu: Operand
    mu_stem: Operand


class Frictionless(NamedTuple):
    """No friction: a vertical reaction alone."""


@formula
def viscous(v2, z, law):
    """k = mu [s/m]."""
    return law.mu


@formula
def coulomb(v2, z, law):
    """k = mu/sqrt(v^2 + eps^2) [s/m]."""
    return law.mu / sqrt(v2 + law.eps * law.eps)


@formula
def set_valued(v2, z, law):
    """k = mu/|v| [s/m], of a contact that slides."""
    return law.mu / sqrt(v2)


@formula
def mixed(v2, z, law):
    """k = mu + mu_coulomb/sqrt(v^2 + eps^2) [s/m]."""
    return law.mu + law.mu_coulomb / sqrt(v2 + law.eps * law.eps)


@formula
def stribeck(v2, z, law):
    """k = [mu + (mu_static - mu) exp(-v^2/v_s^2)]/sqrt(v^2 + eps^2) [s/m]."""
    return (law.mu + (law.mu_static - law.mu) * exp(-(v2 / law.v_s**2))) / sqrt(v2 + law.eps * law.eps)


@formula
def latitude(v2, z, law):
    """k = [mu (1 + z) + mu_stem (1 - z)]/2 [s/m]."""
    return (law.mu * (1 + z) + law.mu_stem * (1 - z)) / 2


@formula
def frictionless(v2, z, law):
    """k = 0."""
    return 0.0


@dataclass(frozen=True)
class Law:
    """A friction law F_h = -k g_n v_A: what `[friction] law` names.

    Parameters
    ----------
    record : type
        A NamedTuple whose fields are the numbers of the law.
    parameters : dict of Parameter
        What must hold of each number, by the name of its field.
    long_name : str
        The law in words or as a formula.
    coefficient : callable
        k(v2, z, law) [s/m] under `@formula`: v2 = |v_A|^2 [m^2/s^2], z = cos(theta), law the record. It must be finite,
        at rest too, and not negative. A law that is no multiple of g_n v_A (the modified reaction of a cylinder) has
        none.
    set_valued : bool
        Whether a contact at rest bears any |F_h| <= mu g_n: it slips, rolls, and slips again.
    regions : dict of Region
        The formulas of a law that has several, by the name of the region of w/U in which each holds.
    torque : callable
        torque(drag, omega, law) -> (3,) [m], per normal force, in the region of this drag; it ignores the drag under a
        law without regions.
    without : Law
        The law of the same name where the numbers that this one has more are left out.
    """

    record: type
    parameters: dict[str, Parameter]
    long_name: str
    coefficient: Any = None
    set_valued: bool = False
    regions: Mapping[str, Region] = field(default_factory=dict)
    torque: Callable | None = None
    without: "Law | None" = None

    def __post_init__(self) -> None:
        freeze(self, "parameters", "regions")

    def given(self, names: Collection[str]) -> "Law":
        """Return the law that these numbers belong to: `without`, if no optional one is among them; with parts, if
        numbers of PARTS are."""
        law = self if self.without is None or any(name in names for name in self.optional) else self.without
        return with_parts(law) if any(name in names for name in PARTS if name not in law.parameters) else law

    @property
    def optional(self) -> list[str]:
        """Names of the numbers that may be left out."""
        return [name for name in self.parameters if self.without and name not in self.without.parameters]

    def units(self) -> Any:
        """The law's record filled with units."""
        return self.record(**{name: p.unit for name, p in self.parameters.items()})


PARTS = {
    "mu_r": Parameter(METRE, "rolling resistance of a tippe top: torque per normal force", least=0, default=0.0),
    "mu_d": Parameter(METRE, "drilling torque of a tippe top, per normal force", least=0, default=0.0),
}
"""Numbers that can be added to every law of a system whose contact may open and is a sphere's."""


@formula
def drilling_part(omega, law):
    """The drilling torque about the vertical, per normal force [m]: -mu_d sgn(Omega_z), smooth where Omega_z = 0."""
    return -(law.mu_d * omega.z) / sqrt(omega.z * omega.z + STOPS_ROLLING**2)


@formula
def torque_of_parts(drag, omega, law):
    """The torque of rolling resistance and drilling per normal force, (3,) [m]."""
    resisting = rolling(omega, law)
    return Vector(resisting.x, resisting.y, drilling_part(omega, law))


@formula
def torque_of_disc_and_part(drag, omega, law):
    """The torque of a disc under Coulomb's law, and the drilling torque, per normal force, (3,) [m]."""
    of_disc = torque(drag, omega, law)
    return Vector(of_disc.x, of_disc.y, of_disc.z + drilling_part(omega, law))


_with_parts: dict[type, Law] = {}


def with_parts(law: Law) -> Law:
    """Return a law with rolling resistance and a drilling torque; the same one for a law's record."""
    if law.record not in _with_parts:
        more = {name: rule for name, rule in PARTS.items() if name not in law.parameters}
        name = f"{law.record.__name__}WithParts"
        record: Any = namedtuple(name, (*law.record._fields, *more), module=__name__)  # type: ignore[attr-defined, misc]
        globals()[name] = record  # pickles look for it here
        _with_parts[law.record] = replace(
            law,
            record=record,
            parameters=dict(law.parameters) | more,
            torque=torque_of_disc_and_part if law.regions else torque_of_parts,
            without=None,
        )
    return _with_parts[law.record]


def has_parts(law: Any) -> bool:
    """Return whether rolling resistance or a drilling torque acts under a law with its numbers."""
    return any(np.any(getattr(law, name, 0.0)) for name in PARTS)


def load(omega: Vector, law: Any) -> Vector | None:
    """Return the torque of a law without regions per normal force, (3,) [m]; None under a law without parts."""
    return torque_of_parts(None, omega, law) if "mu_d" in law._fields else None


_VISCOUS = Parameter(SECOND_PER_METRE, "viscous friction coefficient mu", least=0)
_COULOMB = Parameter(ONE, "Coulomb friction coefficient mu", least=0)
_EPS = Parameter(METRE_PER_SECOND, "regularisation speed eps", above=0)

_EXACT = Law(
    SetValued,
    {"mu": _COULOMB},
    "F = -mu g_n v_A/|v_A|; |F| <= mu g_n where v_A = 0",
    set_valued,
    set_valued=True,
)
LAWS = {
    "viscous": Law(Viscous, {"mu": _VISCOUS}, "F = -mu g_n v_A", viscous),
    "coulomb": Law(
        Coulomb,
        {"mu": _COULOMB, "eps": _EPS},
        "F = -mu g_n v_A/sqrt(v_A^2 + eps^2)",
        coulomb,
        without=_EXACT,
    ),
    "mixed": Law(
        Mixed,
        {"mu": _VISCOUS, "mu_coulomb": _COULOMB, "eps": _EPS},
        "viscous and Coulomb together",
        mixed,
    ),
    "stribeck": Law(
        Stribeck,
        {
            "mu": _COULOMB,
            "mu_static": Parameter(ONE, "Coulomb friction coefficient at rest", least=0),
            "v_s": Parameter(METRE_PER_SECOND, "Stribeck speed, over which mu_static falls to mu", above=0),
            "eps": _EPS,
        },
        "Coulomb that weakens with speed: mu + (mu_static - mu) exp(-v_A^2/v_s^2)",
        stribeck,
    ),
    "latitude": Law(
        Latitude,
        {
            "mu": _VISCOUS,
            "mu_stem": Parameter(SECOND_PER_METRE, "viscous friction coefficient on the side of the stem", least=0),
        },
        "viscous, linear in cos(theta) between mu on the heavy cap and mu_stem on the stem's side",
        latitude,
    ),
    "none": Law(Frictionless, {}, "no friction", frictionless),
    "contensou": Law(
        Contensou,
        {
            "mu": _COULOMB,
            "patch": Parameter(METRE, "radius of the contact disc, 1e-5 to 1 times that of the sphere", above=0),
            "mu_r": Parameter(
                METRE,
                "rolling resistance: torque per normal force",
                least=0,
                default=0.0,
            ),
        },
        "Coulomb's law at each point of a disc that slides and turns (Contensou, Zhuravlev), Hertz pressure",
        regions=REGIONS,
        torque=torque,
    ),
}
"""The laws by name. The contact of a body has phases under a law that is set-valued or has regions; both have mu."""


def all_laws(laws: Mapping[str, Law]) -> Iterator[tuple[str, Law]]:
    """Yield every law with its name, also those of the same name with fewer numbers, or with parts."""
    for name, law in laws.items():
        for one in (law, law.without):
            if one is not None:
                yield name, one
                yield name, with_parts(one)


def named(record: type, laws: Mapping[str, Law] = LAWS) -> tuple[str, Law] | None:
    """Return name and law of a record, of `laws` or else of LAWS; None if there is none."""
    known = (pair for pair in (*all_laws(laws), *all_laws(LAWS)) if pair[1].record is record)
    return next(known, None)


SLIP: dict[type, Any] = {}
SLIP |= {law.record: law.coefficient for _, law in all_laws(LAWS) if law.coefficient is not None}
slip_coefficient = select(SLIP)
"""k(v2, z, law) [s/m], with F_h = -k g_n v_A and v2 = |v_A|^2, for any law that is registered."""


SPEEDS2, HEIGHTS = (
    (0.0, 1e-6, 1.0),
    (1.0, 0.0, -1.0),
)  # |v_A|^2 [m^2/s^2] and z at which a law is asked


def is_frictionless(law: Any) -> bool:
    """Whether a law with its numbers takes no energy: k = 0 at rest and in motion, wherever the contact lies.

    So are the law `none`, and every law with mu = 0.
    """
    return bool(takes_nothing(law))


def takes_nothing(law: Any) -> Any:
    """As `is_frictionless`, of numbers (n,): which of them."""
    known = named(type(law))
    if known is None:  # a law of one system, which is no multiple of the sliding velocity
        return False
    rules = known[1]
    if rules.set_valued or rules.regions:
        none = law.mu == 0
    else:
        none = reduce(and_, (slip_coefficient(v2, z, law) == 0 for v2 in SPEEDS2 for z in HEIGHTS))
    if rules.torque is not None:
        turns = rules.torque(inside(0.0, 1.0), Vector(1.0, 0.0, 1.0), law)
        none = none & (turns.x == 0) & (turns.z == 0)
    return none


FAST2 = np.float64(1e6)  # |v_A|^2 [m^2/s^2] beyond that of any top


def nowhere_vanishes(law: Any) -> bool:
    """Return whether a law k g_n v_A acts wherever on the body the contact lies, at rest and in fast sliding."""
    with np.errstate(all="ignore"):
        return all(slip_coefficient(v2, z, law) > 0 for v2 in (np.float64(0), FAST2) for z in HEIGHTS)


def is_linear(law: Any) -> bool:
    """Return whether k depends neither on the sliding speed nor on the place of the contact."""
    return len({float(slip_coefficient(v2, z, law)) for v2 in (np.float64(0), FAST2) for z in HEIGHTS}) == 1


def add(name: str, law: Law) -> None:
    """Registers a law under the name that [friction] law = "..." takes: from here on every gliding system has it.

    The same law under the same name again changes nothing. Raises InputError."""
    if name in LAWS and LAWS[name] is law:
        return
    if faults := _faults(name, law):
        raise InputError(faults)
    LAWS[name] = law
    SLIP[law.record] = SLIP[with_parts(law).record] = names_its_faults(law.coefficient, f"the friction law `{name}`")


NAME = r"[A-Za-z_][A-Za-z0-9_-]*"
"""What the name of a law or a system is made of: it stands in TOML, on the command line and in stores."""


def _faults(name: Any, law: Any) -> list[str]:
    """What is wrong with a law that is to be registered, in sentences."""
    if not isinstance(name, str) or not re.fullmatch(NAME, name):
        return [f"the name of a law must be letters, digits, - and _, and begin with no digit, but is {name!r:.60}."]
    fields = getattr(law.record, "_fields", None)
    if not isinstance(law.record, type) or fields is None:
        return [f"the record of the law `{name}` must be a NamedTuple, but is {law.record!r:.60}."]
    if not isinstance(law.parameters, Mapping):
        return rules_faults(f"the parameters of the law `{name}`", law.parameters)
    faults = []
    if name in LAWS:
        faults.append(f"the name of a law must be new, but `{name}` is that of {LAWS[name].record.__name__}.")
    if law.coefficient is None:
        faults.append(f"the law `{name}` must have a coefficient k(v2, z, law), but has none.")
    more = [word for word in ("set_valued", "regions", "torque", "without") if getattr(law, word)]
    must = "must be left out: it is for the laws of this package"
    faults += [f"`{word}` of the law `{name}` {must}." for word in more]
    if set(fields) != set(law.parameters):
        names, given = ", ".join(fields) or "none", ", ".join(law.parameters) or "none"
        faults.append(f"the parameters of the law `{name}` must be the fields of its record, {names}, but are {given}.")
    if "law" in law.parameters:
        faults.append(f"a parameter of the law `{name}` must not be named `law`: that is the key of the law's name.")
    faults += [
        f"a parameter of the law `{name}` must not be named `{part}`: every law takes it, as {rule.long_name}."
        for part, rule in PARTS.items()
        if part in law.parameters
    ]
    if not faults:
        faults += rules_faults(f"the parameters of the law `{name}`", law.parameters)
    if not callable(law.coefficient or len):
        faults.append(f"the coefficient of the law `{name}` must be a function, but is {law.coefficient!r:.60}.")
    if not isinstance(law.long_name, str):
        faults.append(f"the long_name of the law `{name}` must be a text, but is {law.long_name!r:.60}.")
    others = [other for other, known in LAWS.items() if known.record is law.record and other != name]
    if others:
        faults.append(
            f"the record of the law `{name}` must be its own, but {law.record.__name__} is that of `{others[0]}`."
        )
    return faults
