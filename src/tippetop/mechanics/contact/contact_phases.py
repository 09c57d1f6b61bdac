"""The phases of a body under a friction law: flight, on one of its balls, on both, at rest.

`phases_under(law)` returns a `Phase` for each: the equations of motion as a `Form`, the events that
end it, and `enter` and `leave`, which convert between its state and the common state `Moving`.
`opening` adds the exits. All phases in contact are made by `on_ball` from one function, the forces
of the plane, so that energy, work and rows are computed in the same way in all of them.

Symbols
    b         the body seen from the ball in contact, a `body.Touch`; b.friction: record of the law
    q         the state of a phase: axis ux, uy, uz, momentum L, and variables of v_A if it slides
    x         `Turning` (u, L), or the common state `Moving`; u, 3hat: unit vector of the axis
    s         in (s, b): the scalars of a state, a `Contact`
    omega     angular velocity; Omega_z: its vertical part
    v, v_A    velocity of the contact point, w its size, beta its azimuth; G: its acceleration
    patch     radius of the disc of contact; U = patch Omega_z: speed of its edge
    region    a name in `law.regions`: a part of the (v_A, U) where one formula of the law is valid
    side      number of a contact: 0 the sphere, 1 the stem
    way       a border of a region, see `disc_friction`
"""

from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

from ..disc_friction import STOPS_ROLLING, drilling_force, rolling
from ..event import Event
from ..form import Form, Orientation, Phase
from ..friction import load, slip_coefficient
from ..operand import Vector, atan2, cos, cross, dot, minus, plus, sin, sqrt, times
from ..units import METRE, METRE_PER_SECOND, RADIAN
from . import body as contact
from . import gliding
from .body import (
    AXIS,
    VELOCITY,
    Moving,
    Reaction,
    Touch,
    Turning,
    angular_velocity,
    arm,
    centre_velocity,
    contact_velocity,
    gained,
    height,
    height_of,
    momentum_of,
    seen_from_other,
    state,
)
from .body_axes import carried_along
from .gliding import VectorState, axis, axis_rate, turning
from .integrals import integral, place
from .response import (
    across_and_along,
    around_torque,
    cone,
    contact_acceleration,
    kicked,
    margin,
    resting,
    sliding,
    surroundings_power,
)
from .rolling import spin
from .surroundings import mean_gravity, pushing


def phase_name(label: str, ball: int, *regions: str) -> str:
    """Return the name of a phase: phase_name("slip", 1) == "stem-slip"; regions are appended.

    `label` is one of PHASES, `ball` 0 (sphere) or 1 (stem); one region for each ball in contact.
    Events at the borders of regions are named by it too, with the event of the border as `label`.
    """
    return "-".join((*("stem",) * ball, label, *regions))


class Acts(NamedTuple):
    """The action of the plane at one contact: force [N], torque [N m], v_A and omega, (3,) each.

    It can be used as a `Reaction`. `acts` in `on_ball` makes it, and `side` in `shared`.
    """

    force: Vector
    torque: Vector  # about the contact point
    velocity: Vector  # v_A [m/s]
    omega: Vector  # [rad/s]
    sides: tuple = ()  # the `Acts` of each ball, sphere first, if both touch

    @property
    def drilled(self) -> Any:
        """Return the power [W] that the torque of the plane takes from the body."""
        return -dot(self.torque, self.omega)


Contact: Any = namedtuple("Contact", "z z_dot by sides q")
"""cos(theta) and its rate [1/s]; `by`: the `Acts` of the plane; `sides`: a tuple of the `Acts` on
each ball in contact, by `side`; `q`: the state of the phase."""


TURN = carried_along(axis_rate, spin)
OF_FRAME = Orientation(lambda q, carried, b: axis(q).axes[::2])
"""Of a state with a Frame: `[::2]` are axes 1 and 3; psi is one of its angles."""


def orientation_of(units: Any) -> Orientation:
    """Return the `Orientation` of states with these variables: their frame, or 3hat and a turn."""
    return OF_FRAME if "ix" in units._fields else TURN


