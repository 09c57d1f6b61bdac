"""A clock that is free has a best fit in every period of an oscillation: all that are nearly as
good are found.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from tippetop.exchange.misfit import Misfit
from tippetop.exchange.observation import OFFSET
from tippetop.exchange.periods import walk
from tippetop.exchange.scales import Scale, Space
from tippetop.exchange.search import Minimum, local_minimum


RATE = 60.0  # of the oscillation
T = np.linspace(0, 2, 240)


def misfit(drift: float) -> Misfit:
    """An oscillation, and a drift whose start is free as well, of a clock whose true time is 0."""
    random = np.random.default_rng(3)
    seen = 0.1 * np.cos(RATE * T) + drift * T**2 + 0.01 * random.standard_normal(len(T))

    def predictions(points: dict, rows: slice = slice(None)) -> dict:
        t = T[rows] + points[OFFSET].reshape(-1, 1)
        shown = points["b"].reshape(-1, 1) + 0.1 * np.cos(RATE * t) + drift * t**2
        return {"theta": (seen[rows] - shown)[:, :, None]}

    groups = {"theta": seen[:, None]}
    observation = SimpleNamespace(
        t=T,
        reach=T[-1] / 8,
        groups=groups,
        given={"theta": np.isfinite(groups["theta"])},
        predictions=predictions,
    )
    line = Scale(False, 1.0, -np.inf, np.inf)
    return Misfit(observation, Space({OFFSET: 0.0, "b": 0.0}, [line, line]), "linear")  # type: ignore[arg-type]


def valleys(drift: float, begin: float) -> tuple[Minimum, list[Minimum]]:
    """Return the deepest valley, which must be at zero, and the others."""
    left = misfit(drift)
    best, *others = walk(left, local_minimum(left, np.array([begin, 0.0]), len(T)), 0)
    assert best.point[0] == pytest.approx(0, abs=0.02 * 2 * np.pi / RATE)
    return best, others


@pytest.mark.parametrize("begin", [0.0, 2 * np.pi / RATE])
def test_the_deepest_valley_is_found_from_another_and_those_nearly_as_deep_are_named(
    begin: float,
) -> None:
    """The drift changes by 2 x 0.01 x 2 in 10 s of an offset: valleys beside are worse
    by little.
    """
    best, others = valleys(0.01, begin)
    beside = sorted(other.point[0] * RATE / (2 * np.pi) for other in others)
    assert len(beside) > 2
    np.testing.assert_allclose(beside, np.round(beside), atol=0.1)
    assert {-1, 1} <= set(np.round(beside))
    assert all(other.cost > best.cost for other in others)


def test_of_periods_that_are_all_alike_the_nearest_is_taken() -> None:
    """A motion that is periodic: costs differ by rounding."""
    _, others = valleys(0.0, 0.0)
    assert len(others) > 20
