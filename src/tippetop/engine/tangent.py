"""How a motion changes with the numbers that a user gives: states, columns and their derivatives
along directions.
"""

import threading
from typing import Any

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from .integrator import awaited_once
from .variational import Kind, Readings, compiled_motion, compiled_readings, compiled_starts


MOST_LANES = 4
# internal time in which all lanes together do not repay the 10 s that straight code takes to
# compile
SOON = 3e4
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state


class Tangents:
    """Motions with their derivatives along directions.

    Parameters
    ----------
    kind
        What moves.
    tolerance
        Of the integrator; 0 is the rounding unit.
    most
        Steps per internal unit of time beyond which a motion counts as one that cannot be
        integrated; 0: any number.
    uses
        How often motions are asked for, about.
    longest
        Internal time of the longest of them; 0: each is as long as the others.
    """

    def __init__(
        self,
        kind: Kind,
        tolerance: float = 0.0,
        most: float = 0.0,
        *,
        uses: int = 1,
        longest: float = 0.0,
    ):
        self.kind, self.tolerance, self.most, self.uses, self.longest = (
            kind,
            tolerance,
            most,
            uses,
            longest,
        )

    def states(
        self,
        numbers: np.ndarray,
        ways: np.ndarray,
        times: np.ndarray,
        needs: tuple[str, ...] | None = None,
    ) -> np.ndarray:
        """States with derivatives at given times.

        Parameters
        ----------
        numbers, ways
            The user's numbers in internal units, and the direction: (numbers, lanes) each.
        times
            Internal, (rows,) or (rows, lanes), ascending; the start is at 0.
        needs
            Variables that must be right; None: all.

        Returns
        -------
        ndarray
            (rows, order + 1, variables, lanes); NaN from where a motion cannot be integrated
            further.
        """
        kind, total = self.kind, numbers.shape[1]
        names = kind.variables.names
        wanted = names if needs is None else needs
        lanes = 1 << min(total - 1, MOST_LANES - 1).bit_length()
        times = np.broadcast_to(times[:, None] if times.ndim == 1 else times, (len(times), total))
        compact = float(np.abs(times).max(initial=self.longest)) * total * self.uses < SOON
        starts = awaited_once(compiled_starts, (kind,), "the start is being compiled")
        key = kind, lanes, compact, self.tolerance, tuple(wanted)
        motion = awaited_once(compiled_motion, key, "the variational equations are being compiled")
        begin = starts(np.concatenate([numbers, ways]))
        k = kind.body_numbers
        pars = np.concatenate([numbers[:k], ways[:k]])
        rows = np.zeros((len(times), (kind.order + 1) * len(names), total))

        def fill() -> None:
            for first in range(0, total, lanes):
                block = np.minimum(np.arange(first, first + lanes), total - 1)
                with _one_at_a_time:
                    part = self._block(motion, begin[:, block], pars[:, block], times[:, block])
                count = min(lanes, total - first)
                rows[:, motion[1], first : first + count] = part[:, :, :count]

        awaited(fill, "the variational equations are integrated")
        return rows.reshape(len(times), kind.order + 1, len(names), total)

    def _block(
        self, motion: Any, begin: np.ndarray, pars: np.ndarray, times: np.ndarray
    ) -> np.ndarray:
        """Rows of the lanes of one batch.

        A lane that breaks down ends all of them: then each is followed alone.
        """
        together = _followed(motion, begin, pars, times, self.most)
        lanes = times.shape[1]
        if lanes > 1 and not self.most and np.isnan(together).any():
            for lane in range(lanes):
                same = np.full(lanes, lane)
                alone = _followed(motion, begin[:, same], pars[:, same], times[:, same], self.most)
                together[:, :, lane] = alone[:, :, lane]
        return together

    def read(
        self,
        numbers: np.ndarray,
        ways: np.ndarray,
        states: np.ndarray,
        names: tuple[str, ...] | None,
        timed: tuple[str, ...],
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Columns of states with derivatives, in internal units.

        Returns
        -------
        columns
            name -> (order + 1, rows, lanes): values and derivatives along the direction.
        rates
            name -> (rows, lanes), by internal time, of the `timed` ones.
        """
        readings = self._readings(names, timed)
        rows, orders, variables, lanes = states.shape
        k, function = self.kind.body_numbers, readings.function
        inputs = states.transpose(1, 2, 0, 3).reshape(orders * variables, rows * lanes)
        pars = np.tile(np.concatenate([numbers[:k], ways[:k]]), (1, rows))[: function.nparams]
        outputs = function(np.ascontiguousarray(inputs), pars=pars).reshape(-1, rows, lanes)
        n = len(readings.names)
        columns = {name: outputs[i : orders * n : n] for i, name in enumerate(readings.names)}
        return columns, dict(zip(timed, outputs[orders * n :], strict=True))

    def _readings(self, names: tuple[str, ...] | None, timed: tuple[str, ...]) -> Readings:
        key = self.kind, names, timed
        return awaited_once(compiled_readings, key, "the derivatives of columns are being compiled")

    def needs(self, names: tuple[str, ...] | None, timed: tuple[str, ...]) -> tuple[str, ...]:
        """The variables that columns read."""
        return self._readings(names, timed).needs


def _followed(
    motion: tuple[Any, np.ndarray],
    begin: np.ndarray,
    pars: np.ndarray,
    times: np.ndarray,
    most: float,
) -> np.ndarray:
    """Rows (rows, variables, lanes) of one batch; NaN where it ended early."""
    integrator, places = motion
    integrator.set_time(0.0)
    integrator.state[:] = begin[places]
    integrator.pars[:] = pars[: len(integrator.pars)]
    limit = {"max_steps": int(most * float(np.abs(times).max()) + 100)} if most else {}
    if np.any(times[0] != 0.0):
        integrator.propagate_until(np.ascontiguousarray(times[0]), **limit)
        if any(outcome != hy.taylor_outcome.time_limit for outcome, *_ in integrator.propagate_res):
            return np.full((len(times), len(places), times.shape[1]), np.nan)
    _, rows = integrator.propagate_grid(np.ascontiguousarray(times), **limit)
    return np.array(rows)