def on_ball(
    units: Any,
    events: tuple,
    forces: Callable,
    velocity: Callable,
    enter: Callable,
    changes: Callable,
) -> Phase:
    """Return a phase whose state is that of a body on one ball: axis, L, and some variables of v_A.

    Parameters
    ----------
    units
        The state, filled with units: that of `body.state`, which is filled by position.
    events
        The events of the phase.
    forces
        forces(turning(q), q, b) -> force and torque of the plane, and the actions on both balls, if
        both touch.
    velocity
        velocity(q) -> v_A.
    enter
        enter(v_A) -> the variables of the state that follow axis and L.
    changes
        changes(q, G) -> the rates of these, G being the acceleration of the contact point.
    """

    def in_place(q, b):
        """Return the motion that `forces` take of a state q: a `Moving` on a turntable, or a
        `Turning`, which needs fewer products.
        """
        return leave(q, b) if b.around and b.around.table else turning(q)

    def acts(q, b):
        """Return the action of the plane, an `Acts`: the `reaction` of the phase."""
        x = in_place(q, b)
        force, torque, *sides = forces(x, q, b)
        return Acts(force, torque, velocity(q), angular_velocity(x, b), tuple(sides))

    def rates(q, b):
        """Return the rates of a state q: 3hat', L' = a x F + torque, and `changes` of v_A."""
        by = acts(q, b)
        turn = plus(cross(arm(axis(q), b), by.force), by.torque)
        turn = plus(turn, around_torque(turning(q), b))
        G = contact_acceleration(in_place(q, b), by.force, by.torque, b)
        return type(units)(*axis_rate(q, b), *turn, *changes(q, G))

    def scalars(q, b):
        """Return the `Contact` of a state q, from which the events of the phase are computed."""
        by = acts(q, b)
        return Contact(q.uz, axis_rate(q, b).z, by, by.sides or (by,), q)

    def entered(x, b):
        """Return the state of the phase from the common state x."""
        return type(units)(*x.u, *x.L, *enter(contact_velocity(x, b)))

    def leave(q, b):
        """Return the common state `Moving` of a state q of the phase."""
        x = turning(q)
        return Moving(x.u, x.L, centre_velocity(x, velocity(q), b), height_of(x.u, b))

    def power(q, carried, b):
        """Return the power that friction and surroundings take [W], the rate of `work`.

        `rows.row_scalars` has the part of friction for a row; a change of one changes both.
        """
        by = acts(q, b)
        power = by.drilled - dot(by.force, by.velocity)
        return power + surroundings_power(leave(q, b), b)

    def jellett_lost(q, carried, b):
        """Return the rate at which torques take Jellett's integral [kg m^3/s^2].

        `flight` has this rate without a contact, and `response.kicked` the same of impulses.
        """
        by = acts(q, b)
        return dot(plus(by.torque, around_torque(turning(q), b)), arm(axis(q), b))

    integrals = (
        *place(lambda q, carried, b: leave(q, b).velocity),
        integral("work", power),
        integral("impulse", lambda q, carried, b: acts(q, b).force.z),
        integral("jellett_lost", jellett_lost),
    )
    turns = orientation_of(units)
    form = Form("vector", units, rates, scalars, integrals=integrals, orientation=turns)
    return Phase(form, (), events, enter=entered, leave=leave, reaction=acts)


def zero_vector(q: Any) -> Vector:
    """Return a zero vector of the type of the state's numbers: v_A of a contact at rest."""
    return times(0, axis(q))


def horizontal2(v: Vector) -> Any:
    """Return v.x^2 + v.y^2, the square of the horizontal part of a vector."""
    return v.x * v.x + v.y * v.y


def ending(name: str, long_name: str, function: Callable, direction: int = -1) -> Event:
    """Return an event that ends a phase, named as its exit.

    It happens where function(s, b) is zero. Its name is a key of `exits.JUMPS`, or of the jumps
    that `opening.phases_of` adds.
    """
    return Event(name, long_name, function, direction, name)


def other_gap(s, b):
    """Return the gap [m] of the other ball while this one touches: the function of `touch`."""
    return b.clearance + b.lever * s.z


TOUCH = ending("touch", "the other ball touches the plane", other_gap)
LIFTOFF = replace(gliding.LIFTOFF, formula=lambda s, b: s.by.force.z)


# --- free flight --------------------------------------------------------------------------------


