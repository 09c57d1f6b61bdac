"""Records kept as columns come back as they were; a formula worked in stages is the formula."""

from types import FunctionType
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from tippetop_kernels.compilation import kernel
from tippetop_kernels.staging import BLOCK, STAGES, first, get, put, second, third, width


class Pair(NamedTuple):
    a: float
    b: float


class Nested(NamedTuple):
    x: float
    pair: Pair
    more: tuple[float, Pair]


def nested(x: float) -> Nested:
    return Nested(x, Pair(x + 1, x + 2), (x + 3, Pair(x + 4, x + 5)))


nested_inside = numba.njit(nested)


@numba.njit
def there_and_back(n):
    """n records in a table, and back in reverse order."""
    like = nested_inside(0.0)
    table = np.full(width(like) * BLOCK, np.nan)
    for j in range(n):
        put(table, j, nested_inside(10.0 * j))
    found = [like]
    for j in range(n - 1, -1, -1):
        found.append(get(table, j, like))
    return width(like), table, found[1:]


@pytest.mark.parametrize("n", [1, 7, BLOCK])
def test_records_come_back_from_their_columns(n: int) -> None:
    size, table, found = there_and_back(n)
    assert size == 6
    assert found == [nested(10.0 * j) for j in reversed(range(n))]
    columns = table.reshape(6, BLOCK)
    np.testing.assert_array_equal(columns[:, :n], 10.0 * np.arange(n) + np.arange(6)[:, None])
    assert np.all(np.isnan(columns[:, n:]))


def test_a_record_of_anything_but_doubles_is_refused() -> None:
    @numba.njit
    def measured():
        return width((1.0, 2))

    with pytest.raises((TypeError, NumbaError), match="must be made of doubles"):
        measured()


@kernel
def opened(x, k):
    return Pair(x * k, x + k)


@kernel
def worked(before, x, k):
    return before.a / before.b


@kernel
def closed(before, x, k):
    return before - x


@kernel
def whole(x, k):
    """(x k)/(x + k) - x"""
    return closed(worked(opened(x, k), x, k), x, k)


def staged(*stages):
    """Return a copy of `whole` that is made in these stages."""
    copy = kernel(FunctionType(whole.__code__, globals()))
    STAGES[copy] = stages
    return copy


def by_stages(function):
    """Return what the three stages make of a function."""

    @numba.njit
    def inside(x, k):
        one = first(function, x, k)
        two = second(function, one, x, k)
        return third(function, two, x, k)

    return inside


@kernel
def twice(before, x, k):
    return closed(worked(before, x, k), x, k)


@pytest.mark.parametrize(
    "stages", [(), (whole,), (opened, twice), (opened, worked, closed)], ids=len
)
def test_any_number_of_stages_makes_the_whole(stages: tuple, rng: np.random.Generator) -> None:
    function = by_stages(staged(*stages) if stages else whole)
    for x, k in rng.uniform(0.5, 2, (20, 2)).tolist():
        assert function(x, k) == whole(x, k)
