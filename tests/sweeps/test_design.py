"""Test the numbers of the tops of a sweep: the product of the grid, and the sample, fastest."""

import itertools

import numpy as np
import pytest

from tippetop.sweeps.design import Axis, Design, Sample


METHODS = ("random", "sobol", "latin-hypercube")
SLOW, FAST = Axis(of="slow", values=[3.0, 1.0]), Axis(of="fast", values=[10.0, 30.0, 20.0])
EVEN, LOG = Axis(of="even", between=[-1.0, 3.0]), Axis(of="log", between=[1e-3, 1e2], log=True)


def rows(design: Design) -> list[tuple[float, ...]]:
    """Every top as its numbers."""
    return list(zip(*design.numbers(np.arange(design.n)).values(), strict=True))


def test_a_grid_is_the_product_of_its_axes() -> None:
    design = Design((SLOW, FAST))
    assert design.sizes == {"slow": 2, "fast": 3}
    assert rows(design) == list(itertools.product(SLOW.numbers, FAST.numbers))


@pytest.mark.parametrize("method", METHODS)
def test_the_sample_is_repeated_at_every_point_of_the_grid(method: str) -> None:
    design = Design((EVEN, SLOW, LOG, FAST), Sample(method=method, n=8, seed=3))
    assert list(design.sizes.items()) == [("slow", 2), ("fast", 3), ("sample", 8)]
    assert design.n == 48
    numbers = {
        key: values.reshape(2, 3, 8) for key, values in design.numbers(np.arange(48)).items()
    }
    assert list(numbers) == ["even", "slow", "log", "fast"]
    for drawn in ("even", "log"):
        assert np.all(numbers[drawn] == numbers[drawn][0, 0])
        assert len(set(numbers[drawn][0, 0])) == 8
    assert np.all(numbers["slow"] == np.reshape(SLOW.numbers, (2, 1, 1)))
    assert np.all(numbers["fast"] == np.reshape(FAST.numbers, (1, 3, 1)))


@pytest.mark.parametrize("method", METHODS)
def test_some_tops_are_those_of_all(method: str, rng: np.random.Generator) -> None:
    """Whatever tops a chunk holds, in whatever order: the same bits."""
    design = Design((SLOW, EVEN, FAST), Sample(method=method, n=16, seed=1))
    whole = design.numbers(np.arange(design.n))
    some = rng.permutation(design.n)[:17]
    for key, values in (
        Design((SLOW, EVEN, FAST), Sample(method=method, n=16, seed=1)).numbers(some).items()
    ):
        assert values.tobytes() == whole[key][some].tobytes()


@pytest.mark.parametrize("method", METHODS)
def test_points_lie_in_the_range_and_spread_over_it(method: str) -> None:
    """Compare means and variances with those of uniform numbers, within six standard deviations."""
    n = 1024
    numbers = Design((EVEN, LOG), Sample(method=method, n=n, seed=2)).numbers(np.arange(n))
    for axis, unit in (
        (EVEN, (numbers["even"] + 1) / 4),
        (LOG, (np.log10(numbers["log"]) + 3) / 5),
    ):
        assert np.all((numbers[axis.of] >= axis.between[0]) & (numbers[axis.of] <= axis.between[1]))
        assert np.mean(unit) == pytest.approx(0.5, abs=6 / np.sqrt(12 * n))
        assert np.var(unit) == pytest.approx(1 / 12, abs=6 / np.sqrt(180 * n))
    assert abs(np.corrcoef(numbers["even"], np.log(numbers["log"]))[0, 1]) < 6 / np.sqrt(n)


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
def test_even_samples_have_one_point_in_every_layer_of_every_axis(method: str) -> None:
    points = Sample(method=method, n=64, seed=5).unit(3)
    for column in points.T:
        assert sorted(np.floor(column * 64).astype(int)) == list(range(64))


@pytest.mark.parametrize("method", METHODS)
def test_the_seed_decides(method: str) -> None:
    one, same, other = (Sample(method=method, n=16, seed=seed).unit(2) for seed in (1, 1, 2))
    assert one.tobytes() == same.tobytes()
    assert np.any(one != other)


def test_the_number_of_tops_does_not_overflow() -> None:
    axes = tuple(Axis(of=str(i), values=np.arange(1e4).tolist()) for i in range(6))
    assert Design(axes).n == 10**24
