"""The axes of a sweep: those with numbers form a grid, those with a range are drawn together.

Checked axes go in; the numbers of any top come out, by its number.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field

from ..columns import Arrays
from ..mechanics.caching import cached_property
from ..scenario.schema import Table


MOST_TOPS = 10**9
MOST_VALUES = 10**7  # of linspace and geomspace, which are kept in memory


# a text is read once the unit of its axis is known
Number = float | str
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
# an invalid top is marked, and its neighbours run
AnyNumber = Annotated[float, Field(allow_inf_nan=True)] | str


class Axis(Table, use_attribute_docstrings=True):
    """An axis of a sweep, in the words of TOML: its key, and its numbers in one of four ways."""

    model_config = ConfigDict(ignored_types=(cached_property,))

    of: str
    """a dotted key of parameters, friction, initial, air or plane, or run.until, or a derived \
number: sigma, gamma, lambda"""
    values: Annotated[list[AnyNumber], Field(min_length=1)] | None = None
    """the numbers of an axis of a grid; grids form a product"""
    linspace: Pair | None = None
    """instead, first and last of n evenly spaced numbers"""
    geomspace: Pair | None = None
    """instead, first and last of n numbers with equal ratios"""
    between: Pair | None = None
    """instead, bounds of a number that is drawn as in [sample]"""
    n: Annotated[int, Field(ge=1, le=MOST_VALUES)] | None = None
    """with linspace or geomspace: how many"""
    log: bool | None = None
    """with between: draw the logarithm evenly"""

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """The numbers of an axis of a grid; none where they are drawn."""
        values: Any = self.values or ()
        if ends := self.linspace or self.geomspace:
            spread: Any = np.linspace if self.linspace else np.geomspace
            values = spread(*ends, self.n).tolist()
        return tuple(values)

    @property
    def is_log(self) -> bool:
        """Whether the numbers are spread evenly in the logarithm."""
        return bool(self.log or self.geomspace)

    @property
    def sampled(self) -> bool:
        """True if its numbers are drawn at random."""
        return self.between is not None

    @property
    def varies(self) -> bool:
        """Whether tops have different numbers on it."""
        return self.sampled or len(set(self.numbers)) > 1


class Sample(Table, use_attribute_docstrings=True):
    """Method of drawing axes, in the words of TOML."""

    method: Literal["random", "sobol", "latin-hypercube"]
    """how the axes with between are drawn together"""
    n: Annotated[int, Field(ge=1, le=MOST_TOPS)]
    """how many tops are drawn"""
    seed: Annotated[int, Field(ge=0)]
    """start of the random numbers: the same seed, the same tops"""

    def unit(self, dimensions: int) -> np.ndarray:
        """Return points of the unit cube, (n, dimensions), which seed and method determine."""
        if self.method == "random":
            return np.random.default_rng(self.seed).random((self.n, dimensions))
        from scipy.stats import qmc

        kinds = {"sobol": qmc.Sobol, "latin-hypercube": qmc.LatinHypercube}
        return kinds[self.method](dimensions, rng=self.seed).random(self.n)


@dataclass(frozen=True)
class Design:
    """All tops of a sweep: the product of the grid, first axis slowest, and the sample, fastest.

    `Plan.from_tables` makes it. `sample` is how the axes with `between` are drawn; None without
    such axes.
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
        sizes = {axis.of: len(axis.numbers) for axis in self.grid}
        return sizes | ({"sample": self.sample.n} if self.sample else {})

    @cached_property
    def n(self) -> int:
        """Number of tops."""
        return math.prod(self.sizes.values())

    @cached_property
    def _drawn(self) -> Arrays:
        """Return the numbers of drawn axes, (sample.n,) by key, SI.

        The order of the axes decides which coordinate of the points each takes, hence the tops.
        """
        axes = [axis for axis in self.axes if axis.sampled]
        points = self.sample.unit(len(axes)) if self.sample else np.zeros((0, 0))
        return {axis.of: _spread(axis, points[:, i]) for i, axis in enumerate(axes)}

    def numbers(self, tops: np.ndarray) -> Arrays:
        """Return the numbers of some tops on every axis, by key; tops are counted from 0."""
        indices = np.unravel_index(tops, tuple(self.sizes.values()))
        # of each top, the index along each dimension
        places = dict(zip(self.sizes, indices, strict=True))
        return {
            axis.of: self._drawn[axis.of][places["sample"]]
            if axis.sampled
            else np.array(axis.numbers)[places[axis.of]]
            for axis in self.axes
        }


def _spread(axis: Axis, unit: np.ndarray) -> np.ndarray:
    """Spread numbers of [0, 1), any shape, over the range of an axis; return numbers in SI."""
    ends: Any = axis.between
    low, high = np.log(ends) if axis.log else ends
    spread = low + (high - low) * unit
    return np.exp(spread) if axis.log else spread
