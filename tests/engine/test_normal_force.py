"""A liftoff that no event saw is seen in the normal force: slices are cut where a known force falls below zero."""

import dataclasses

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from test_extremes import TIMES, integral_of

from tippetop.engine.extremes import Extremes
from tippetop.engine.normal_force import grazing, normal_force
from tippetop.engine.status import Status
from tippetop.engine.taylor import Slice
from tippetop.engine.zeros import Zero
from tippetop.mechanics.variables import INTEGRAL_SCALE
from tippetop.problem import Problem
from tippetop.scenario import build


@pytest.fixture(scope="module")
def problem() -> Problem:
    """A run that liftoff ends."""
    return build.load("inverting", until=1.0)


def slice_of(force: Polynomial, problem: Problem) -> Slice:
    """Steps in which nothing moves but the integral of this force; every variable is the time at every moment."""
    impulse = integral_of(force)
    names = problem.variables.names
    coefficients = np.zeros((len(TIMES) - 1, len(names), impulse.shape[1]))
    coefficients[:, names.index("impulse")] = impulse * INTEGRAL_SCALE
    zeros = [Zero(time, "turning", 1) for time in (0.2, 0.9, 1.8)]

    def output(times: np.ndarray) -> np.ndarray:
        return np.repeat(times[:, None], len(names), axis=1)

    return Slice(TIMES, output, coefficients, output(TIMES[1:]), zeros, None, 0.0)


def test_extremes_are_those_of_the_force(problem: Problem) -> None:
    force = Polynomial([2.0, -3.0, 1.0])  # least -1/4 at 3/2, greatest 2 at 0
    found = normal_force(slice_of(force, problem), problem)
    np.testing.assert_allclose(found, [-0.25, 1.5, 2.0, 0.0], rtol=0, atol=1e-7)
    assert found.least == pytest.approx(-0.25, abs=1e-13)


def test_a_slice_is_cut_where_the_force_falls_below_zero(problem: Problem) -> None:
    """Times, coefficients, ends and zeros beyond that moment are gone, what is before is as it was."""
    piece = slice_of(Polynomial([2.0, -3.0, 1.0]), problem)  # zero at 1, in the third step
    cut = grazing(piece, normal_force(piece, problem), problem)
    assert cut.status is Status.LIFTOFF
    np.testing.assert_allclose(cut.times, [0.0, 0.4, 0.5, 1.0], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(cut.coefficients, piece.coefficients[:3])
    np.testing.assert_array_equal(cut.ends[:, 0], cut.times[1:])
    assert [(zero.kind, zero.sign) for zero in cut.zeros] == [("turning", 1), ("turning", 1), ("liftoff", -1)]
    assert cut.zeros[-1].time == cut.times[-1]


def test_a_force_that_is_negative_from_the_start_leaves_no_step(problem: Problem) -> None:
    piece = slice_of(Polynomial([-1.0]), problem)
    cut = grazing(piece, normal_force(piece, problem), problem)
    assert cut.status is Status.LIFTOFF
    assert (len(cut.times), len(cut.coefficients), len(cut.ends), len(cut.zeros)) == (1, 0, 0, 0)


@pytest.mark.parametrize("least", [0.5, 0.0, -1e-14])
def test_a_force_within_rounding_of_zero_cuts_nothing(least: float, problem: Problem) -> None:
    piece = slice_of(least + Polynomial([-0.77, 1.0]) ** 2, problem)
    assert grazing(piece, normal_force(piece, problem), problem) is piece


def test_a_run_that_continues_beyond_liftoff_is_not_cut(problem: Problem) -> None:
    piece = slice_of(Polynomial([2.0, -3.0, 1.0]), problem)
    beyond = dataclasses.replace(problem, on_liftoff="continue")
    assert grazing(piece, normal_force(piece, problem), beyond) is piece


def test_a_form_without_such_an_integral_has_no_extremes(problem: Problem) -> None:
    form = dataclasses.replace(problem.form, integrals=())
    bare = dataclasses.replace(problem, form=form)
    piece = slice_of(Polynomial([-1.0]), problem)
    assert normal_force(piece, bare) == Extremes()
    assert grazing(piece, normal_force(piece, bare), problem) is piece
