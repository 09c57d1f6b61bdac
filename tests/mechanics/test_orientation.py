"""Which way the body is turned: psi and the quaternion, against an integration of their own and
against each other.
"""

import dataclasses
import math
from collections.abc import Callable

import examples
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from tippetop.engine.orientation import quaternion
from tippetop.mechanics.operand import Vector
from tippetop.mechanics.rotation import outer
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.run import solve


STEP = 2e-4


def load(preset: str, *settings: str, until: float = 0.6) -> Problem:
    """A preset with rows so dense that omega can be interpolated to rounding."""
    return starting.load(preset, [*settings, f"run.output_step={STEP}"], until)


def matrices(columns: dict[str, np.ndarray]) -> np.ndarray:
    """The rotations of the column `orientation` as matrices, (n, 3, 3)."""
    return Rotation.from_quat(np.roll(columns["orientation"], -1, axis=1)).as_matrix()


def omega(problem: Problem, columns: dict[str, np.ndarray]) -> Callable:
    """The angular velocity of a run as a function of time, by L and the axis alone."""
    b = problem.body()
    transverse = b.I1 + (
        b.m * b.c**2 if problem.system.name == "heavy-top" else 0.0
    )  # whose L is about the tip
    u, L = columns["axis"], columns["L"]
    along = np.sum(u * L, axis=1)[:, None] * u
    return make_interp_spline(columns["time"], (L - along) / transverse + along / b.I3, k=7)


WAYS = [
    ("inverting", ()),
    ("inverting", ("initial.theta=0.0", "initial.theta_dot=2.0")),
    ("inverting", ("initial.theta=3.141592653589793", "initial.theta_dot=2.0", "initial.psi=0.3")),
    ("rolling", ()),
    ("rolling", ("form=euler", "initial.psi=-2.0")),
    ("gliding-heavy-top", ("initial.psi=1.0",)),
    ("heavy-top", ("form=euler",)),
]


@pytest.mark.parametrize(("preset", "settings"), WAYS)
def test_the_body_turns_with_its_angular_velocity(preset: str, settings: tuple) -> None:
    """R' = omega x R, integrated by SciPy from the first row, gives the last one."""
    problem = load(preset, *settings, until=0.3)
    columns = examples.columns(solve(problem))
    R, w = matrices(columns), omega(problem, columns)
    end = columns["time"][-1]
    found = solve_ivp(
        lambda t, y: np.cross(w(t), y.reshape(3, 3), axisb=0, axisc=0).ravel(),
        (0.0, end),
        R[0].ravel(),
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    assert np.abs(found.y[:, -1].reshape(3, 3) - R[-1]).max() < 1e-9
    np.testing.assert_allclose(R[:, :, 2], columns["axis"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.sum(columns["orientation"] ** 2, axis=1), 1.0, rtol=0, atol=1e-15)
    assert (columns["orientation"][:, 0] >= 0).all()


@pytest.mark.parametrize("preset", ["gliding-cylinder", "rolling-cylinder"])
def test_a_cylinder_turns_about_the_horizontal(preset: str) -> None:
    columns = examples.columns(solve(load(preset)))
    assert "psi" not in columns
    np.testing.assert_allclose(
        matrices(columns),
        Rotation.from_euler("y", columns["theta"][:, None]).as_matrix(),
        rtol=0,
        atol=1e-14,
    )


@pytest.mark.parametrize("preset", ["inverting", "rolling", "gliding-heavy-top", "heavy-top"])
def test_the_orientation_has_no_effect_on_the_run(preset: str) -> None:
    """Left out or turned by psi: the same steps and the same bits of all other columns
    and events.
    """
    problem = load(preset)
    runs = [solve(p) for p in (problem, dataclasses.replace(problem, orientation=False))]
    turned = solve(load(preset, "initial.psi=2.5"))
    columns, plain = (examples.columns(run) for run in runs)
    assert columns.keys() - plain.keys() == {"psi", "orientation"}
    for name, values in plain.items():
        assert values.tobytes() == columns[name].tobytes(), name
        assert values.tobytes() == examples.columns(turned)[name].tobytes(), name
    for name in ("time", "kind", "theta", "significant"):
        assert getattr(runs[0].events, name).tobytes() == getattr(runs[1].events, name).tobytes()
    assert runs[0].report["steps"] == runs[1].report["steps"]
    twist = Rotation.from_rotvec([0.0, 0.0, 2.5]).as_matrix()
    np.testing.assert_allclose(
        matrices(examples.columns(turned)), matrices(columns) @ twist, rtol=0, atol=1e-13
    )


def test_quaternions_of_rotations(rng: np.random.Generator) -> None:
    """As SciPy gives them, up to the sign; half turns too, where w = 0."""
    turns = Rotation.concatenate(
        [
            Rotation.random(1000, random_state=rng),
            Rotation.from_rotvec(math.pi * np.eye(3)),
            Rotation.identity(1),
        ]
    )
    R = turns.as_matrix()
    found = quaternion(outer(Vector(*R[:, :, 0].T), Vector(*R[:, :, 2].T))).T
    expected = np.roll(turns.as_quat(), 1, axis=1)
    assert np.abs(np.abs(np.sum(found * expected, axis=1)) - 1).max() < 1e-15
    assert (found[:, 0] >= 0).all()
    assert Rotation.from_quat(np.roll(found, -1, axis=1)).approx_equal(turns, atol=1e-14).all()
