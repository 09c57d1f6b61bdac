"""The minimiser and its roots on functions whose answers are known, called from other people's
numba code.
"""

import math
from typing import NamedTuple

import numba
import numpy as np
import pytest

from tippetop_kernels.compilation import kernel
from tippetop_kernels.grid import on_threads
from tippetop_kernels.minimise import (
    LARGEST,
    MOST_EXTREMES,
    SMALLEST,
    extremes,
    lowest,
)


class Hill(NamedTuple):
    """f = cosh(ln q - centre) + tilt ln q: the minimum is at ln q = centre - asinh(tilt)."""

    centre: float
    tilt: float


@kernel
def value(q, p, r):
    return math.cosh(math.log(q) - p.centre) + p.tilt * math.log(q)


@kernel
def slope(q, p, r):
    return math.sinh(math.log(q) - p.centre) + p.tilt


@numba.njit
def theirs(centres, tilt):
    """Somebody's own compiled loop around our kernel."""
    found, turns = np.empty(centres.size), np.empty(MOST_EXTREMES)
    for i in range(centres.size):
        extremes(slope, Hill(centres[i], tilt), 0, turns)
        found[i] = turns[0]
    return found


def test_minimum_is_found_inside_foreign_code():
    centres = np.linspace(-60, 60, 101)
    np.testing.assert_allclose(
        np.log(theirs(centres, 0.5)), centres - math.asinh(0.5), rtol=1e-14, atol=1e-14
    )


@pytest.mark.parametrize(("centre", "end"), [(-100.0, SMALLEST), (100.0, LARGEST)])
def test_minimum_beyond_the_range_is_its_end(centre, end):
    assert theirs(np.array([centre]), 0.0) == pytest.approx(end, rel=1e-15, abs=0)


@kernel
def double_slope(q, p, r):
    """f' = x (x^2 - 9) + tilt, two minima near x = -3, 3 for a small tilt."""
    x = math.log(q)
    return x * (x * x - 9) + p.tilt


@kernel
def double_value(q, p, r):
    x = math.log(q)
    return x**4 / 4 - 4.5 * x * x + p.tilt * x


@pytest.mark.parametrize("tilt", [-1.0, 1.0])
def test_lowest_of_two_minima(tilt):
    turns = np.empty(MOST_EXTREMES)
    maxima = extremes(double_slope, Hill(0.0, tilt), 0, turns)
    q = turns[2 * lowest(double_value, turns, 0, maxima, Hill(0.0, tilt), 0)]
    roots = np.roots([1, 0, -9, tilt]).real
    best = min(roots, key=lambda x: x**4 / 4 - 4.5 * x * x + tilt * x)
    assert math.log(q) == pytest.approx(best, rel=1e-13)
    assert maxima == 1


def test_every_row_is_worked_once():
    for rows, threads in ((1, 2), (7, 2), (100, 1), (1000, 3)):
        seen = np.zeros(rows, int)

        def work(piece, seen=seen):
            seen[piece] += 1

        on_threads(work, rows, threads)
        assert (seen == 1).all()


def test_an_error_on_a_thread_reaches_the_caller():
    def work(piece):
        raise MemoryError("no room")

    with pytest.raises(MemoryError, match="no room"):
        on_threads(work, 100, 2)