Free: Any = namedtuple("Free", "z z_dot gap")
"""The scalars of a flight: cos(theta) and its rate [1/s]; the gap of the phase's ball [m]."""


def moving(q: Any, carried: Any = ()) -> Moving:
    """Return the common state of a body in flight, or of a row; by default without integrals."""
    x = turning(q)
    return Moving(x.u, x.L, Vector(q.rx_dot, q.ry_dot, q.rz_dot), q.height, carried)


def free_rates(q, b):
    """Return the rates of a flight, in the order of its state: axis, L, velocity, height.

    3hat' = L x 3hat/I1, L' = 0, s'' = -g zhat; surroundings add torque and push.
    """
    still = 0 * q.uz
    x = moving(q)
    push = pushing(x.velocity, still, b)
    return *axis_rate(q, b), *around_torque(x, b), push.x, push.y, still - b.g, q.rz_dot


def flight(lies: tuple[str, ...] = AXIS, surrounded: bool = False) -> Phase:
    """Return the phase of free flight; `lies` are the names of the variables of the orientation.

    `surrounded`: whether air or plane take energy in flight.
    """
    units = state(lies, **VELOCITY, height=METRE)
    losses = (
        integral("work", lambda q, carried, b: surroundings_power(moving(q), b)),
        integral(
            "jellett_lost",
            lambda q, carried, b: dot(around_torque(turning(q), b), arm(axis(q), b)),
        ),
    )
    form = Form(
        "vector",
        units,
        lambda q, b: type(units)(*free_rates(q, b)),
        lambda q, b: Free(q.uz, axis_rate(q, b).z, q.height - height_of(axis(q), b)),
        integrals=(
            *place(lambda q, carried, b: moving(q).velocity),
            *(losses if surrounded else ()),
        ),
        orientation=orientation_of(units),
    )
    events = (
        ending("land", "the ball lands", lambda s, b: s.gap),
        replace(TOUCH, formula=lambda s, b: s.gap + other_gap(s, b)),
    )

    def enter(x: Moving, b: Any) -> Any:
        """Return the state of a flight from the common state x."""
        return type(units)(*x.u, *x.L, *x.velocity, x.height)

    leave = lambda q, b: moving(q)  # noqa: E731
    return Phase(form, (), events, (), enter, leave, lambda q, b: Reaction(zero_vector(q)))


FLIGHT = flight()


# --- sliding under a law that is smooth in the velocity -----------------------------------------


def slip_leave(q, b):
    """Return the common state of a state q of slip under a smooth law."""
    # the height's rate is -c z', also of an outline
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * axis_rate(q, b).z))
    return Moving(axis(q), turning(q).L, velocity, height(q.uz, b))


SLIP = Phase(
    gliding.VECTOR,
    (),
    (gliding.LIFTOFF, TOUCH),
    enter=lambda x, b: VectorState(*x.u, *x.L, dot(x.L, x.u), *x.velocity[:2]),
    leave=slip_leave,
    reaction=lambda q, b: Reaction(gliding.reaction(q, b)),
)


# --- rolling, and sliding under a set-valued law -----------------------------------------------


def without_slip(events: tuple, holds: Callable = resting, lies: tuple[str, ...] = AXIS) -> Phase:
    """Return a phase in which the contact point stays at rest.

    holds(x, b) returns the force and torque that keep it there; `lies` are the variables of the
    orientation.
    """
    forces = lambda x, q, b: holds(x, b)  # noqa: E731
    return on_ball(state(lies), events, forces, zero_vector, lambda v: (), lambda q, G: ())


CONE = ending(
    "slip",
    "rolling needs more friction than there is: the contact slides",
    lambda s, b: cone(s.by.force, b),
)

STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. An impulse takes the rest."""


def slip_direction(q: Any) -> Vector:
    """Return n = v_A/|v_A| = (cos(beta), sin(beta), 0) of a state of slip under Coulomb's law."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


def directed_changes(q, G):
    """Return beta' = (zhat x n).G/w and w' = n.G of a state of slip, G = v_A' being given, (3,)."""
    across, along = across_and_along(G, slip_direction(q))
    return across / q.w, along


