"""Phases and jumps of a body whose contact may open, against the laws of mechanics."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tippetop.engine.impacts import Impacts
from tippetop.mechanics.consistency import inconsistencies
from tippetop.mechanics.contact import exits
from tippetop.mechanics.contact.body import Touch, jellett_of, seen_from_balls
from tippetop.mechanics.contact.opening import opened
from tippetop.mechanics.contact.state import ROW, Moving, energy, row
from tippetop.mechanics.form import CLOCK
from tippetop.mechanics.friction import Contensou, SetValued, Viscous, named
from tippetop.mechanics.operand import Vector, dot, times
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.variables import Variables


BODY, STEM = Touch(1.0, 1.0, 0.2, 0.37, 0.35, 1.0, None), (1 / 3, 13 / 15)
LAWS_OF = {
    "tippe-top": (Viscous(1.3), SetValued(0.3), Contensou(0.3, 0.03, 1e-3)),
    "gliding-heavy-top": (Viscous(1.3), SetValued(0.3)),
    "gliding-cylinder": (Viscous(1.3), SetValued(0.3)),
}
CASES = [("tippe-top", law, balls) for law in LAWS_OF["tippe-top"] for balls in (1, 2)] + [
    (name, law, 1) for name in ("gliding-heavy-top", "gliding-cylinder") for law in LAWS_OF[name]
]


class World(SimpleNamespace):
    """What a driver gives to jumps."""

    def __init__(self, name: str, friction: Any, balls: int, e_n: float = 0.4):
        law = named(type(friction))
        self.system, self.left = opened(SYSTEMS[name], law, balls), np.inf
        self.body = seen_from_balls(BODY._replace(friction=friction), STEM if balls > 1 else ())
        self.phases, self.rules = (
            self.system.phases,
            SimpleNamespace(e_n=e_n, restitution="energetic"),
        )
        problem: Any = SimpleNamespace(contact=self.rules, system=SYSTEMS[name], precision="double")
        self.struck = Impacts(problem, friction).struck
        (form,) = self.system.forms.values()
        self.carried = Variables(form, False).carried
        self.nothing = self.carried(*(0.0,) * len(self.carried._fields))

    def rates(self, phase: Any, q: Any, carried: Any, b: Any = None) -> list:
        known = {integral.name: integral.rate for integral in phase.form.integrals}
        b = b or phase.parameters(self.body)
        return [known[name](q, carried, b) if name in known else 0.0 for name in carried._fields]


def state(world: World, seed: int, cosine: float | None = None, *, spin: float = 1.0) -> Moving:
    """A random state of a body on the plane."""
    random = np.random.default_rng(seed)
    z, phi = random.uniform(-0.9, 0.9) if cosine is None else cosine, random.uniform(0, 6)
    s = np.sqrt((1 - z) * (1 + z))
    L, velocity = (Vector(*spin * random.normal(size=3)) for _ in range(2))
    b = world.body[0]
    u = Vector(s * np.cos(phi), s * np.sin(phi), z)
    return Moving(u, L, velocity, b.R - b.c * z, world.nothing)


def without_slip(x: Moving, b: Touch) -> Moving:
    """The same, with a lowest point at rest."""
    velocity = exits.contact.centre_velocity(x.u, x.L, Vector(0.0, 0.0, 0.0), b)
    return x._replace(velocity=velocity)


def on_plane(x: Moving, b: Touch) -> Moving:
    """The same, with a lowest point that does not rise."""
    v = x.velocity
    return x._replace(velocity=v._replace(z=v.z - exits.point(x, b).z))


def conserved(world: World, ball: int, x: Moving) -> np.ndarray:
    """Energy and Jellett's integral, with what was taken of them."""
    phase, b = world.phases[exits.phase_name("flight", ball)], world.body[ball]
    q = row(phase, phase.enter(x, b), x.carried, world.body)
    E = energy(ROW.scalars(q, b), b) + x.carried.work
    lost = getattr(x.carried, "jellett_lost", 0.0)
    return np.array([E, jellett_of(x.L.z, dot(x.L, x.u), b) + lost])


@pytest.mark.parametrize(("name", "law", "balls"), CASES)
def test_records_of_an_opening_contact_are_consistent(name: str, law: Any, balls: int) -> None:
    system = opened(SYSTEMS[name], named(type(law)), balls)
    assert inconsistencies(system.replace(contact=None)) == []
    assert system is opened(SYSTEMS[name], named(type(law)), balls)
    for phase in system.phases.values():
        events = [event.name for event in phase.events if event.ends == event.name]
        assert [exit.event for exit in phase.exits if exit.event != CLOCK] == events


