"""Tops whose contact may change its phase: each of many is the one that a scenario of its own would
be.
"""

import numpy as np
import pytest

from tippetop.ensembles import ensemble, hybrid_tops
from tippetop.problem import Problem
from tippetop.scenario import build, reading
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.sweep_summary import faults_of


def standing_at(theta: float) -> Problem:
    return build.problem(
        reading.override(reading.read("leine-glocker-stem"), [f"initial.theta={theta!r}"])
    )


@pytest.mark.parametrize("theta", [0.1, 3.0])
def test_a_top_that_varies_stands_on_its_sphere_or_its_stem_as_it_would_alone(theta: float) -> None:
    """That of the sphere, where no gap was given, put the stems of others under the plane: they
    were invalid.
    """
    thetas = np.array([0.2, 2.0, 2.6, 3.1])
    tops = ensemble.vary(standing_at(theta), {"initial.theta": thetas})
    for top, one in enumerate(thetas.tolist()):
        alone = hybrid_tops.problem_of(tops, top)
        assert alone.initial == standing_at(one).initial
        assert not hybrid_tops.faults_of(alone)


def test_info_says_why_a_contact_cannot_be_followed() -> None:
    document = {
        "scenario": "leine-glocker-stem",
        "axis": [{"of": "friction.mu", "values": [0.3, 5.0]}],
    }
    (sentence,) = faults_of(Plan.from_tables(document), np.array([1]))
    assert sentence.startswith("top 1: `friction.mu` must be less than 1.3")