STICK = ending(
    "stick",
    "sliding stops, v_A = 0: the contact rolls, if the friction cone allows",
    lambda s, b: s.q.w - STOPS_AT,  # transversal, as |v_A|^2 is not
)


def coulomb_slip(lies: tuple[str, ...]) -> Phase:
    """Return the phase of sliding under Coulomb's law itself.

    v_A = w (cos(beta), sin(beta)) in space axes: so |v_A| keeps its digits, and its direction its
    length, where sliding stops. `sliding` gets the direction instead of v_A, on which the force
    does not depend otherwise. beta precedes w in the state, in what enters it, in its rates, and
    where `exits` fills it (`pushed`, `slide`); a change of one is a change of all.
    """
    return on_ball(
        state(lies, beta=RADIAN, w=METRE_PER_SECOND),
        (LIFTOFF, TOUCH, STICK),
        lambda x, q, b: sliding(x, smooth_friction, slip_direction(q), b),
        lambda q: times(q.w, slip_direction(q)),
        lambda v: (atan2(v.y, v.x), sqrt(horizontal2(v))),
        directed_changes,
    )


# --- sliding of a disc, under a law with regions ------------------------------------------------


STILL = 1e-9
"""Speed of the disc's edge, internal units, below which friction on a disc that does not turn is
smooth. Where such a disc begins to slide, or turns back, the motion differs from that under
Coulomb's law itself by about so much."""

RESTS_BELOW = 1e-6
"""Angular velocity, internal units, below which a disc comes to rest, if friction can hold it. An
impulse takes the rest of its turning, which would last less than a thousandth of internal time.
"""

LEAST_PATCH = 1e-5
"""Radius of the disc, by that of the sphere. The speeds at which a smaller one rests are less than
STILL, where smooth friction lets it creep: it would never come to rest."""

Speeds: Any = namedtuple("Speeds", "v2 U2")
"""|v_A|^2 and U^2 of a contact [m^2/s^2]; `Border.beyond` reads them by name."""


def patch_speed2(omega, b):
    """Return U^2 = (patch Omega_z)^2 [m^2/s^2], plus STILL^2 so that it is never zero."""
    turn = b.friction.patch * omega.z
    return turn * turn + STILL**2


def disc_friction(
    drag: Callable, torque: Callable, edge_speed2: Callable = patch_speed2
) -> Callable:
    """Return friction(omega, v, z, b) -> force and torque of a disc per normal force, (3,) each.

    Parameters
    ----------
    drag
        drag(v2, U2) of the region of the law.
    torque
        torque(drag, omega, law) of the law.
    edge_speed2
        edge_speed2(omega, b) -> U^2 of the disc's edge.
    """

    def friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
        """Return force and torque [m] per normal force, (3,) each."""
        by = drag(horizontal2(v), edge_speed2(omega, b))
        # 1: per normal force
        return drilling_force(1, v, by, b.friction.mu), torque(by, omega, b.friction)

    return friction


def smooth_friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
    """Return force -k v_A + zhat and torque [m] per normal force, under a law without regions.

    It has the arguments of `disc_friction`'s result: z is cos(theta).
    """
    k = -slip_coefficient(horizontal2(v), z, b.friction)
    return Vector(k * v.x, k * v.y, 1), load(omega, b.friction)


def rest_speed2(b):
    """Return the square of the speed of its edge below which a disc rests [m^2/s^2]."""
    return STILL**2 + (b.friction.patch * RESTS_BELOW) ** 2


def speeds(v: Vector, omega: Vector, b: Touch) -> Speeds:
    """Return |v|^2 and U^2 of a contact [m^2/s^2], from which the region of its sliding follows."""
    return Speeds(horizontal2(v), patch_speed2(omega, b))


def beyond_rest(s, b):
    """Return the sum of |v|^2 + U^2 over the contacts, less that of discs at rest [m^2/s^2].

    It is the function of RESTS, zero where a disc comes to rest.
    """
    rests = STILL**2 + rest_speed2(b)  # `speeds` adds STILL^2 to U^2
    return sum(sum(speeds(side.velocity, side.omega, b)) - rests for side in s.sides)


RESTS = ending("rests", "no disc in contact slides or turns", beyond_rest)


