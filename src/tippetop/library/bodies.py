"""Bodies as checked frozen records: what `run` and the others take as a top.

The records of formulas hold operands (arrays, expressions, numbers inside numba) and can check nothing; these hold the
user's numbers, are checked once, and become tables of a scenario. So neither has to know of the other.
"""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from ..arguments import refuse_unknown
from ..errors import InputError
from ..mechanics.friction import Frictionless
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS
from ..scenario.numbers import checked


Given = float | str
"""A number in SI units, or a text that stands for one: "20 g"."""


@dataclass(frozen=True)
class Top:
    """A body: numbers in SI units that are checked together when it is made.

    `gliding` and `resting` name its systems: with a friction law, and without one.
    """

    gliding: ClassVar[str]
    resting: ClassVar[str]

    def __new__(cls, *_: Any, **named: Any) -> Any:
        """A TypeError for a keyword that the body has not names the nearest one."""
        refuse_unknown(cls.__name__, named, [f.name for f in fields(cls)])
        return super().__new__(cls)

    def __post_init__(self) -> None:
        system = SYSTEMS[self.gliding]
        numbers = checked("parameters", system.parameters, {f.name: getattr(self, f.name) for f in fields(self)})
        if faults := system.checks(numbers):
            raise InputError(faults)
        for name, value in numbers.items():
            object.__setattr__(self, name, value)

    def numbers(self) -> dict[str, float]:
        """The numbers by name, in SI units: the table [parameters] of a scenario."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def body(self, law: Any = None) -> Any:
        """The record that formulas take, in SI units; `law` is a record of a friction law, as `Viscous.record` gives.

        Raises InputError if it is none."""
        if law is not None and not hasattr(law, "_fields"):
            raise InputError([f"`law` must be the record of a friction law, but is {law!r:.60}."])
        return self.system().body_of(self.numbers(), Frictionless() if law is None else law)

    def system(self, *, gliding: bool = True) -> System:
        """The system that the body is by default, gliding or with its contact at rest."""
        return SYSTEMS[self.gliding if gliding else self.resting]


@dataclass(frozen=True)
class TippeTop(Top):
    """A tippe top: a sphere whose centre of mass lies alpha*R below its centre; with alpha < 0, a peg, above it.

    Parameters
    ----------
    m : float
        Mass [kg], positive.
    R : float
        Radius of the sphere [m], positive.
    alpha : float
        Eccentricity, in (-1, 1) and not 0, without unit.
    I1, I3 : float
        Transverse and axial moment of inertia about the centre of mass [kg m^2], positive, I3 <= 2 I1.
    g : float
        Acceleration of gravity [m/s^2], positive.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Each number may be a text: with a unit, "20 g", which must fit; or arithmetic of the others in SI units,
    "2/5*m*R^2", whose dimension is not checked. Rutstam, N.: Study of equations for Tippe Top and related rigid bodies.
    Linkoping (2010), chapter 3.

    Examples
    --------
    >>> import tippetop as tt
    >>> tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-6, I3=3.2e-6, g=9.82)
    TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-06, I3=3.2e-06, g=9.82)
    """

    m: float
    R: float
    alpha: float
    I1: float
    I3: float
    g: float

    if TYPE_CHECKING:  # what is checked becomes a float

        def __init__(self, m: Given, R: Given, alpha: Given, I1: Given, I3: Given, g: Given) -> None: ...

    gliding: ClassVar[str] = "tippe-top"
    resting: ClassVar[str] = "rolling-tippe-top"


@dataclass(frozen=True)
class HeavyTop(Top):
    """A heavy symmetric top: with a fixed tip, or with a tip that glides on the plane.

    Parameters
    ----------
    m : float
        Mass [kg], positive.
    l : float
        Distance from the tip to the centre of mass [m], positive.
    I1, I3 : float
        Transverse and axial moment of inertia about the centre of mass [kg m^2], positive, I3 <= 2 I1.
    g : float
        Acceleration of gravity [m/s^2], positive.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping (2010), chapters 2 and 5.
    """

    m: float
    l: float
    I1: float
    I3: float
    g: float

    if TYPE_CHECKING:

        def __init__(self, m: Given, l: Given, I1: Given, I3: Given, g: Given) -> None: ...

    gliding: ClassVar[str] = "gliding-heavy-top"
    resting: ClassVar[str] = "heavy-top"


@dataclass(frozen=True)
class Cylinder(Top):
    """An eccentric cylinder that moves in a plane across its axis.

    Parameters
    ----------
    m : float
        Mass [kg], positive.
    R : float
        Radius [m], positive.
    alpha : float
        Eccentricity: the centre of mass lies alpha*R off the axis, in [0, 1), without unit.
    I : float
        Moment of inertia about the centre of mass [kg m^2], positive.
    g : float
        Acceleration of gravity [m/s^2], positive.

    Raises
    ------
    InputError
        With one sentence for every number that is wrong.

    Notes
    -----
    Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping (2010), chapter 6.
    """

    m: float
    R: float
    alpha: float
    I: float
    g: float

    if TYPE_CHECKING:

        def __init__(self, m: Given, R: Given, alpha: Given, I: Given, g: Given) -> None: ...

    gliding: ClassVar[str] = "gliding-cylinder"
    resting: ClassVar[str] = "rolling-cylinder"
