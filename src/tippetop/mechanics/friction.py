"""The laws of the planar contact force: F_h = -k g_n v_A.

A law is a class (`FrictionLaw`); an instance is the record of its numbers, the `law` of formulas.
To add a law: a class, and its name in LAWS. k may depend on the sliding speed and on z, which
determines the place of the contact on the body. The attributes of a law decide how its contact
behaves: no code tests its name or its class.

Symbols
    F_h, g_n  horizontal force of the plane, normal force; k >= 0: coefficient [s/m]
    v_A, v2   velocity of the contact point, |v_A|^2; z: cos(theta) of the axis
    omega     angular velocity, (3,), Omega_z its vertical part
    drag      of a disc: a `disc_friction.Drag`; parts: rolling resistance mu_r, drilling mu_d
"""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import reduce
from operator import and_
from typing import Any, ClassVar

import numpy as np

from ..errors import InputError, names_its_faults
from .disc_friction import REGIONS, STOPS_ROLLING, Region, inside, rolling, torque
from .number import Number, Record, RecordType, number, reuse
from .operand import Vector, exp, formula, select, sqrt, times
from .units import METRE, METRE_PER_SECOND, ONE, SECOND_PER_METRE


__all__ = ["Contensou", "Coulomb", "Frictionless", "Latitude", "Mixed", "Stribeck", "Viscous"]


ROLLING = number(
    METRE,
    "rolling resistance of a tippe top: torque per normal force",
    symbol=r"\mu_r",
    least=0,
    default=0.0,
    optional=True,
)
DRILLING = reuse(
    ROLLING, long_name="drilling torque of a tippe top, per normal force", symbol=r"\mu_d"
)
PARTS = {"mu_r": ROLLING, "mu_d": DRILLING}
"""Numbers that can be added to every law of a system whose contact may open and is a sphere's."""


EPS = number(METRE_PER_SECOND, "regularisation speed eps", symbol=r"\varepsilon", above=0)


@formula
def drilling_part(omega, law):
    """Return the drilling torque about the vertical, per normal force [m].

    It is -mu_d sgn(Omega_z), smooth where Omega_z = 0, as `disc_friction.rolling` is.
    """
    return -(law.mu_d * omega.z) / sqrt(omega.z * omega.z + STOPS_ROLLING**2)


def torque_of_parts(drag, omega, law):
    """Return the torque of rolling resistance and drilling per normal force, (3,) [m].

    It is `FrictionLaw.torque` of `with_parts` of a law without regions; it ignores the drag.
    """
    return rolling(omega, law)._replace(z=drilling_part(omega, law))


def torque_of_disc_and_part(drag, omega, law):
    """Return the torque of a disc and the drilling torque, per normal force, (3,) [m]."""
    of_disc = torque(drag, omega, law)
    return of_disc._replace(z=of_disc.z + drilling_part(omega, law))


def has_parts(law: Any) -> bool:
    """Return whether rolling resistance or a drilling torque acts under a law with its numbers."""
    return any(np.any(getattr(law, name, 0.0)) for name in PARTS)


def load(omega: Vector, law: Any) -> Vector:
    """Return the torque of rolling resistance and drilling per normal force, (3,) [m].

    It is that of a law without regions; zero if the law has no such parts.
    """
    return torque_of_parts(None, omega, law) if "mu_d" in law._fields else times(0, omega)