def border(way: Any, side: int) -> Event:
    """Return the event in which the contact `side` crosses the border `way` of its region."""

    def beyond(s, b):
        """Return how far the contact is beyond the border; zero where it crosses it."""
        by = s.sides[side]
        return way.beyond(speeds(by.velocity, by.omega, b), b)

    name = phase_name(way.event, side)
    return ending(name, "sliding against turning", beyond, way.direction)


def with_slip(events: tuple, pushed: Callable, lies: tuple[str, ...] = AXIS) -> Phase:
    """Return a phase of sliding, whose state has the components vx, vy of v_A.

    pushed(x, v, b) returns force and torque of the plane, and the actions on both balls, if both
    touch.
    """

    def velocity(q):
        """Return v_A of a state, (3,)."""
        return Vector(q.vx, q.vy, 0 * q.uz)

    forces = lambda x, q, b: pushed(x, velocity(q), b)  # noqa: E731
    units = state(lies, vx=METRE_PER_SECOND, vy=METRE_PER_SECOND)
    return on_ball(units, events, forces, velocity, lambda v: v[:2], lambda q, G: G[:2])


def frictions_of(law: Any, names: Sequence[str]) -> list[Callable]:
    """Return friction(omega, v, z, b), as of `disc_friction`, for each contact.

    `names` are the regions of the law in which the contacts slide; of a law without regions they
    are empty, and its smooth friction is returned twice.
    """
    by_region = [disc_friction(law.regions[name].drag, law.torque) for name in names]
    return by_region or [smooth_friction] * 2


def ends_of(law: Any, names: Sequence[str]) -> tuple[Event, ...]:
    """Return the events that end sliding in these regions: RESTS, and the borders of each region.

    There is one region for each contact; without regions (`names` empty) there are no such events.
    """
    ways = [
        border(way, side) for side, name in enumerate(names) for way in law.regions[name].borders
    ]
    return (RESTS, *ways) if names else ()


def slip_under(law: Any, *names: str, lies: tuple[str, ...] = AXIS) -> Phase:
    """Return the phase in which one ball slides under a law, in a region if it has some."""
    friction, *_ = frictions_of(law, names)
    pushed = lambda x, v, b: sliding(x, friction, v, b)  # noqa: E731
    return with_slip((LIFTOFF, TOUCH, *ends_of(law, names)), pushed, lies)


def regions_of(x: Moving, *bodies: Touch) -> tuple[str, ...]:
    """Return the region in which each ball slides; `bodies` are b for each of them.

    Under a law without regions the result is empty.
    """
    return tuple(
        region_of(speeds(contact_velocity(x, b), angular_velocity(x, b), b), b)
        for b in bodies
        if b.friction.regions
    )


def region_of(s: Any, b: Touch) -> str:
    """Return the name of the region of the law for these `Speeds`.

    It is the first, by rising x = |v|/U, whose end is not reached: the order of `law.regions`. It
    is "" if a speed is not finite, a name that under such a law no phase and no stage of an impact
    has. A border with direction < 0 is not such an end: it leads back to a smaller x, or is "slow".
    """
    for name, region in b.friction.regions.items():
        if all(way.direction < 0 or way.beyond(s, b) < 0 for way in region.borders):
            return name
    return ""


# --- a disc at rest, which rolls without turning ------------------------------------------------


GIVES = Event(
    "gives",
    "friction can no longer hold the contact's disc: it slides and turns",
    lambda s, b: margin(s.by.force, s.by.torque.z, b.friction),
    -1,
    "gives",
    sampled=True,  # `margin` compares numbers and iterates: it has no Taylor series
)
REST = without_slip((LIFTOFF, TOUCH, GIVES))


# --- on both balls --------------------------------------------------------------------------------


# On both balls the axis keeps its angle, and each ball slides, or both roll, and carries its share.
# The motion is that of a body on its first ball, the sphere, which feels the force of both and the
# torque of the other about the sphere's contact point. Two conditions, that theta and the height
# stay, give the two normal forces, whatever each contact does per normal force.


