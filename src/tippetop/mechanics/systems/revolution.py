"""Bodies of revolution by their outline: eggs and lentils, and discs with a rounded rim.

`Spheroid` and `Disc` take the numbers of the user. `systems` makes the gliding and the rolling
`System` of such a body of those of a ball (`contact.gliding`, `contact.rolling`): its formulas get
the ball by which the body touches (`contact.present_body`). `pair` serves `ellipsoid` too.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

from ..contact import body as contact
from ..contact import gliding, outline, rolling
from ..contact.body import Top, Touch
from ..contact.present_body import form_by_states, in_scalars
from ..event import Event
from ..number import Number, number, reuse
from ..system import Domain, Opening, System, of_one_phase
from ..units import METRE
from . import outlook
from .tippe_top import TippeTop


class Outlined(Top, abstract=True):
    """A body of revolution with an outline: its shape takes some of its numbers."""

    shape: ClassVar[Any]
    faults = staticmethod(contact.inertia_faults)

    def seen(self: Any, friction: Any) -> Touch:
        """Return the body as the `b` of formulas, a `Touch` with its outline, R and c still ().

        `friction` is the record of a law. `touching_ball` fills in R and c, at each inclination.
        """
        shape = self.shape._make(getattr(self, name) for name in self.shape._fields)
        return Touch(self.m, (), (), self.I1, self.I3, self.g, friction, outline=shape)


class Spheroid(Outlined):
    """A spheroid: an egg or a lentil, with half length a along its axis, and half width b.

    Each number may be a text: with a unit, "60 g", or arithmetic of the others. By default the body
    is uniform.

    >>> import tippetop as tt
    >>> tt.Spheroid(m=0.06, a=0.03, b=0.02)
    Spheroid(m=0.06, a=0.03, b=0.02, c=0.0, I1=1.56e-05, I3=9.6e-06, g=9.81)
    """

    gliding = "spheroid"
    resting = "rolling-spheroid"
    shape = outline.Spheroid

    m: Number = reuse(TippeTop.parameters["m"])
    a: Number = number(METRE, "half length along the axis", symbol="a", above=0)
    b: Number = number(METRE, "half width", symbol="b", above=0)
    c: Number = number(
        METRE, "distance of the centre from the centre of mass along 3hat", symbol="c", default=0.0
    )
    I1: Number = reuse(TippeTop.parameters["I1"], default="m*(a^2 + b^2)/5", where_zero=("c",))
    I3: Number = reuse(TippeTop.parameters["I3"], default="2/5*m*b^2", where_zero=("c",))
    g: Number = reuse(TippeTop.parameters["g"], default=9.81)

    @staticmethod
    def faults(parameters: Mapping[str, float]) -> list[str]:
        """Return sentences on moments of inertia, and on a centre of mass outside of the body.

        It is `System.checks`; `parameters` are in SI.
        """
        at = parameters["c"] / parameters["a"]
        return contact.inertia_faults(parameters) + contact.outside_faults(at)


VOLUME = "(2*ring^2 + pi*ring*tube + 4/3*tube^2)"
"""The volume of a disc with a rounded rim, over pi*tube."""


class Disc(Outlined):
    """A disc that touches with its rounded rim: a circle of radius `ring`, rounded by `tube`.

    Each number may be a text: with a unit, "40 g", or arithmetic of the others. By default the body
    is uniform, its faces are flat.

    >>> import tippetop as tt
    >>> coin = tt.Disc(m="8 g", ring="11 mm", tube="1 mm")
    """

    gliding = "disc"
    resting = "rolling-disc"
    shape = outline.Rim

    m: Number = reuse(TippeTop.parameters["m"])
    ring: Number = number(METRE, "radius of the circle in the rim", symbol="r", above=0)
    tube: Number = number(METRE, "radius of the rounding of the rim", symbol="t", least=0)
    c: Number = number(
        METRE,
        "distance of the centre of the circle from the centre of mass along 3hat",
        symbol="c",
        default=0.0,
    )
    I1: Number = reuse(
        TippeTop.parameters["I1"],
        default=f"I3/2 + m*tube^2*(2/3*ring^2 + pi/4*ring*tube + 4/15*tube^2)/{VOLUME}",
        where_zero=("c",),
    )
    I3: Number = reuse(
        TippeTop.parameters["I3"],
        default="m*(ring^4 + pi*ring^3*tube + 4*ring^2*tube^2 + 3/4*pi*ring*tube^3 + 8/15*tube^4)"
        f"/{VOLUME}",
        where_zero=("c",),
    )
    g: Number = reuse(TippeTop.parameters["g"], default=9.81)


LEAST_SINE2 = 1e-6
"""sin(theta)^2 of a disc that lies flat: there the contact runs round its rim ever faster."""

FLAT = Event(
    "flat",
    "the disc lies flat: sin(theta) falls through 1e-3",
    lambda s, b: (1 - s.z) * (1 + s.z) - LEAST_SINE2,
    direction=-1,
    ends="flat",
)
NOT_FLAT = Domain(
    FLAT.formula,
    "a disc with sin(theta) below 1e-3 lies flat: it has no single contact point",
)

JELLETT = replace(gliding.JELLETT_QUANTITY, long_name="-L.a, which is constant for a sphere only")


def pair(
    body: type[Top],
    title: str,
    slides: Mapping[str, Any],
    rolls: Mapping[str, Any],
    domains: tuple[Domain, ...] = (),
    **more: Any,
) -> tuple[System, System]:
    """Return the gliding and the rolling system of a body, with fields of each and `more` of both.

    The unit of length is the size of its outline. Formulas may be those of a ball: here they are
    changed to take the ball by which the body touches, which leaves those of an `Asymmetric` body
    as they are. `ellipsoid` calls it too.
    """

    def system(phase: str, name: str, fields: Mapping[str, Any], words: str) -> System:
        """Return the system of one phase, "slip" or "roll", whose title ends with these words."""
        records = {
            key: tuple(map(in_scalars, fields.get(key, ())))
            for key in ("quantities", "events", "on_request")
        }
        forms = {
            key: form_by_states(replace(form, domains=(*domains, *form.domains)))
            for key, form in fields["forms"].items()
        }
        return of_one_phase(
            phase,
            name=name,
            title=f"{title} {words}",
            parameters=body.parameters,
            body=body.body_of,
            checks=body.faults,
            scales=lambda b: (b.m, b.outline.size),
            normalised_to={"m": 1.0},
            **{**fields, **records, "forms": forms, **more},
        )

    return (
        system("slip", body.gliding, slides, "that glides"),
        system("roll", body.resting, rolls, "in pure rolling"),
    )


def systems(
    body: type[Outlined],
    title: str,
    *,
    events: tuple[Event, ...] = (),
    domains: tuple[Domain, ...] = (),
    **more: Any,
) -> tuple[System, System]:
    """Return the gliding and the rolling system of a body with an outline.

    `events` are added to those of both; `domains` are conditions for the motion to be possible,
    such as a rim that touches; `more` are further fields of both systems.
    """
    slides = gliding.OF_SYSTEM | {
        "quantities": (JELLETT, *gliding.QUANTITIES),
        "on_request": (gliding.MODIFIED_ENERGY_RATE,),
        "opening": Opening(outlined=True, domains=domains, outlook=outlook.revolution),
        "outlook": outlook.revolution,
    }
    rolls = rolling.OF_SYSTEM | {
        "quantities": (JELLETT, *gliding.ENERGIES, *rolling.REACTION),
        "outlook": partial(outlook.revolution, rolls=True),
    }
    for fields in (slides, rolls):
        fields["events"] += events
    return pair(body, title, slides, rolls, domains, **more)


SPHEROID, ROLLING_SPHEROID = systems(
    Spheroid,
    "spheroid",
    source="Moffatt, H. K., Shimomura, Y.: Spinning eggs - a paradox resolved. "
    "Nature 416, 385 (2002)",
    classes=("tumbling", "upright", "inverted"),
)
DISC, ROLLING_DISC = systems(
    Disc,
    "disc with a rounded rim",
    source="Moffatt, H. K.: Euler's disk and its finite-time singularity. Nature 404, 833 (2000)",
    events=(FLAT,),
    domains=(NOT_FLAT,),
    classes=("tumbling",),
)
