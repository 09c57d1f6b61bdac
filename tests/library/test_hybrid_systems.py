"""Systems of several phases that users write: the page about them, against closed forms."""

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tippetop as tt
from tippetop.mechanics.form import Exit
from tippetop.mechanics.systems import SYSTEMS


PAGE = Path(__file__).parents[2] / "docs/how-to/a-hybrid-system.md"


@pytest.fixture(scope="module")
def page() -> Iterator[dict[str, Any]]:
    """What the Python of the page defines."""
    names: dict[str, Any] = {}
    known = set(SYSTEMS)
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL):
        exec(block, names)
    yield names
    for name in set(SYSTEMS) - known:
        del SYSTEMS[name]


def times(run: Any, kind: str) -> np.ndarray:
    kinds = run.events.kind.attrs["flag_meanings"].split()
    return run.events.time.values[run.events.kind.values == kinds.index(kind)]


def bounces(**run: Any) -> Any:
    tables = {"system": "bouncing-point", "parameters": {"m": 2.0, "g": 9.81, "e": 0.5}, "initial": {"h": 1.0}}
    return tt.run(tables, until=3.0, **run)


@pytest.mark.parametrize(("precision", "bound"), [("double", 1e-13), ("longdouble", 1e-15)])
def test_a_point_bounces_when_it_must(page: dict, precision: str, bound: float) -> None:
    found = times(bounces(precision=precision), "bounce")
    hops = 2 * np.sqrt(2 / 9.81) * 0.5 ** np.arange(1, len(found))
    expected = np.sqrt(2 / 9.81) + np.concatenate([[0.0], np.cumsum(hops)])
    assert len(found) >= 9
    np.testing.assert_allclose(found, expected, rtol=0, atol=bound)


def test_rows_of_all_phases_are_states(page: dict) -> None:
    run = bounces(output_step=1e-3)
    height, rest = run.trajectory.h.values, times(run, "rests")[0]
    assert height.min() >= -1e-15
    assert (height[run.trajectory.time.values > rest] == 0).all()


def test_a_replay_continues_in_its_phase(page: dict, tmp_path: Path) -> None:
    run = bounces(output="keyframes", keyframe_steps=2, out=tmp_path / "run.zarr")
    rows, whole = run.replay(0.5, 1.5, 0.125), bounces(output_times=np.arange(0.5, 1.6, 0.125).tolist())
    np.testing.assert_array_equal(rows.h.values, whole.trajectory.h.values[: len(rows.time)])


def test_a_block_sticks_and_slips_with_its_period(page: dict) -> None:
    b = page["belt"]
    frequency, torn, middle = np.sqrt(b["k"]), b["sticks"] * b["g"] / b["k"], b["mu"] * b["g"] / b["k"]
    slipping = 2 * (np.pi - np.arctan2((torn - middle) * frequency, b["belt"])) / frequency
    period = slipping + 2 * (torn - middle) / b["belt"]
    slips, sticks = times(page["run"], "slips"), times(page["run"], "sticks")
    np.testing.assert_allclose(slips[0], torn / b["belt"], rtol=1e-14)
    np.testing.assert_allclose(np.diff(slips), period, rtol=1e-13)
    np.testing.assert_allclose(sticks - slips[: len(sticks)], slipping, rtol=1e-12)


def test_an_ensemble_of_them_is_refused_or_the_runs_of_each(page: dict) -> None:
    with pytest.raises(tt.InputError, match="`form` must be"):
        tt.ensemble({"system": "bouncing-point", "parameters": {"m": 1, "g": 9.81, "e": 0.5}, "initial": {"h": 1}},
                    {"parameters.e": [0.3, 0.6]}, until=1.0)  # fmt: skip


@pytest.mark.parametrize(
    ("way", "words"),
    [
        (Exit("ground", ("nowhere",), None), "must lead to phases of the system, but leads to 'nowhere'"),
        (Exit("sky", ("rest",), None), "sky"),
    ],
)
def test_an_exit_that_cannot_be_is_refused(page: dict, way: Exit, words: str) -> None:
    point = page["point"]
    phases = {**point.phases, "fall": dataclasses.replace(point.phases["fall"], exits=(way,))}
    with pytest.raises(tt.InputError, match=words):
        tt.extending.register(dataclasses.replace(point, name="broken-point", phases=phases))


def test_a_phase_that_changes_the_common_state_is_refused(page: dict) -> None:
    point, state = page["point"], page["State"]
    spoilt = dataclasses.replace(point.phases["rest"], leave=lambda q, b: state(q.h + 1, q.v))
    with pytest.raises(tt.InputError, match="must keep the common state"):
        tt.extending.register(dataclasses.replace(point, name="broken-point", phases={**point.phases, "rest": spoilt}))