def shared(x, v, frictions, total, swing, b):
    """Return force and torque of both balls at the sphere's contact, and `Acts` of each.

    Parameters
    ----------
    x, v
        The motion, and the velocity of the sphere's contact point.
    frictions
        friction(omega, v, z, b) of each ball, per normal force: the vertical part of a force is 1.
    total, swing
        The sum of the normal forces, and (L' x 3hat)_z; or the same of impulses.
    b
        The body seen from the sphere.
    """
    u = x.u
    omega = angular_velocity(x, b)
    other = seen_from_other(b)
    apart = minus(arm(u, other), arm(u, b))
    slips = v, plus(v, cross(omega, apart))

    def side(friction, slip, ball):
        """Return the `Acts` of one ball per normal force, and what it adds to (L' x 3hat)_z."""
        force, torque = friction(omega, slip, u.z, ball)
        lean = cross(plus(cross(arm(u, ball), force), torque), u).z
        return Acts(force, torque, slip, omega), lean

    (one, lean), (two, other_lean) = map(side, frictions, slips, (b, other))
    # the stem carries N, the sphere total - N: (total - N) lean + N other_lean = swing
    N = (swing - total * lean) / (other_lean - lean)
    one, two = (
        by._replace(force=times(load, by.force), torque=times(load, by.torque))
        for load, by in ((total - N, one), (N, two))
    )
    torque = plus(plus(one.torque, two.torque), cross(apart, two.force))
    return plus(one.force, two.force), torque, one, two


def leaving(side: int, name: str, other: str) -> Event:
    """Return the event in which one of two balls leaves the plane: its normal force vanishes.

    `exits.JUMPS` has the names of the events, and `exits.stay_on` decides what follows.
    """
    text = f"the {name} leaves the plane, the {other} stays"
    return ending(f"{name}-leaves", text, lambda s, b: s.sides[side].force.z)


LEAVES = leaving(0, "sphere", "stem"), leaving(1, "stem", "sphere")


# --- sliding on both ------------------------------------------------------------------------------


def slide_on_both(law: Any, *names: str) -> Phase:
    """Return the phase in which sphere and stem slide under a law.

    `names` are the regions of the law in which they slide, one each; none for a law without
    regions. theta is constant, as both touch.
    """
    frictions = frictions_of(law, names)

    def pushed(x, v, b):
        """Return force and torque of both balls, and the actions on each: `pushed` of `with_slip`.

        The axis keeps its inclination, z'' = 0.
        """
        # z'' = (L x 3hat)_z'/I1 = 0, so (L' x 3hat)_z = -(L x 3hat')_z, and air has its part of it
        swing = -cross(x.L, contact.axis_rate(x, b)).z
        swing = swing - cross(around_torque(x, b), x.u).z
        return shared(x, v, frictions, b.m * b.g, swing, b)

    return replace(with_slip((*LEAVES, *ends_of(law, names)), pushed), axis_stays=True)


# --- rolling on both, as a cone does ------------------------------------------------------------


def rolled(x, b):
    """Return force and torque (3,) on a body that rolls on both balls, and the `Acts` of each.

    x is a `Turning`. The body turns about the line through both contacts, and that line about the
    vertical. It does not matter here how the two share the horizontal force.
    """
    u = x.u
    u_dot = contact.axis_rate(x, b)
    omega = angular_velocity(x, b)
    still = times(0, x.u)
    velocity = centre_velocity(x, still, b)
    turn = Vector(0, 0, cross(u, u_dot).z / horizontal2(u))
    moves = dot(omega, x.L) + b.m * dot(velocity, velocity)  # twice the energy
    share = 1 / (moves + b.I1 * STOPS_ROLLING**2)
    rolls = rolling(omega, b.friction)
    slows = b.m * b.g * dot(rolls, omega) * share

    def rate(a):
        """Return the rate of a vector that turns about the vertical and slows with the body."""
        return plus(times(slows, a), cross(turn, a))

    L_dot = pushed = rate(x.L)
    V_dot = rate(velocity)
    if b.around:
        pushed, V_dot = pushed_on_both(Moving(u, x.L, velocity, 0 * u.z), L_dot, V_dot, b)
    # per normal force: m V_dot and the rolling torque are shared as m g is
    acts = times(1 / b.g, V_dot)._replace(z=1), times(moves * share, rolls)
    frictions = [lambda *of: acts] * 2
    swing = cross(pushed, u).z
    _, _, *sides = shared(x, still, frictions, b.m * b.g, swing, b)
    force = times(b.m, V_dot)._replace(z=b.m * b.g + 0 * slows)
    return force, minus(pushed, cross(arm(u, b), force)), *sides


