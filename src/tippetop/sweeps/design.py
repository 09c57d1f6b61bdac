"""The axes of a sweep: those with numbers form a grid, those with a range are drawn together.

Checked axes go in; the numbers of any top come out, by its number.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ..columns import Arrays
from ..mechanics.caching import cached_property
from ..scenario.schema import Table


MOST_TOPS = 10**9


@dataclass(frozen=True)
class Axis:
    """A key and its numbers: `values` of a grid, or `between` (low, high) of a drawn axis."""

    key: str
    values: tuple[float, ...] = ()
    between: tuple[float, ...] = ()
    log: bool = False  # spread evenly in the logarithm

    @property
    def sampled(self) -> bool:
        """True if its numbers are drawn at random."""
        return not self.values

    @property
    def varies(self) -> bool:
        """Whether tops have different numbers on it."""
        return self.sampled or len(set(self.values)) > 1


class Sample(Table, use_attribute_docstrings=True):
    """Method of drawing axes, in the words of TOML."""

    method: Literal["random", "sobol", "latin-hypercube"]
    """how the axes with between are drawn together"""
    n: Annotated[int, Field(ge=1, le=MOST_TOPS)]
    """how many tops are drawn"""
    seed: Annotated[int, Field(ge=0)]
    """start of the random numbers: the same seed, the same tops"""

    def unit(self, dimensions: int) -> np.ndarray:
        """Return points of the unit cube, (n, dimensions)."""
        if self.method == "random":
            return np.random.default_rng(self.seed).random((self.n, dimensions))
        from scipy.stats import qmc

        if self.method == "sobol":
            return qmc.Sobol(dimensions, rng=self.seed).random_base2(self.n.bit_length() - 1)
        return qmc.LatinHypercube(dimensions, rng=self.seed).random(self.n)


@dataclass(frozen=True)
class Design:
    """All tops of a sweep: the product of the grid, first axis slowest, and the sample, fastest.

    `Plan.from_tables` makes it.
    """

    axes: tuple[Axis, ...]
    sample: Sample | None = None

    @cached_property
    def grid(self) -> tuple[Axis, ...]:
        """The axes that form the product."""
        return tuple(axis for axis in self.axes if not axis.sampled)

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Dimensions and their lengths, the slowest first; drawn axes share `sample`."""
        sizes = {axis.key: len(axis.values) for axis in self.grid}
        return sizes | ({"sample": self.sample.n} if self.sample else {})

    @cached_property
    def n(self) -> int:
        """Number of tops."""
        return math.prod(self.sizes.values())

    @cached_property
    def _drawn(self) -> Arrays:
        """Return the numbers of drawn axes, by key."""
        axes = [axis for axis in self.axes if axis.sampled]
        points = self.sample.unit(len(axes)) if self.sample else np.zeros((0, 0))
        return {axis.key: _spread(axis, points[:, i]) for i, axis in enumerate(axes)}

    def numbers(self, tops: np.ndarray) -> Arrays:
        """Return the numbers of some tops on every axis, by key; tops are counted from 0."""
        indices = np.unravel_index(tops, tuple(self.sizes.values()))
        places = dict(zip(self.sizes, indices, strict=True))
        return {
            axis.key: self._drawn[axis.key][places["sample"]]
            if axis.sampled
            else np.array(axis.values)[places[axis.key]]
            for axis in self.axes
        }


def _spread(axis: Axis, unit: np.ndarray) -> np.ndarray:
    """Spread numbers of [0, 1) over the range of an axis."""
    low, high = np.log(axis.between) if axis.log else axis.between
    spread = low + (high - low) * unit
    return np.exp(spread) if axis.log else spread
