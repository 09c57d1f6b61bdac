"""The heavy tops: closed form, published numbers, the limit of the tippe top, and the upright
gliding top.
"""

import math
from typing import NamedTuple

import examples
import numpy as np
import pytest
from examples import HEAVY
from limits import assert_below, assert_near
from scipy.special import ellipj, ellipk

from tippetop.engine.status import Status
from tippetop.mechanics.systems import heavy_top
from tippetop.mechanics.theory import heavy_top_motion
from tippetop.runs.run import solve


class Swing(NamedTuple):
    """z(t) = z1 + (z2 - z1) sn^2(W t, k), since a maximum of theta."""

    z1: float
    z2: float
    W: float
    k2: float

    @property
    def period(self) -> float:
        return 2 * float(ellipk(self.k2)) / self.W

    def z(self, t: np.ndarray) -> np.ndarray:
        sn, *_ = ellipj(self.W * t, self.k2)
        return self.z1 + (self.z2 - self.z1) * sn**2


def closed(made) -> Swing:
    b, start = examples.si(made), examples.at_start(made)
    inertia, weight = heavy_top.tip_inertia(b), -b.m * b.g * b.c
    conserved = start["energy"], start["Lz"], start["L3"]
    z1, z2, z3 = heavy_top_motion.turning_heights(*conserved, inertia, b.I3, weight)
    W = math.sqrt(weight * (z3 - z1) / (2 * inertia))
    return Swing(z1, z2, W, (z2 - z1) / (z3 - z1))


@pytest.mark.parametrize("form", ["vector", "euler"])
@pytest.mark.parametrize(
    "initial",
    [
        {"theta": 0.6, "omega3": 200.0},  # cusps
        {"theta": 1.2, "phi_dot": -4.0, "omega3": 150.0},  # loops
        {"theta": 2.0, "phi_dot": 7.0, "omega3": 90.0},
        {"theta": 2.5, "phi_dot": 3.0, "omega3": 0.0},  # spherical pendulum
    ],
)
def test_closed_form(form: str, initial: dict[str, float]) -> None:
    """theta(t) is the elliptic function of the source, to 1e-12; all starts are turning points."""
    made = examples.problem("heavy-top", HEAVY, initial, 2.0, form=form)
    exact = closed(made)
    z0 = math.cos(initial["theta"])
    shift = 0.0 if abs(z0 - exact.z1) < abs(z0 - exact.z2) else exact.period / 2
    result = solve(made)
    z = exact.z(result.times + shift)
    assert np.abs(np.cos(examples.columns(result)["theta"]) - z).max() < 1e-12
    assert np.abs(examples.columns(result)["theta"] - np.arccos(z)).max() < 1e-12
    assert_below(2e-13, result.report["drift"])


def test_published_heavy_tops() -> None:
    """Joneja (2017), table 1, whose time 1 is 0.99999; and EXUDYN's benchmark."""
    m, R, l = 0.02, 0.02, 0.04
    pivot = 3 / 20 * m * (R**2 + l**2 / 4)
    joneja = {"m": m, "l": l, "I1": pivot - m * l**2, "I3": 0.3 * m * R**2, "g": 9.81}
    assert (
        joneja["I1"] < 0
    )  # the published cone is not a body of this tip: only the moment about the pivot enters
    exudyn = {"m": 15.0, "l": 1.0, "I1": 0.234375, "I3": 0.46875, "g": 9.81}
    made = examples.run(
        "heavy-top",
        exudyn,
        {"theta": math.pi / 2, "phi_dot": -4.61538, "omega3": 150.0},
        0.2,
        times=np.array([0.0, 0.2]),
    )
    rows = examples.columns(made)
    assert rows["theta"][-1] == pytest.approx(2.122316990777, abs=1e-11)
    assert rows["phi"][-1] == pytest.approx(-0.790871611821, abs=1e-11)
    start = {"theta": 0.1, "psi_dot": 125.0}
    rows = examples.columns(
        examples.run("heavy-top", joneja, start, 1.0, times=np.array([0.0, 0.99999, 1.0]))
    )
    assert_near(rows["theta"][1:], [0.239331610776, 0.239334535444], 1e-11)


A, HALF, WEIGHT = 2.4e-4 * math.cos(0.6), 5e-5 * 200.0 / 2, 0.1 * 9.82 * 0.04
SLOW = (HALF - math.sqrt(HALF**2 - A * WEIGHT)) / A
"""A root phi' of I1* phi'^2 cos(theta) - I3 omega_3 phi' + m g l = 0."""


@pytest.mark.parametrize(
    ("initial", "name"),
    [
        ({"theta": 0.6, "omega3": 200.0}, "nutation with cusps"),
        ({"theta": 0.6, "phi_dot": -5.0, "omega3": 200.0}, "nutation with loops"),
        ({"theta": 0.0, "omega3": 200.0}, "spinning"),
        ({"theta": 2.5, "phi_dot": 1.0}, "spherical pendulum"),
        ({"theta": math.pi}, "at rest"),
        ({"theta": 0.6, "phi_dot": SLOW, "omega3": 200.0}, "regular precession"),
    ],
)
def test_motions_have_names(initial: dict[str, float], name: str) -> None:
    made = examples.problem("heavy-top", HEAVY, initial, 1.0)
    b, start = examples.si(made), examples.at_start(made)
    arguments = heavy_top.tip_inertia(b), b.I3, -b.m * b.g * b.c
    found = heavy_top_motion.heavy_top_motion(start["energy"], start["Lz"], start["L3"], *arguments)
    assert found == name
    if "phi_dot" in initial and initial["phi_dot"] == SLOW:
        assert np.ptp(examples.columns(solve(made))["theta"]) < 1e-13


# --- the tippe top with R alpha = -l, R -> 0 ----------------------------------------------------


RADII = 1e-5 * 0.5 ** np.arange(4)


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_motions_of_the_tippe_top_tend_to_the_gliding_heavy_top() -> None:
    """theta(t) after half a second converges to first order in R."""
    start, until = {"theta": 0.4, "omega3": 300.0, "nu_x": 0.05, "nu_y": -0.02}, 0.5
    exact = examples.columns(
        examples.run("gliding-heavy-top", HEAVY, start, until, ("viscous", {"mu": 0.3}))
    )["theta"]
    errors = []
    for R in RADII:
        parameters = {"m": 0.1, "R": R, "alpha": -0.04 / R, "I1": 8e-5, "I3": 5e-5, "g": 9.82}
        made = examples.run(
            "tippe-top", parameters, start, until, ("viscous", {"mu": 0.3}), on_liftoff="continue"
        )
        errors.append(np.abs(examples.columns(made)["theta"] - exact).max())
    assert np.all(np.abs(orders(errors) - 1) < 0.05), errors


def test_the_fallen_top_stops_at_the_plane() -> None:
    made = examples.run(
        "gliding-heavy-top", HEAVY, {"theta": 0.4, "omega3": 10.0}, 4.0, ("viscous", {"mu": 0.3})
    )
    assert made.status is Status.FALLEN
    assert made.report["theta_end"] == pytest.approx(math.pi / 2, abs=1e-12)
    assert list(made.events.kind) == [2]