@pytest.mark.parametrize(("name", "law", "balls"), CASES)
def test_a_phase_keeps_the_common_state(name: str, law: Any, balls: int) -> None:
    world = World(name, law, balls)
    for seed, phase in enumerate(world.phases.values()):
        b = world.body[phase.ball]
        x = phase.leave(phase.enter(state(world, seed), b), b)
        again = phase.leave(phase.enter(x, b), b)
        for one, other in zip(x[:4], again[:4], strict=True):
            assert other == pytest.approx(one, abs=1e-15, rel=1e-14)


@pytest.mark.parametrize("law", LAWS_OF["tippe-top"])
@pytest.mark.parametrize("ball", [0, 1])
def test_an_impact_keeps_energy_and_the_jellett_integral_of_its_ball(law: Any, ball: int) -> None:
    world = World("tippe-top", law._replace(mu=0.3), 2)
    for seed in range(5):
        x = state(world, seed, (0.3, -0.9)[ball])
        x = x._replace(height=world.body[ball].R - world.body[ball].c * x.u.z)
        v_n = exits.point(x, world.body[ball]).z
        x = x._replace(velocity=x.velocity._replace(z=x.velocity.z - v_n - 0.5))
        n = exits.strike(x, world, ball, "landing")
        assert n.rows["impacts"][0].v_n_before == pytest.approx(-0.5)
        assert n.x.carried.work > 0
        assert conserved(world, ball, n.x) == pytest.approx(conserved(world, ball, x), abs=1e-13)


@pytest.mark.parametrize("law", LAWS_OF["tippe-top"])
def test_a_contact_begins_with_forces_that_its_law_allows(law: Any) -> None:
    """Complementarity: normal force, its cone, friction against the motion; or it opens."""
    world, found = World("tippe-top", law, 1), set()
    for seed in range(60):
        b, spin = world.body[0], 10.0 ** (seed % 3 - 1)
        x = on_plane(state(world, seed, spin=spin), b)
        if seed % 2:
            x = without_slip(x, b)
        if seed % 4 == 3 and isinstance(law, Contensou):
            x = exits.kicked(x, exits.stopping(x.u, x.L, x.velocity, b), b)
        n = exits.on_plane(x, world, 0, "start")
        phase, v = world.phases[n.phase], exits.point(n.x, b)
        found.add(phase.label)
        F = phase.reaction(phase.enter(n.x, b), b).force
        assert (F.z > 0) == (phase.label != "flight")
        assert F.x * v.x + F.y * v.y <= 1e-14
        if isinstance(law, SetValued) and F.z > 0:
            assert exits.size(F) <= law.mu * F.z * (1 + 1e-9)
            assert (exits.size(v) < 1e-12) == (phase.label == "roll")
    assert found == {phase.label for phase in world.phases.values()}


def test_a_flight_begins_where_the_force_vanishes_and_goes_on() -> None:
    world = World("tippe-top", Viscous(1.3), 1)
    x, world.phase = state(world, 1), world.phases["slip"]
    swing = exits.gap_rate(x, world.body[0], 3)
    n, back = (
        exits.lift_off(x._replace(L=times(k, x.L)), world)
        for k in (np.sign(swing), -np.sign(swing))
    )
    assert (n.phase, n.logged, n.zeros) == ("flight", ("liftoff",), {"land": 3})
    assert (back.ends, back.message) == ("stalled", exits.NO_WAY)


@pytest.mark.parametrize("seed", range(4))
def test_the_force_on_a_disc_is_continuous_where_it_gives_way(seed: int) -> None:
    """Friction is as strong as it must be to hold the disc, and no stronger."""
    x, low, high = (
        state(World("tippe-top", Contensou(1.0, 0.03, 0.0), 1), seed, spin=0.3),
        0.0,
        50.0,
    )
    for _ in range(60):
        mu = (low + high) / 2
        world = World("tippe-top", Contensou(mu, 0.03, 1e-3), 1)
        b, world.phase = world.body[0], world.phases["rest"]
        rests = exits.kicked(x, exits.stopping(x.u, x.L, x.velocity, b), b)
        s = world.phase.form.scalars(world.phase.enter(rests, b), b)
        low, high = (
            (low, mu) if exits.margin(s.by.force, s.by.torque.z, b.friction) > 0 else (mu, high)
        )
    n = exits.give_way(rests, world)
    slides = world.phases[n.phase]
    F = slides.reaction(slides.enter(n.x, b), b).force
    assert slides.label == "slip"
    assert pytest.approx(s.by.force, abs=2e-4 * s.force) == F
    assert (n.cause, n.logged) == ("gives", ("slip",))
