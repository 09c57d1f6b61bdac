"""When rows are wanted: a grid that is never held whole is the grid held whole; `until` is its last
time.
"""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tippetop.sampling import EvenTimes, ListedTimes


steps = st.sampled_from([1.0, 0.1, 0.3, 1e-3, 7.0, 1 / 3, np.pi])
lengths = st.integers(1, 500)
parts = st.sampled_from([0.0, 0.25, 0.999999])


@given(steps, lengths, parts)
def test_a_grid_begins_at_zero_steps_evenly_and_ends_with_until(
    step: float, count: int, part: float
) -> None:
    grid = EvenTimes(step, step * (count + part))
    times = grid[:]
    assert len(grid) == len(times) == count + 1 + (part > 0)
    assert (times[0], times[-1]) == (0.0, grid.until)
    assert np.all(np.diff(times) > 0)
    np.testing.assert_allclose(times[:-1], np.arange(len(times) - 1) * step, rtol=1e-15)


@given(steps, lengths, parts, st.floats(0, 1.1))
def test_counting_in_a_grid_is_counting_in_its_times(
    step: float, count: int, part: float, where: float
) -> None:
    grid = EvenTimes(step, step * (count + part))
    times = grid[:]
    row = times[min(int(where * count), len(times) - 1)]
    for at in (where * grid.until, row, np.nextafter(row, np.inf), np.nextafter(row, -np.inf)):
        assert grid.count(at) == ListedTimes(times).count(at) == np.sum(times <= at)


@given(
    st.integers(0, 10**10),
    st.integers(1, 99),
    st.sampled_from([100, 1000, 10**6]),
    st.one_of(st.integers(1, 10**5), st.integers(10**7, 10**9)),
)
def test_decimal_times_have_one_last_row(start: int, step: int, parts: int, count: int) -> None:
    """Start, step and end are rounded: no row lies a rounding before the last."""
    begin, each = Fraction(start, 1000), Fraction(step, parts)
    grid = EvenTimes(float(each), float(begin + count * each), float(begin))
    assert len(grid) == count + 1
    np.testing.assert_allclose(
        np.diff(grid[count - 3 :] if count > 3 else grid[:]), float(each), rtol=0.01
    )


def test_a_long_grid_is_cheap() -> None:
    """10^9 rows: none of them is made before it is asked for."""
    grid = EvenTimes(1e-6, 1e3)
    assert len(grid) == 10**9 + 1
    np.testing.assert_allclose(grid[10**8 : 10**8 + 3], 1e2 + np.arange(3) * 1e-6, rtol=1e-15)
    assert grid.count(grid[10**8 : 10**8 + 1][0]) == 10**8 + 1
