"""How a motion changes with the numbers that a user gives: states, columns and their derivatives
along directions.
"""

import threading
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from .integrator import awaited_once
from .variational import Kind, compiled_motion, compiled_readings, compiled_starts


MOST_LANES = 4
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state


@dataclass(frozen=True)
class Tangents:
    """Motions with their derivatives along directions.

    Parameters
    ----------
    kind
        The system that moves.
    tolerance
        Of the integrator; 0 is the rounding unit.
    most
        Steps per internal unit of time beyond which a motion counts as one that cannot be
        integrated; 0: any number.
    """

    kind: Kind
    tolerance: float
    most: float = 0.0

    def states(self, numbers: np.ndarray, ways: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return states with derivatives at given times.

        Parameters
        ----------
        numbers, ways
            The user's numbers in internal units, (numbers, 1 or lanes), and the directions,
            (numbers, lanes).
        times
            Internal, (rows,) or (rows, lanes), ascending; the start is at 0.

        Returns
        -------
        ndarray
            (rows, order + 1, variables, lanes); NaN from where a motion cannot be integrated
            further.
        """
        kind, total = self.kind, ways.shape[1]
        lanes = 1 << min(total - 1, MOST_LANES - 1).bit_length()
        times = np.broadcast_to(times[:, None] if times.ndim == 1 else times, (len(times), total))
        starts = awaited_once(compiled_starts, (kind,), "the start is being compiled")
        key = kind, lanes, self.tolerance
        integrator = awaited_once(
            compiled_motion, key, "the variational equations are being compiled"
        )
        pars = _parameters(numbers, ways)
        begin = starts(np.empty((0, total)), pars=pars[: starts.nparams])
        rows = np.empty((len(times), *begin.shape))

        def follow(lane: np.ndarray) -> np.ndarray:
            with _one_at_a_time:
                return _followed(
                    integrator, begin[:, lane], pars[:, lane], times[:, lane], self.most
                )

        def fill() -> None:
            for first in range(0, total, lanes):
                block = np.minimum(np.arange(first, first + lanes), total - 1)
                part = follow(block)
                if lanes > 1 and not self.most and np.isnan(part).any():
                    # a lane that breaks down ends all of them
                    alone = [follow(np.full(lanes, lane))[..., 0] for lane in block]
                    part = np.stack(alone, axis=-1)
                rows[..., first : first + lanes] = part[..., : total - first]

        awaited(fill, "the variational equations are integrated")
        return rows.reshape(len(times), kind.order + 1, -1, total)

    def read(
        self,
        numbers: np.ndarray,
        ways: np.ndarray,
        times: np.ndarray,
        names: tuple[str, ...] | None,
        timed: tuple[str, ...],
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Return columns of states with derivatives at given times, in internal units.

        Parameters
        ----------
        numbers, ways, times
            As for `states`.
        names
            Of the columns; None: all.
        timed
            Those whose derivative by time is wanted too.

        Returns
        -------
        columns
            name -> (order + 1, rows, lanes): values and derivatives along the direction.
        rates
            name -> (rows, lanes), by internal time, of the `timed` ones.
        """
        key = self.kind, names, timed
        known, function = awaited_once(
            compiled_readings, key, "the derivatives of columns are being compiled"
        )
        states = self.states(numbers, ways, times)
        rows, orders, variables, lanes = states.shape
        inputs = states.transpose(1, 2, 0, 3).reshape(orders * variables, rows * lanes)
        pars = np.tile(_parameters(numbers, ways)[: function.nparams], (1, rows))
        outputs = function(np.ascontiguousarray(inputs), pars=pars).reshape(-1, rows, lanes)
        n = len(known)
        columns = {name: outputs[i : orders * n : n] for i, name in enumerate(known)}
        return columns, dict(zip(timed, outputs[orders * n :], strict=True))


def _parameters(numbers: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return the parameters of compiled functions: zero for `along`, numbers, directions."""
    along = np.zeros((1, ways.shape[1]))
    return np.concatenate([along, np.broadcast_to(numbers, ways.shape), ways])


def _followed(
    integrator: Any, begin: np.ndarray, pars: np.ndarray, times: np.ndarray, most: float
) -> np.ndarray:
    """Return rows (rows, variables, lanes) of one batch; NaN where it ended early."""
    integrator.set_time(0.0)
    integrator.state[:] = begin
    integrator.pars[:] = pars[: len(integrator.pars)]
    times, limit = np.ascontiguousarray(times), int(most * float(np.abs(times).max()) + 100)
    limits = {"max_steps": limit if most else 0}
    integrator.propagate_until(times[0], **limits)
    if any(outcome != hy.taylor_outcome.time_limit for outcome, *_ in integrator.propagate_res):
        return np.full((len(times), *begin.shape), np.nan)
    _, rows = integrator.propagate_grid(times, **limits)
    return np.array(rows)
