"""Friction laws as checked frozen records: F_h = -k g_n v_A, with v_A the velocity of the contact point."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, cast

from ..arguments import refuse_unknown
from ..errors import InputError
from ..mechanics.friction import PARTS, Law, named
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS, laws_of, load_entry_points
from ..scenario.numbers import checked


Given = float | str  # as of a body


@dataclass(frozen=True, repr=False)
class Friction:
    """A friction law with its numbers, checked when it is made; `law` is its name in `[friction] law`."""

    law: ClassVar[str]
    known_to: ClassVar[str] = "gliding-cylinder"  # it takes every law

    def __new__(cls, *_: Any, **named: Any) -> Any:
        """A TypeError for a keyword that the law has not names the nearest one."""
        refuse_unknown(cls.__name__, named, [f.name for f in fields(cls)])
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for name, value in checked("friction", self._law().parameters, self.numbers()).items():
            object.__setattr__(self, name, value)

    def _law(self) -> Law:
        return SYSTEMS[self.known_to].laws[self.law].given(self.numbers())

    def numbers(self) -> dict[str, float]:
        """The numbers by name, in SI units."""
        names = sorted((f.name for f in fields(self)), key=lambda name: name in PARTS)
        given = {name: getattr(self, name) for name in names}
        return {name: value for name, value in given.items() if value is not None or name == "mu"}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.numbers().items())})"

    def record(self) -> Any:
        """The record that formulas take."""
        return self._law().record(**self.numbers())


@dataclass(frozen=True, kw_only=True, repr=False)
class WithParts(Friction):
    """A friction law to which parts can be added."""

    mu_r: float | None = None
    mu_d: float | None = None

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.__repr__ = _written  # type: ignore[method-assign, assignment]  # the decorator leaves it


def _written(law: WithParts) -> str:
    """Return a law as it is made: without parts that it does not have."""
    numbers = law.numbers()
    names = [*(name for name in numbers if name not in PARTS), *(name for name in PARTS if name in numbers)]
    return f"{type(law).__name__}({', '.join(f'{name}={numbers[name]!r}' for name in names)})"


@dataclass(frozen=True, repr=False)
class Viscous(WithParts):
    """Viscous friction, F = -mu g_n v_A: the law of Rutstam's thesis (2010).

    Parameters
    ----------
    mu : float
        Friction coefficient [s/m], at least 0.
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Raises
    ------
    InputError
        If mu is not a number that is at least 0.

    Notes
    -----
    Rutstam (2010), eq. 3.1.
    """

    mu: float

    if TYPE_CHECKING:

        def __init__(self, mu: Given, *, mu_r: Given | None = None, mu_d: Given | None = None) -> None: ...

    law: ClassVar[str] = "viscous"


@dataclass(frozen=True, repr=False)
class Coulomb(WithParts):
    """Dry friction: Coulomb's law itself, F = -mu g_n v_A/|v_A| where the contact slides and as much as rolling takes
    where it does not; with eps the regularised one, F = -mu g_n v_A/sqrt(|v_A|^2 + eps^2).

    Parameters
    ----------
    mu : float
        Friction coefficient, without unit, at least 0.
    eps : float, optional
        Regularisation speed [m/s], positive; it decides when a top inverts. Without it the contact slips, rolls and
        flies, and the tables `phases` and `impacts` say when.
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Coulomb (1785). Why it does not turn a tippe top over, and what eps changes: docs/contact.md.
    """

    mu: float
    eps: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self, mu: Given, eps: Given | None = None, *, mu_r: Given | None = None, mu_d: Given | None = None
        ) -> None: ...

    law: ClassVar[str] = "coulomb"


@dataclass(frozen=True, repr=False)
class Contensou(Friction):
    """Friction that drills: Coulomb's law at each point of a contact disc under Hertz's pressure, of a tippe top.

    Parameters
    ----------
    mu : float
        Friction coefficient, without unit, at least 0.
    patch : float
        Radius of the disc [m], positive.
    mu_r : float, optional
        Rolling resistance [m]: torque per normal force, at least 0; none by default.
    mu_d : float, optional
        Drilling torque [m] per normal force besides that of the disc, at least 0.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Contensou (1963), Zhuravlev (1998). The contact slips and flies, and the tables `phases` and `impacts` say when.
    """

    mu: float
    patch: float
    mu_r: float = 0.0
    mu_d: float | None = field(default=None, kw_only=True)

    if TYPE_CHECKING:

        def __init__(self, mu: Given, patch: Given, mu_r: Given = 0.0, *, mu_d: Given | None = None) -> None: ...

    law: ClassVar[str] = "contensou"


@dataclass(frozen=True, repr=False)
class Mixed(WithParts):
    """Viscous and dry friction together, F = -[mu + mu_coulomb/sqrt(|v_A|^2 + eps^2)] g_n v_A.

    Parameters
    ----------
    mu : float
        Viscous friction coefficient [s/m], at least 0.
    mu_coulomb : float
        Dry friction coefficient, without unit, at least 0.
    eps : float
        Regularisation speed [m/s], positive.
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Or, A. C.: The dynamics of a tippe top. SIAM J. Appl. Math. 54 (1994).
    """

    mu: float
    mu_coulomb: float
    eps: float

    if TYPE_CHECKING:

        def __init__(
            self, mu: Given, mu_coulomb: Given, eps: Given, *, mu_r: Given | None = None, mu_d: Given | None = None
        ) -> None: ...

    law: ClassVar[str] = "mixed"


@dataclass(frozen=True, repr=False)
class Stribeck(WithParts):
    """Dry friction that weakens with speed: mu_static at rest falls to mu over the speed v_s.

    Parameters
    ----------
    mu, mu_static : float
        Friction coefficient at high speed and at rest, without unit, at least 0.
    v_s : float
        Stribeck speed [m/s], positive.
    eps : float
        Regularisation speed [m/s], positive.
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Stribeck, R. (1902).
    """

    mu: float
    mu_static: float
    v_s: float
    eps: float

    if TYPE_CHECKING:

        def __init__(
            self,
            mu: Given,
            mu_static: Given,
            v_s: Given,
            eps: Given,
            *,
            mu_r: Given | None = None,
            mu_d: Given | None = None,
        ) -> None: ...

    law: ClassVar[str] = "stribeck"


@dataclass(frozen=True, repr=False)
class Latitude(WithParts):
    """Viscous friction of a body of two materials, linear in cos(theta) between them.

    Parameters
    ----------
    mu : float
        Coefficient on the heavy cap [s/m] (contact at cos(theta) = 1), at least 0.
    mu_stem : float
        Coefficient on the side of the stem [s/m] (contact at cos(theta) = -1), at least 0.
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.
    """

    mu: float
    mu_stem: float

    if TYPE_CHECKING:

        def __init__(
            self, mu: Given, mu_stem: Given, *, mu_r: Given | None = None, mu_d: Given | None = None
        ) -> None: ...

    law: ClassVar[str] = "latitude"


@dataclass(frozen=True, repr=False)
class Modified(Friction):
    """The modified reaction of a cylinder: F = m (1 - kappa) s_z'' zhat + m kappa s''_rolling + m g zhat - mu v_A.

    Parameters
    ----------
    mu : float
        Friction coefficient [kg/s], at least 0.
    v_k : float
        Speed [m/s], positive, at which kappa = 1/(1 + v_A^2/v_k^2) is one half.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Rutstam (2010), eq. 6.18; the family kappa is ours, the source leaves it open.
    """

    mu: float
    v_k: float

    if TYPE_CHECKING:

        def __init__(self, mu: Given, v_k: Given) -> None: ...

    law: ClassVar[str] = "modified"


@dataclass(frozen=True, repr=False)
class Frictionless(WithParts):
    """No friction: the plane pushes vertically only. `[friction] law = "none"`.

    Parameters
    ----------
    mu_r, mu_d : float, optional
        Rolling resistance and drilling torque [m], of a tippe top: docs/contact.md.

    Notes
    -----
    Not to be confused with pure rolling, where the contact point is at rest: that is another system.
    """

    law: ClassVar[str] = "none"


def table_of(law: Any, laws: Mapping[str, Law]) -> dict[str, Any]:
    """The table [friction] of a law: one of these records, or a record of a law that is registered among `laws`.

    Raises InputError."""
    if isinstance(law, Friction):
        return {"law": law.law, **law.numbers()}
    load_entry_points()
    if isinstance(law, str):
        kinds: list[type[Friction]] = [*WithParts.__subclasses__(), Contensou, Modified]
        record = next((kind.__name__ for kind in kinds if kind.law == law), "Viscous")
        raise InputError([f"the friction law must be a record such as {record}(...), but is {law!r:.60}."])
    if isinstance(law, type):
        raise InputError([f"the friction law must be a record such as {law.__name__}(...), but is the class itself."])
    if not isinstance(law, tuple):
        raise InputError([f"the friction law must be a record such as Viscous(mu=0.3), but is {law!r:.60}."])
    if known := named(type(law), laws):
        return {"law": known[0], **cast(Any, law)._asdict()}
    kind = type(law).__name__
    raise InputError([f"the friction law {kind} must be registered: tippetop.register(Law({kind}, ...))."])


def record_of(law: Any, system: System) -> Any:
    """The record that formulas take, of a law as `table_of` takes it."""
    numbers, laws = table_of(law, system.laws), laws_of(system)
    if (name := numbers.pop("law")) not in laws:
        raise InputError([f"`{system.name}` must have a law of {', '.join(laws)}, but has {name}."])
    known = laws[name].given(numbers)
    return known.record(**checked("friction", known.parameters, numbers))
