"""Bodies of every kind on planes of every kind, in air or not: against Newton and Euler in space,
and closed forms.
"""

from typing import Any

import numpy as np
import pytest
import tilted
from examples import CANONICAL
from limits import assert_below, assert_near
from nightly import at_night
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation
from touching import STANDING

import tippetop as tt


QUIET = {"progress": False}


KINDS = (tt.TippeTop, tt.HeavyTop, tt.Spheroid, tt.Disc, tt.Ellipsoid)
PLANES = ("level", "tilted", "vibrating", "turning")


def random_top(rng: np.random.Generator, kind: Any) -> Any:
    """Return a body of some centimetres."""
    m, R = 0.02, rng.uniform(0.01, 0.03)
    I3 = m * R**2 * rng.uniform(0.3, 0.6)
    I1 = I3 * rng.uniform(0.7, 1.3)
    c = R * rng.uniform(0.1, 0.3)
    a, b = R * rng.uniform(0.8, 1.5, 2)
    shape: dict[str, float] = {
        "TippeTop": {"alpha": c / R, "R": R},
        "HeavyTop": {"l": R},
        "Spheroid": dict(a=a, b=b, c=c),
        "Disc": dict(ring=R, tube=0.2 * R, c=c / 2),
        "Ellipsoid": dict(a=a, b=b, c=R, delta=a / b, x=c / 2, y=-c / 2, h=c, I2=(I1 + I3) / 2),
    }[kind.__name__]
    return kind(m=m, I1=I1, I3=I3, g=9.81, **shape)


def random_surroundings(rng: np.random.Generator, plane: str) -> dict[str, dict[str, float]]:
    """Return the tables [air] and [plane]."""
    if plane == "level":
        return {}
    air = {"c1": 8e-6 * rng.uniform(0, 1), "c2": 8e-6 * rng.uniform(0, 0.01)}
    if plane == "turning":
        return {"air": air, "plane": {"omega": rng.uniform(-20, 20), "x": 0.02, "y": -0.03}}
    tilted = {"tilt": rng.uniform(-0.2, 0.2), "azimuth": rng.uniform(0, 6)}
    if plane == "vibrating":
        tilted |= {"amplitude": 2e-4, "frequency": 30.0, "phase": rng.uniform(0, 6)}
    return {"air": air, "plane": tilted}