class FrictionLaw(Record, abstract=True):
    """A friction law F_h = -k g_n v_A, named by `[friction] law`.

    An instance contains the numbers of the law and is an argument of its formulas.

    A user-defined law has two class attributes: `key`, its name in `[friction] law`, and the
    formula `coefficient`, k(v2, z, law) [s/m] with v2 = |v_A|^2 and z = cos(theta), which is finite
    and not negative.
    The others are for laws of the package. docs/how-to/a-friction-law.md shows one.
    """

    table = "friction"
    long_name: ClassVar[str]
    """The law as a formula or in words: the first line of its docstring."""
    key: ClassVar[str]
    """The name in `[friction] law`; by default that of the class in lower case."""
    words: ClassVar[str]
    """Name in figures; by default the key, and "friction"."""
    coefficient: ClassVar[Any] = None
    """k(v2, z, law) [s/m] under `@formula`: v2 = |v_A|^2 [m^2/s^2], z = cos(theta), law the record.

    It must be finite, at rest too, and not negative. A law that is no multiple of g_n v_A (the
    modified reaction) has none.
    """
    bounded_by: ClassVar[tuple[str, ...]] = ()
    """Numbers of which the greatest bounds |F_h|/g_n; empty: no bound is known."""
    set_valued: ClassVar[bool] = False
    """Whether a contact at rest can sustain any |F_h| <= mu g_n, so that it can stick."""
    regions: ClassVar[Mapping[str, Region]] = {}
    """The formulas of a law that has several, by the name of the region of w/U where each is valid.
    """
    torque: ClassVar[Callable | None] = None
    """torque(drag, omega, law) -> (3,) [m], per normal force, in the region of this drag; it
    ignores the drag under a law without regions.
    """
    without: ClassVar[Any] = None
    """The law where the optional numbers are left out."""
    with_parts: ClassVar[Any] = None
    """The law with rolling resistance and a drilling torque; None if it already has them."""

    mu_r: Number = reuse(ROLLING, default=None, kw_only=True)
    mu_d: Number = reuse(DRILLING, default=None, kw_only=True)

    def __init_subclass__(cls) -> None:
        """Derive a law's names, and `with_parts`, the class of its records with mu_r or mu_d.

        That class is made here too, so it has `with_parts` = None, and the face and the key of the
        law. The numbers of PARTS come last in its records.
        """
        super().__init_subclass__()
        body = vars(cls)
        doc = (cls.__doc__ or "").partition("\n\nParameters\n")[0]
        cls.long_name = doc.partition("\n")[0].removesuffix(".")
        if cls.face is cls:
            cls.key = body.get("key", cls.__name__.lower())
            cls.words = body.get("words", f"{cls.key} friction")
        if callable(k := body.get("coefficient")):
            cls.coefficient = staticmethod(names_its_faults(k, f"the friction law `{cls.key}`"))
        if "with_parts" not in body:
            torque = torque_of_disc_and_part if cls.regions else torque_of_parts
            other = {
                **cls.parameters,
                **{name: rule for name, rule in PARTS.items() if name not in cls.parameters},
                "torque": staticmethod(torque),
                "with_parts": None,
                "without": None,
                "__doc__": doc,
                "__module__": cls.__module__,
                "__qualname__": f"{cls.__qualname__}.with_parts",
            }
            cls.with_parts = RecordType(cls.__name__, (cls,), other)

    @classmethod
    def given(cls, names: Collection[str]) -> Any:
        """Return the law that these numbers belong to.

        `without`, if no optional one is among them; `with_parts`, if numbers of PARTS are.
        """
        law: Any = cls
        optional = {name for name, rule in cls.parameters.items() if rule.optional}
        if cls.without is not None and optional.isdisjoint(names):
            law = cls.without
        parts = PARTS.keys() - law.parameters.keys()
        return law if parts.isdisjoint(names) else law.with_parts

    @classmethod
    def units(cls) -> Any:
        """Return its record filled with units."""
        return cls._make(rule.unit for rule in cls.parameters.values())


class Viscous(FrictionLaw):
    """F = -mu g_n v_A.

    Viscous friction: the law of Rutstam's thesis (2010), eq. 3.1.
    """

    mu: Number = number(SECOND_PER_METRE, "viscous friction coefficient mu", symbol=r"\mu", least=0)

    @formula
    def coefficient(v2, z, law):
        """Return k = mu [s/m]."""
        return law.mu


class Coulomb(FrictionLaw):
    """F = -mu g_n v_A/sqrt(v_A^2 + eps^2).

    Dry friction (Coulomb 1785). The regularisation speed eps decides when a top inverts. Without it
    this is Coulomb's law itself: the contact slips, rolls and flies, and the tables `phases` and
    `impacts` list when.
    """

    words = "regularised Coulomb friction"
    bounded_by = ("mu",)
    mu: Number = number(ONE, "Coulomb friction coefficient mu", symbol=r"\mu", least=0)
    eps: Number = reuse(EPS, default=None, optional=True)

    @formula
    def coefficient(v2, z, law):
        """Return k = mu/sqrt(v^2 + eps^2) [s/m]."""
        return law.mu / sqrt(v2 + law.eps * law.eps)


