"""Systems whose contact may change its phase: the same body, followed from phase to phase."""

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache, partial
from typing import Any

from ..contact import body as contact
from ..contact.gliding import catalogue as gliding
from ..contact.gliding.euler import centre_velocity
from ..contact.phases import dry, legs
from ..contact.phases.both import BOTH_KINDS
from ..contact.phases.drilling import ANGLES as DRILLING_ANGLES
from ..contact.phases.drilling import DRILLING_KINDS, DRILLING_ROW, LOST
from ..contact.phases.drilling import Angles as DRILLING
from ..contact.phases.planar import ANGLES as PLANAR_ANGLES
from ..contact.phases.planar import PLANAR_KINDS, PLANAR_ROW
from ..contact.phases.planar import Angles as PlanarAngles
from ..contact.phases.row import ANGLES, JELLETTS, ROW, Angles, quantities
from ..events import Event
from ..friction import Law, all_laws
from ..operand import formula
from ..parameter import Parameter
from ..system import Phase, System
from ..units import METRE, METRE_PER_SECOND
from .cylinder import GLIDING_CYLINDER
from .gliding_heavy_top import GLIDING_HEAVY_TOP
from .outlook import tippe_top_with_contact
from .tippe_top import TIPPE_TOP, routh


BODIES: dict[str, System] = {system.name: system for system in (TIPPE_TOP, GLIDING_HEAVY_TOP, GLIDING_CYLINDER)}
"""The systems whose contact may change its phase, by name."""

ROUTH: dict[str, Callable] = {"tippe-top": routh}

OUTLOOKS: dict[str, Callable] = {"tippe-top": tippe_top_with_contact}

STEMMED = "tippe-top"
"""The one that may have a stem."""

DRILLED = "tippe-top"
"""The one that may have a contact disc."""

PLANAR = ("gliding-cylinder",)
"""Those that move in a plane."""

ABOVE = {
    "gap": Parameter(METRE, "height of the lowest point of the sphere above the plane", least=0),
    "nu_z": Parameter(METRE_PER_SECOND, "vertical velocity of the lowest point of the sphere"),
}
LONG_NAMES = {
    "gap": "height of the lowest point of the ball that touches the plane, or did last",
    "nu_z": "vertical velocity of the lowest point of that ball",
    "nu_x": "horizontal velocity of the lowest point along e; undefined (NaN) exactly at a pole",
    "nu_y": "horizontal velocity of the lowest point along 2hat; undefined (NaN) exactly at a pole",
}


def start(angles: Any, data: dict[str, Any], s: Any, z: Any, b: contact.Touch) -> Any:
    """The angles of what the user gave; centre_at_rest may stand for nu_x and nu_y."""
    e = gliding.given_angles(angles, data, z)
    if data.get("centre_at_rest"):
        along_e, along_2 = centre_velocity(e, s, z, b)
        e = e._replace(nu_x=e.nu_x - along_e, nu_y=e.nu_y - along_2)
    return e


def planar_start(data: dict[str, Any], s: Any, z: Any, b: contact.Touch) -> PlanarAngles:
    """The angles of what the user gave; centre_at_rest may stand for nu_x."""
    e = PlanarAngles(*(data.get(name, 0) for name in PlanarAngles._fields))
    return e._replace(nu_x=e.nu_x - e.theta_dot * contact.height(z, b)) if data.get("centre_at_rest") else e


@formula
def never(s, b):
    """A function without a zero: what it stands for is known by other means."""
    return 1 + 0 * s.z


LIFTOFF = Event(
    "liftoff",
    "normal force falls to zero: the body flies",
    never,
    direction=-1,
    kept=gliding.LIFTOFF.kept,
)
STICK = Event("stick", dry.STICK.long_name, never)
SLIP = Event("slip", legs.SLIP.long_name, never)
REVERSAL = Event("reversal", "sliding turns back at once where it stops", never)
IMPACT = Event("impact", "a ball strikes the plane: a landing, or one ball takes over from the other", never)
CONTACT_EVENTS = (LIFTOFF, STICK, SLIP, REVERSAL, IMPACT)
"""Ends of phases, as events of a run."""


def kind_of(law: Law) -> str:
    """Return how a contact that may open is followed under a law; "" if it is not."""
    if law.set_valued:
        return "dry"
    if law.regions:
        return "drilling"
    return "smooth" if law.coefficient is not None else ""


class FollowedLaws(Mapping):
    """The laws of a system under which its contact is followed in one way: a view, for registered laws."""

    def __init__(self, system: System, kind: str):
        self.system, self.kind = system, kind

    def _known(self) -> dict[str, Law]:
        return {name: law for name, law in all_laws(self.system.laws) if kind_of(law) == self.kind}

    def __getitem__(self, name: str) -> Law:
        return self._known()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())


def of_the_axis(system: System) -> tuple[Event, ...]:
    """The events of a system that say how its axis moves: they are the same in every phase."""
    return tuple(event for event in system.events if event.name in ("turning", "equator", "inverted"))


@lru_cache
def with_contact(name: str, friction: str, stem: bool) -> System:
    """The system of this name, whose contact may open and close.

    Parameters
    ----------
    name
        One of BODIES.
    friction
        "dry": a set-valued law; "drilling": one with regions, on a disc; "smooth": one of the sliding velocity.
    stem
        Whether there is a stem, that is another ball.

    Returns
    -------
    System
    """
    system, planar = BODIES[name], name in PLANAR
    form = PLANAR_ROW if planar else ROW
    drills = friction == "drilling"
    form = DRILLING_ROW if drills else form
    return system.replace(
        title=f"{system.title}, which may slip, roll and fly",
        forms={form.name: form},
        quantities=(*(() if planar else JELLETTS), *quantities(ROUTH.get(name), stem)),
        events=(*of_the_axis(system), *CONTACT_EVENTS),
        laws=FollowedLaws(system, friction),
        initial=system.initial | ABOVE,
        start=planar_start if planar else partial(start, DRILLING if drills else Angles),
        angles=PLANAR_ANGLES if planar else DRILLING_ANGLES if drills else ANGLES,
        long_names=system.long_names | LONG_NAMES | {LOST[0]: LOST[2]},
        integrals=() if planar else ("jellett",),
        landscape=None,
        potential=None,
        outlook=OUTLOOKS.get(name),
        borders=None,
        motion=None,
        long_form="",
        contact=(friction, stem),
    )


def plain(system: System) -> System:
    """The system whose contact never opens, of that of `with_contact`."""
    return BODIES[system.name]


def kinds_of(name: str) -> dict[str, legs.Kind]:
    """Every way in which the body of a system moves, by name."""
    return PLANAR_KINDS if name in PLANAR else legs.KINDS | {"dry-slip": dry.DRY_SLIP} | DRILLING_KINDS | BOTH_KINDS


@lru_cache
def leg(name: str, kind: str) -> System:
    """A phase of a system's contact as a system of its own.

    Parameters
    ----------
    name
        One of BODIES.
    kind
        One of `legs.KINDS`.

    Returns
    -------
    System
        Of the form "vector"; its parameters are `legs.PARAMETERS`, in internal units.
    """
    what, system = kinds_of(name)[kind], BODIES[name]
    of_axis = () if what.axis_stays else of_the_axis(system)
    return system.replace(
        phases={what.phase: Phase({what.form.name: what.form}, (), (*of_axis, *what.events))},
        parameters=dict.fromkeys(legs.PARAMETERS, Parameter(METRE, "in internal units")),
        body=legs.body,
        body_units=legs.body_units,
        normalised_to={"m": 1.0},
        undefined_at_poles=(),
        vectors={},
    )