@pytest.mark.parametrize(
    "seed",
    [  # each kind and each plane, sliding and rolling, and all of that at night
        *(0, 12, 13, 4, 11, 28, 27, 39, 30, 17),
        *(at_night(seed) for seed in range(40, 400)),
    ],
)
def test_a_random_body_moves_as_newton_and_euler_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kind, plane, rolls = KINDS[seed % 5], PLANES[seed // 10 % 4], seed // 5 % 2 == 1
    top, around = random_top(rng, kind), random_surroundings(rng, plane)
    spins = (2, 8) if kind in (tt.Disc, tt.Ellipsoid) else (40, 90)
    start = {
        "theta": rng.uniform(0.4, 0.9),
        "theta_dot": rng.uniform(-2, 2),
        "phi": rng.uniform(-3, 3),
        "phi_dot": rng.uniform(-5, 5),
        "omega3": rng.uniform(*spins) * rng.choice([-1, 1]),
        "psi": rng.uniform(-3, 3),
    }
    options: dict[str, Any] = {"until": 0.05, "output_step": 0.025, "start": start, **around}
    law, force = None, tilted.rolling
    if kind is tt.HeavyTop or not rolls:
        law = tt.friction.Coulomb(mu=0.3, eps=0.05)
        force = tilted.sliding(lambda v: 0.3 / np.sqrt(v * v + 0.05**2))
        start |= {"nu_x": rng.uniform(-0.2, 0.2), "nu_y": rng.uniform(-0.2, 0.2)}
    elif kind is tt.TippeTop:
        options["system"] = top.resting
    run = tt.run(top, law, **options, **QUIET)
    known = {"energy_balance", "energy", *(["jellett"] if kind is tt.TippeTop else [])}
    assert_below(1e-13, {name: run.drift[name] for name in known & {*run.drift}})
    rows, body = run.trajectory, tilted.body_of(top, **around)
    leaves = tilted.must_pull(rows.isel(time=0), body, force)
    if "phase" in rows:
        assert (rows.phase[0] == 2) == leaves  # it flies until it lands
        rows = rows.sel(time=slice(float(run.phases.end[0])))
        force = tilted.flying if leaves else force
    elif leaves:
        assert "the body lifts off at the start" in run.summary.reason
        return
    assert rows.time[-1] >= 0.025  # a heavy top may have fallen before
    tilted.assert_moves(rows, body, force, 1e-10)


TOP = tt.TippeTop(**CANONICAL)
EGGLIKE = tt.Ellipsoid(
    m=0.05, a=0.025, b=0.02, c=0.018, delta=0.5, x=1e-3, y=-1e-3, h=3e-3, I1=7e-6, I2=8e-6, I3=9e-6,
    g=9.81,
)  # fmt: skip


AROUND: dict[str, Any] = {
    "air": {"c1": 2e-8, "c2": 1e-10},
    "plane": {"tilt": 0.1, "azimuth": 0.7},
}


MOVING: dict[str, dict[str, Any]] = {
    "level": {},
    "tilted": AROUND,
    "vibrating": AROUND
    | {"plane": {"tilt": 0.1, "azimuth": 0.7, "amplitude": 3e-4, "frequency": 20, "phase": 1.0}},
    "turning": {"air": AROUND["air"], "plane": {"omega": 8.0, "x": 0.05, "y": 0.02}},
}


every_plane = pytest.mark.parametrize("around", MOVING.values(), ids=MOVING)
every_body = pytest.mark.parametrize("top", [TOP, EGGLIKE], ids=lambda top: type(top).__name__)


@every_plane
@every_body
def test_a_body_flies_and_bounces_as_newton_and_euler_say(top: Any, around: dict[str, Any]) -> None:
    until, e_n = 0.052, 0.4
    start = dict(theta=0.6, theta_dot=3.0, omega3=60.0, gap=0.004, nu_x=0.1, phi_dot=4.0)
    options = {"contact": {"restitution": "newton", "e_n": e_n}, "output_step": until}
    law = tt.friction.Viscous(mu=0.8)
    run = tt.run(top, law, start=start, until=until, **options, **around, **QUIET)
    assert_below(1e-13, run.drift)
    b = tilted.body_of(top, **around)
    first = tilted.state_of(run.trajectory.isel(time=0), b)
    landings, end = tilted.bounced(b, first, lambda v: 0.8, e_n, until)
    assert len(landings) >= (2 if top is TOP else 1)
    assert_near(run.impacts.time, landings, 1e-10)
    tilted.assert_motion(run.trajectory.isel(time=-1), b, end, 1e-8)


@pytest.mark.parametrize(
    ("top", "around"),
    [
        (TOP, MOVING["turning"]),
        (EGGLIKE, MOVING["vibrating"]),
        *map(at_night, (TOP, EGGLIKE) * 4, [around for around in MOVING.values() for _ in "ab"]),
    ],
)
def test_a_body_slides_and_sticks_as_newton_and_euler_say(top: Any, around: dict[str, Any]) -> None:
    start, until = dict(theta=0.4, omega3=20.0, nu_x=0.04, nu_y=0.02), 0.06
    law, options = tt.friction.Coulomb(mu=0.3), {"until": until, "output_step": until}
    run = tt.run(top, law, start=start, **options, **around, **QUIET)
    assert run.drift["energy_balance"] < 1e-13
    assert run.phases.phase.values.tolist() == [0, 1]
    b = tilted.body_of(top, **around)
    first = tilted.state_of(run.trajectory.isel(time=0), b)
    stops, end = tilted.sticking(b, first, 0.3, until)
    assert float(run.phases.start[1]) == pytest.approx(stops, abs=1e-11)
    tilted.assert_motion(run.trajectory.isel(time=-1), b, end, 1e-9)


def test_a_fast_vibration_leaves_the_steps_as_they_are() -> None:
    """A variable that grows with time would lengthen them, and the balance drift."""
    run = tt.run("rolling", plane={"amplitude": 1e-7, "frequency": 900.0})
    assert run.drift["energy_balance"] < 1e-13


# --- closed forms -------------------------------------------------------------------------------


def test_a_uniform_ball_on_a_turntable_circles_at_two_sevenths_of_its_speed() -> None:
    omega = 5.0
    run = tt.run(
        tt.Spheroid(m=0.05, a=0.02, b=0.02),
        system="rolling-spheroid",
        plane={"omega": omega, "x": 0.03, "y": -0.01},
        start={"theta": 0.4, "omega3": 0.0, "phi_dot": 1.0, "x": 0.1},
        until=3.0,
        **QUIET,
    )
    rows = run.trajectory
    at_rest = (rows.x + 1j * rows.y - 0.03 + 0.01j).values * np.exp(1j * omega * rows.time.values)
    rate = 2 / 7 * omega
    known = np.stack([np.ones(len(at_rest)), np.exp(1j * rate * rows.time.values)], axis=1)
    circle, *_ = np.linalg.lstsq(known, at_rest)
    assert abs(at_rest - known @ circle).max() < 1e-12
    assert abs(circle[1]) > 0.05


def test_an_upright_spin_decays_in_air_by_its_closed_form() -> None:
    c1, c2, omega, until = 3e-7, 5e-9, 120.0, 3.0
    start = {"theta": 0.0, "omega3": omega}
    run = tt.run("inverting", start=start, air={"c1": c1, "c2": c2}, until=until, **QUIET)
    left = np.exp(-c1 * until / run.problem.parameters["I3"])
    expected = c1 * omega * left / (c1 + c2 * omega * (1 - left))
    assert np.isclose(run.trajectory.omega3[-1], expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("law", "around"),
    [
        ("viscous", AROUND),
        at_night("coulomb", AROUND),
        ("contensou", {"plane": {"omega": 1.0}}),
        at_night("contensou", MOVING["vibrating"]),
    ],
)
def test_a_body_on_both_balls_keeps_the_energy_balance(law: str, around: dict[str, Any]) -> None:
    friction = {"law": law, "mu": 0.3}
    if law == "contensou":
        friction |= {"patch": 5e-4, "mu_r": 1e-5, "mu_d": 1e-5}
    run = tt.run(
        {
            **STANDING,
            "friction": friction,
            "initial": {**STANDING["initial"], "nu_x": 0.0},
            **around,
        },
        **QUIET,
    )
    report = run.attributes["report"]
    assert report["drift"]["energy_balance"] < 1e-12  # as without: impacts
    if law != "coulomb":
        assert "both" in report["contact_phases"]["counts"]


R, r, h, c, I1, I3 = 0.015, 0.005, 0.013, -0.003, 8e-7, 7e-7  # of a peg


def peg_on_both(spin: float, around: dict[str, Any], until: float) -> tt.Run:
    """Run a peg that rolls on both balls with this angular velocity about the line through them."""
    z = (r - R) / h
    along = np.sqrt(1 - z * z)
    return tt.run(
        {
            "system": "tippe-top",
            "parameters": dict(m=0.006, R=R, alpha=c / R, I1=I1, I3=I3, g=9.81),
            "friction": {"law": "contensou", "mu": 0.5, "patch": 5e-4, "mu_r": 0.0},
            "stem": {"r": r, "h": h},
            "contact": {"e_n": 0.0},
            "initial": dict(theta=np.arccos(z), phi_dot=-spin * z / along, omega3=spin * along),
            "run": {"until": until, "output_step": 1e-3},
            **around,
        },
        **QUIET,
    )


@pytest.mark.parametrize(
    ("around", "spin"),
    [
        (AROUND, 1.0),
        (MOVING["vibrating"], 2.0),
        ({"plane": {"omega": 5.0, "x": 0.05, "y": -0.02}}, 0.0),
    ],
    ids=["tilted", "vibrating", "turning"],
)
def test_a_peg_that_rolls_on_both_balls_slips_at_neither_contact(
    around: dict[str, Any], spin: float
) -> None:
    run = peg_on_both(spin, around, until=0.1)
    rows = run.trajectory
    assert run.attributes["report"]["contact_phases"]["counts"].keys() == {"both"}
    assert run.drift["energy_balance"] < 1e-13
    Q = Rotation.from_quat(np.roll(rows.orientation.values, -1, axis=1)).as_matrix()
    u = Q[:, :, 2]
    omega = np.einsum("nij,j,nkj,nk->ni", Q, 1 / np.array([I1, I1, I3]), Q, rows.L.values)
    velocity = make_interp_spline(rows.time, np.stack([rows.x, rows.y, 0 * rows.x], axis=1), 5)
    velocity = velocity.derivative()(rows.time)
    speed = abs(velocity).max()
    assert speed > 0.01
    for centre, radius in ((c, R), (c + h, r)):
        slips = velocity + np.cross(omega, centre * u - radius * np.eye(3)[2])
        assert abs(slips[5:-5]).max() < 1e-9 * speed
    assert abs(np.cross(omega, h * u - (r - R) * np.eye(3)[2])).max() < 1e-14


@pytest.mark.parametrize("around", [{}, MOVING["tilted"]], ids=["level", "tilted"])
def test_a_ball_that_would_pull_the_plane_leaves_it_for_good(around: dict[str, Any]) -> None:
    run = peg_on_both(10.0, around, until=0.01)
    assert run.summary.status == "finished"
    assert run.phases.phase.values.tolist() == [3, 3, 4]  # both, and at rest on the sphere
    assert run.drift["energy_balance"] < 1e-13
    assert (np.diff(run.trajectory.gap_stem) > 0).all()


def test_a_ball_that_leaves_and_comes_back_at_once_ends_the_run_in_a_sentence() -> None:
    run = peg_on_both(0.0, {"plane": {"omega": 8.0, "x": 0.05, "y": 0.02}}, until=1e-6)
    assert "the model has no solution" in run.summary.reason