class SetValued(Coulomb):
    """F = -mu g_n v_A/|v_A|; |F| <= mu g_n where v_A = 0.

    Coulomb's law itself: |F| = mu g_n against v_A where the contact slides, |F| <= mu g_n where it
    does not.
    """

    words = "Coulomb friction"
    mu: Number = reuse(Coulomb.parameters["mu"])
    set_valued = True
    without = None

    @formula
    def coefficient(v2, z, law):
        """Return k = mu/|v| [s/m], of a contact that slides."""
        return law.mu / sqrt(v2)


Coulomb.without = SetValued


class Contensou(FrictionLaw):
    """Coulomb's law at each point of a disc that slides and turns (Contensou, Zhuravlev, Hertz).

    Drilling friction and rolling resistance of a tippe top (Contensou 1963, Zhuravlev 1998).
    The contact slips and flies, and the tables `phases` and `impacts` list when.
    """

    words = "Coulomb–Contensou friction"
    bounded_by = ("mu",)
    regions = REGIONS
    torque = staticmethod(torque)
    mu: Number = reuse(Coulomb.parameters["mu"])
    patch: Number = number(
        METRE,
        "radius of the contact disc, 1e-5 to 1 times that of the sphere",
        symbol="contact radius",
        above=0,
    )
    mu_r: Number = reuse(ROLLING, optional=False, kw_only=True)


class Mixed(FrictionLaw):
    """Viscous and Coulomb together.

    F = -[mu + mu_coulomb/sqrt(|v_A|^2 + eps^2)] g_n v_A. Or, A. C.: The dynamics of a tippe top.
    SIAM J. Appl. Math. 54 (1994).
    """

    words = "viscous and Coulomb friction"
    mu: Number = reuse(Viscous.parameters["mu"])
    mu_coulomb: Number = reuse(Coulomb.parameters["mu"], symbol=r"\mu_C")
    eps: Number = reuse(EPS)

    @formula
    def coefficient(v2, z, law):
        """Return k = mu + mu_coulomb/sqrt(v^2 + eps^2) [s/m]."""
        return law.mu + law.mu_coulomb / sqrt(v2 + law.eps * law.eps)


class Stribeck(FrictionLaw):
    """Coulomb that weakens with speed: mu + (mu_static - mu) exp(-v_A^2/v_s^2).

    Dry friction: mu_static at rest falls to mu over the speed v_s (Stribeck 1902).
    """

    words = "Stribeck friction"
    bounded_by = ("mu", "mu_static")
    mu: Number = reuse(Coulomb.parameters["mu"])
    mu_static: Number = number(
        ONE, "Coulomb friction coefficient at rest", symbol=r"\mu_s", least=0
    )
    v_s: Number = number(
        METRE_PER_SECOND, "Stribeck speed, over which mu_static falls to mu", symbol="v_s", above=0
    )
    eps: Number = reuse(EPS)

    @formula
    def coefficient(v2, z, law):
        """Return k = [mu + (mu_static - mu) exp(-v^2/v_s^2)]/sqrt(v^2 + eps^2) [s/m]."""
        return (law.mu + (law.mu_static - law.mu) * exp(-(v2 / law.v_s**2))) / sqrt(
            v2 + law.eps * law.eps
        )


class Latitude(FrictionLaw):
    """Viscous, linear in cos(theta) between mu on the heavy cap and mu_stem on the stem's side.

    Friction of a body of two materials: mu where the contact is at z = 1, mu_stem where it is at z
    = -1.
    """

    mu: Number = reuse(Viscous.parameters["mu"])
    mu_stem: Number = number(
        SECOND_PER_METRE,
        "viscous friction coefficient on the side of the stem",
        symbol=r"\mu_{stem}",
        least=0,
    )

    @formula
    def coefficient(v2, z, law):
        """Return k = [mu (1 + z) + mu_stem (1 - z)]/2 [s/m]."""
        return (law.mu * (1 + z) + law.mu_stem * (1 - z)) / 2


class Frictionless(FrictionLaw):
    """No friction.

    The plane pushes vertically only. Not to be confused with pure rolling, where the contact point
    is at rest: that is another system.
    """

    key = "none"
    words = "no friction"

    @formula
    def coefficient(v2, z, law):
        """Return k = 0, of the type of v2, as a float times numbers in quad precision fails."""
        return 0 * v2


LAWS: dict[str, type[FrictionLaw]] = {
    law.key: law for law in (Viscous, Coulomb, Mixed, Stribeck, Latitude, Frictionless, Contensou)
}
"""The laws by name.

The contact of a body has phases under a law that is set-valued or has regions; both have mu.
"""


