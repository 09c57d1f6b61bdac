"""The regularised law of Coulomb tends to the law itself, with the orders of theory."""

import numpy as np
from examples import CANONICAL
from touching import ROLLS_THEN_SLIDES, ROLLS_THEN_SLIDES_MU

from tippetop.runs.run import solve
from tippetop.scenario.build import problem


def theta(mu, start, times, eps=None):
    """theta at these times, of Coulomb's law itself or regularised over the speed eps."""
    friction = {"law": "coulomb", "mu": mu} | ({} if eps is None else {"eps": eps})
    run = {"until": times[-1], "output_times": times}
    tables = {
        "system": "tippe-top",
        "parameters": CANONICAL,
        "friction": friction,
        "initial": start,
        "run": run,
    }
    return solve(problem(tables)).columns()["theta"].values


def orders(mu, start, times, speeds):
    """Exponents of the error in eps, from one eps to the next."""
    exact = theta(mu, start, times)
    errors = np.abs([theta(mu, start, times, eps) - exact for eps in speeds])
    return (
        np.log(errors[:-1] / errors[1:])
        / np.log(np.array(speeds[:-1]) / np.array(speeds[1:]))[:, None]
    )


def test_the_error_is_of_second_order_while_it_slides():
    start = {"theta": 0.1, "omega3": 155.0, "centre_at_rest": True}
    assert np.abs(orders(0.3, start, [0.01, 0.03], [5e-4, 2.5e-4, 1.25e-4]) - 2).max() < 1e-3


def test_the_error_is_of_first_order_in_rolling_and_less_after_it():
    """It rolls until 0.03616 s, slides until 0.04490 s: theory has 1, then 4/5 in the limit."""
    known = orders(ROLLS_THEN_SLIDES_MU, ROLLS_THEN_SLIDES, [0.03, 0.044], [5e-5, 2.5e-5, 1.25e-5])
    assert np.abs(known[:, 0] - 1).max() < 1e-3
    assert np.all((known[:, 1] > 0.75) & (known[:, 1] < 0.9))
