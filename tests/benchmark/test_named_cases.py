"""The references of the benchmark against closed forms, and their certificates."""

import math

import numpy as np
import pytest
from limits import assert_near
from refusals import refusal
from scipy.spatial.transform import Rotation

from tippetop import benchmark
from tippetop.benchmark.named_cases import data
from tippetop.benchmark.truth import Truth, truth
from tippetop.exchange.motion import theta_of


def motion(name: str, count: int = 201) -> tuple[Truth, object]:
    problem = benchmark.case(name).problem
    return truth(problem, np.linspace(0, problem.until, count))[0], problem.body()


def test_torque_free_axis_circles_the_angular_momentum():
    there, b = motion("torque-free")
    axes = Rotation.from_quat(there.quaternion, scalar_first=True).apply([0.0, 0.0, 1.0])
    spin = (there.omega * axes).sum(axis=1)
    L = b.I1 * there.omega + ((b.I3 - b.I1) * spin)[:, None] * axes
    L0, u0, t = L[0], axes[0], there.t
    n, rate = L0 / np.linalg.norm(L0), np.linalg.norm(L0) / b.I1
    along, across = n * (n @ u0), u0 - n * (n @ u0)
    expected = along + np.outer(np.cos(rate * t), across)
    expected += np.outer(np.sin(rate * t), np.cross(n, u0))
    assert_near(axes, expected, 1e-12)
    fall = there.position[0] + np.outer(t, there.velocity[0]) - np.outer(t**2, [0, 0, b.g / 2])
    assert_near(there.position, fall, 1e-14)


def test_slide_ends_in_rolling_at_the_time_of_the_closed_form():
    there, b = motion("slide-to-roll")
    mu, v = 0.3, 0.5
    end = v / (mu * b.g * (1 + b.m * b.R**2 / b.I1))
    slides = np.minimum(there.t, end)
    assert_near(there.velocity[:, 0], v - mu * b.g * slides, 1e-13)
    turn = mu * b.m * b.g * b.R / b.I1 * slides
    np.testing.assert_allclose(there.omega[:, 1], turn, rtol=1e-12)


def test_steady_precession_stays_steady():
    there, b = motion("steady-precession")
    rate, theta = 20.0, 0.5
    assert_near(theta_of(there.quaternion), theta, 1e-13)
    speed = np.linalg.norm(there.velocity, axis=1)
    np.testing.assert_allclose(speed, speed[0], rtol=1e-12)
    inward = b.m * rate * speed[0]
    np.testing.assert_allclose(np.linalg.norm(there.force[:, :2], axis=1), inward, rtol=1e-10)
    np.testing.assert_allclose(there.force[:, 2], b.m * b.g, rtol=1e-12)


def test_upright_spin_falls_linearly_and_ends():
    there, b = motion("drill-to-rest")
    rate = 3 * math.pi / 16 * 0.3 * b.m * b.g * 0.002 / b.I3
    expected = np.maximum(20.0 - rate * there.t, 0.0)
    assert_near(there.omega[:, 2], expected, 1e-6)
    assert (there.omega[there.t > 20.0 / rate + 1e-6, 2] == 0).all()


def test_bounces_end_after_three_times_the_fall():
    there, b = motion("bounce", 501)
    end = 3 * math.sqrt(2 * 0.05 / b.g)
    at_rest = there.t > end
    assert_near(there.position[at_rest, 2], b.R - b.c, 1e-14)
    assert there.position[there.t < end - 1e-3, 2].max() > b.R - b.c + 1e-3


def test_force_is_the_change_of_momentum():
    for name in ("joint", "coulomb-sticking", "frictionless-gliding"):
        problem = benchmark.case(name).problem
        there, _ = truth(problem, np.linspace(0.2, 0.21, 1001))
        body = problem.body()
        force = body.m * np.gradient(there.velocity, there.t, axis=0, edge_order=2)
        force[:, 2] += body.m * body.g
        assert_near(there.force, force, 3e-4, relative=True)


@pytest.mark.parametrize("name", benchmark.names())
def test_reference_is_certified(name):
    each = benchmark.case(name)
    assert each.certificate["error"] < 1e-10
    assert 0 < each.certificate["horizon"] <= each.problem.until


def test_certificates_are_of_the_cases():
    assert tuple(data("certificates.json")) == benchmark.names()


@pytest.mark.parametrize("name", benchmark.names())
def test_settings_name_the_restitution(name):
    each = benchmark.case(name)
    bounces = each.problem.contact is not None and each.problem.contact.e_n > 0
    assert all(("restitution" in words) == bounces for words in each.settings.values())


def test_unknown_case():
    with refusal("unknown case `bounces`"):
        benchmark.case("bounces")


def test_a_preset_is_a_case_if_its_contact_may_open():
    assert benchmark.case("cohen-coulomb").name == "cohen-coulomb"
    with refusal(r"`rattleback` must have a table \[contact\]"):
        benchmark.case("rattleback")
