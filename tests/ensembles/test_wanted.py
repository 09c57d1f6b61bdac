"""What nobody reads is not looked for; what somebody reads has the same bits, whatever else is
kept.
"""

from dataclasses import replace

import numpy as np
import pytest

from tippetop.ensembles import ensemble
from tippetop.ensembles.outcomes import Outcomes
from tippetop.problem import Problems
from tippetop.runs import starting


TOPS = 10


@pytest.fixture(scope="module")
def tops() -> Problems:
    """Tops of every fate: some invert, some lift off, some stay."""
    rng = np.random.default_rng(20261121)
    base = replace(starting.load("inverting", None, None), orientation=False)
    numbers = {
        "initial.omega3": rng.uniform(20, 330, TOPS),
        "initial.theta": rng.uniform(0.01, 3.0, TOPS),
    }
    return ensemble.vary(base, numbers)


@pytest.fixture(scope="module")
def everything(tops: Problems) -> Outcomes:
    return ensemble.measure(tops, threads=1)


@pytest.mark.parametrize(
    "wanted",
    [
        ["class"],
        ["class", "inverted_at"],
        ["turnings"],
        ["theta_max", "drift"],
        ["normal_force_min"],
        ["equators"],
    ],
)
def test_what_is_wanted_has_the_bits_that_it_has_among_all(
    wanted: list[str], tops: Problems, everything: Outcomes
) -> None:
    some = ensemble.measure(tops, threads=1, wanted=wanted)
    np.testing.assert_array_equal(some.status, everything.status)
    np.testing.assert_array_equal(some.kind, everything.kind)
    np.testing.assert_array_equal(some.final, everything.final)
    for name in wanted:
        if name in everything.columns:
            np.testing.assert_array_equal(
                some.columns[name], everything.columns[name], err_msg=name
            )
        for drift in everything.drift if name == "drift" else ():
            np.testing.assert_array_equal(some.drift[drift], everything.drift[drift], err_msg=drift)
    assert len(np.unique(everything.kind)) > 1


def test_turnings_are_looked_for_only_where_they_are_wanted(
    tops: Problems, everything: Outcomes
) -> None:
    """Else the test above would hold of a `wanted` that does nothing."""
    some = ensemble.measure(tops, threads=1, wanted=["class"])
    assert np.all(some.columns["turnings"] == 0)
    assert np.any(everything.columns["turnings"] > 0)