def all_laws(laws: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield every law with its name: each in `laws`, and those derived from it.

    These are `without`, the law where optional numbers are left out, and `with_parts`, the law with
    mu_r and mu_d.
    """
    for name, law in laws.items():
        for one in (law, law.without):
            if one is not None:
                yield name, one
                if one.with_parts is not None:
                    yield name, one.with_parts


def is_known(law: type[FrictionLaw], laws: Mapping[str, type[FrictionLaw]] = LAWS) -> bool:
    """Return whether a law is registered: as such, or as `without` or `with_parts` of another one.

    `laws` contains the registered laws by name. Another law of the same key does not count.
    """
    return law.key in laws and laws[law.key].face is law.face


slip_coefficient = select(lambda law: type(law).coefficient)
"""k(v2, z, law) [s/m], with F_h = -k g_n v_A and v2 = |v_A|^2, for any law that has one."""


REST2, FAST2 = np.float64(0), np.float64(1e6)
"""|v_A|^2 [m^2/s^2] at rest, and beyond that of any top."""


def _coefficients(law: Any, *speeds2: Any) -> list[Any]:
    """Return k [s/m] at these |v_A|^2 [m^2/s^2], at each for z = 1, 0 and -1.

    Whether k vanishes is judged by these three places.
    """
    with np.errstate(all="ignore"):
        return [slip_coefficient(v2, z, law) for v2 in speeds2 for z in (1.0, 0.0, -1.0)]


def takes_nothing(law: Any) -> Any:
    """Return which laws with numbers (n,) take no energy.

    k = 0 at rest and in motion, wherever the contact lies: the law `none`, and every law with
    mu = 0.
    """
    if law.set_valued or law.regions:
        none = law.mu == 0
    elif law.coefficient is None:
        return False
    else:
        none = reduce(and_, (k == 0 for k in _coefficients(law, 0.0, 1e-6, 1.0)))
    if law.torque is not None:
        # a drag and an omega with which every part of the torque would be seen in x or z
        turns = law.torque(inside(0.0, 1.0), Vector(1.0, 0.0, 1.0), law)
        none = none & (turns.x == 0) & (turns.z == 0)
    return none


def is_frictionless(law: Any) -> bool:
    """Return whether a law with its numbers takes no energy, see `takes_nothing`."""
    return bool(takes_nothing(law))


def nowhere_vanishes(law: Any) -> bool:
    """Return whether k > 0 wherever on the body the contact lies, at rest and in fast sliding."""
    return all(k > 0 for k in _coefficients(law, REST2, FAST2))


def add(law: type[FrictionLaw]) -> None:
    """Register a law under its key: every gliding system has it then. Raises InputError."""
    if faults := _faults(law):
        raise InputError(faults)
    LAWS[law.key] = law


NAME = r"[A-Za-z_][A-Za-z0-9_-]*"
"""The pattern of names of laws and systems, which TOML, the command line and stores contain."""


def checked_name(name: Any, kind: str) -> str:
    """Return the name of a law or a system. Raises InputError if it is not allowed."""
    if isinstance(name, str) and re.fullmatch(NAME, name):
        return name
    raise InputError(
        [
            f"the name of a {kind} must be letters, digits, - and _, and begin with no digit, but "
            f"is {name!r:.60}."
        ]
    )


def _faults(law: type[FrictionLaw]) -> list[str]:
    """Return messages on a law that cannot be registered; [] if it can.

    The attributes that are refused decide which phases a contact has, in `mechanics.contact`.
    """
    name = law.key
    faults = []
    if not callable(law.coefficient):
        faults.append(
            f"the law `{name}` must have a function `coefficient(v2, z, law)`, but has "
            f"{law.coefficient!r:.60}."
        )
    more = [word for word in ("set_valued", "regions", "torque", "without") if getattr(law, word)]
    must = "must be left out: it is for the laws of this package"
    faults += [f"`{word}` of the law `{name}` {must}." for word in more]
    taken = {part: f"every law takes it, as {rule.long_name}" for part, rule in PARTS.items()}
    taken["law"] = "that is the key of the law's name"
    return faults + [
        f"a parameter of the law `{name}` must not be named `{word}`: {why}."
        for word, why in taken.items()
        if word in law.parameters
    ]