def pushed_on_both(x, L_dot, V_dot, b):
    """Return the parts of L' and s'' that are due to the contacts of a body that rolls on both.

    L_dot, V_dot are L' and s'' of the same body without surroundings, whose torque and push act
    along its only degree of freedom.
    """
    torque = around_torque(x, b)
    push = pushing(x.velocity, 0 * x.u.z, b)
    level = x.u._replace(z=0 * x.u.z)
    n = times(1 / sqrt(horizontal2(level)), level)
    one = Turning(x.u, momentum_of(n, x.u, b))
    velocity = centre_velocity(one, times(0, n), b)
    gives = dot(torque, n) + b.m * dot(push, velocity)
    rate = gives / (dot(n, one.L) + b.m * dot(velocity, velocity))
    return (
        minus(plus(L_dot, times(rate, one.L)), torque),
        minus(plus(V_dot, times(rate, velocity)), push),
    )


ROLLS_ON_BOTH = replace(without_slip(LEAVES, rolled), axis_stays=True)


# --- the phases under a law ---------------------------------------------------------------------


PHASES = ("slip", "roll", "flight", "both", "rest")
"""Labels of phases; the position of a label is its number in a store."""


def phases_under(law: Any, lies: tuple[str, ...], surrounded: bool) -> dict[tuple[str, ...], Phase]:
    """Return the phases under a law: {("slip",): Phase, ...}, by label and regions.

    `phase_name` makes names of these keys, here and in the jumps of `exits`, which must find them.

    Parameters
    ----------
    law
        The friction law, as the type of its record.
    lies
        Names of the variables of the orientation, AXIS or FRAME.
    surrounded
        Whether air or plane act in flight too.
    """
    flies = flight(lies, surrounded)
    if law.set_valued:
        roll = without_slip((LIFTOFF, TOUCH, CONE), lies=lies)
        return {("slip",): coulomb_slip(lies), ("roll",): roll, ("flight",): flies}
    if not law.regions:
        # SLIP, with fewer products, has no torques, no surroundings and no Frame
        general = law.torque or surrounded or lies is not AXIS
        slip = slip_under(law, lies=lies) if general else SLIP
        return {("slip",): slip, ("flight",): flies, ("both",): slide_on_both(law)}
    return {
        **{("slip", name): slip_under(law, name) for name in law.regions},
        ("flight",): flies,
        ("both", "roll"): ROLLS_ON_BOTH,
        **{
            ("both", *names): slide_on_both(law, *names) for names in product(law.regions, repeat=2)
        },
        ("rest",): REST,
    }


# --- what brings a body onto both ---------------------------------------------------------------


def without_slip_on_both(x: Moving, b: Touch) -> Moving:
    """Return the common state after impulses have stopped sliding and turning on both balls.

    What remains is the turning about the line through both contacts, as in `rolled`.
    """
    along = x.u._replace(z=0 * x.u.z)
    omega = times(dot(angular_velocity(x, b), along) / dot(along, along), along)
    L = momentum_of(omega, x.u, b)
    velocity = centre_velocity(Turning(x.u, L), times(0, L), b)
    p = times(b.m, minus(velocity, x.velocity))
    return kicked(x, b, p, minus(minus(L, x.L), cross(arm(x.u, b), p)))


def brought_to_rest(x: Moving, frictions: Sequence[Callable], b: Touch) -> Moving:
    """Return the common state after impulses have stopped theta' and the vertical velocity.

    They replace the infinitely many ever smaller hops from one ball to the other. `frictions` are
    those of `frictions_of`. On both balls there is no gap: the energy of what is left of it is
    counted as work.
    """
    v = contact_velocity(x, b)
    # total and swing of `shared`, as impulses, after which s_z' and (L x 3hat)_z are zero
    sinks = -(b.m * x.velocity.z)
    p, twist, *_ = shared(x, v, frictions, sinks, -cross(x.L, x.u).z, b)
    return gained(kicked(x, b, p, twist), work=b.m * mean_gravity(b) * contact.gap(x, b))
