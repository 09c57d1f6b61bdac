"""Which way the body is turned: psi and the quaternion; their rates are judged by the laws."""

import dataclasses

import examples
import numpy as np
import pytest
from limits import assert_near
from scipy.spatial.transform import Rotation

from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.run import solve


def load(preset: str, *settings: str) -> Problem:
    """A short run of a preset."""
    return starting.load(preset, list(settings), 0.6)


def matrices(columns: dict[str, np.ndarray]) -> np.ndarray:
    """The rotations of the column `orientation` as matrices, (n, 3, 3)."""
    return Rotation.from_quat(np.roll(columns["orientation"], -1, axis=1)).as_matrix()


@pytest.mark.parametrize("preset", ["gliding-cylinder", "rolling-cylinder"])
def test_a_cylinder_turns_about_the_horizontal(preset: str) -> None:
    columns = examples.columns(solve(load(preset)))
    assert "psi" not in columns
    assert_near(
        matrices(columns), Rotation.from_euler("y", columns["theta"][:, None]).as_matrix(), 1e-14
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
    assert_near(matrices(examples.columns(turned)), matrices(columns) @ twist, 1e-13)
