"""The times of stored rows: listed ones, or an even grid that is never whole in memory.

`RunOptions.rows` makes one of them; `runs.integration` takes the times of rows from it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class EvenTimes:
    """The times start, start + step, start + 2 step, ..., and `until` as the last one [s]."""

    step: float
    until: float
    start: float = 0.0

    def __len__(self) -> int:
        # `until` is the last multiple of a step, but for rounding, or one row more; with another
        # tolerance, a stored run that is resumed would get other rows
        steps = int((self.until - self.start) / self.step * (1 + 1e-12))
        rest = self.until - (self.start + steps * self.step)
        least = 1e-9 * min(self.step, self.until - self.start)
        return steps + 1 + (rest > max(least, 4 * math.ulp(self.until)))

    def __getitem__(self, rows: slice) -> np.ndarray:
        first, last, _ = rows.indices(len(self))
        times = self.start + np.arange(first, last) * self.step
        if last == len(self) and len(times):
            times[-1] = self.until
        return times

    def count(self, t: float) -> int:
        """Return the number of times up to t, as `__getitem__` rounds them."""
        # the quotient is rounded: the times around it are compared
        near = min(max(0, int((t - self.start) / self.step) - 1), len(self))
        return near + int(np.searchsorted(self[near : near + 4], t, side="right"))


@dataclass(frozen=True)
class ListedTimes:
    """Times that the user listed, ascending [s]."""

    times: np.ndarray

    def __post_init__(self) -> None:
        times = self.times.view()
        times.flags.writeable = False
        object.__setattr__(self, "times", times)

    def __reduce__(self) -> tuple[Any, ...]:
        return ListedTimes, (self.times,)

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, rows: slice) -> np.ndarray:
        return self.times[rows]

    def count(self, t: float) -> int:
        """Return the number of times up to t."""
        return int(np.searchsorted(self.times, t, side="right"))


def spread(size: int, count: int) -> np.ndarray:
    """Return at most `count` indices of `size`, evenly, the first and the last among them."""
    return np.unique(np.linspace(0, size - 1, count).astype(int))


def extremes(values: np.ndarray, size: int) -> np.ndarray:
    """Return the indices of the least and the greatest value per `size` values, and of the last.

    Ascending, each once; NaN counts as 0.
    """
    count = len(values)
    first = np.arange(0, count, size)
    bins = np.pad(np.nan_to_num(values), (0, -count % size), "edge").reshape(-1, size)
    # an index beyond the end is that of a copy of the last value, by which the last bin is padded
    return np.unique(
        np.minimum([*(first + bins.argmin(1)), *(first + bins.argmax(1)), count - 1], count - 1)
    )
