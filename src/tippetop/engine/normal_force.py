"""The normal force over the steps of a slice: its extremes, and the moment it falls below zero."""

from dataclasses import replace

import numpy as np

from ..problem import Problem
from .extremes import Extremes, falls_below_zero, rate_extremes
from .status import Status
from .taylor import Slice, endings_of, rows_at
from .zeros import Zero


def grazing(piece: Slice, force: Extremes, problem: Problem) -> Slice:
    """The slice, cut at the moment the normal force falls below zero, if the integrator found no liftoff.

    Parameters
    ----------
    piece
        The steps of a slice.
    force
        The extremes of g_n over it.
    problem
        The run.

    Returns
    -------
    Slice
        The same one where nothing grazes; otherwise it ends at the zero, with the status of the event.

    Notes
    -----
    Event detection finds simple roots; a force that dips below zero within rounding of a double root, or that is
    negative from the start, is seen here, in the extremes of every step.
    """
    event = next((event for event in endings_of(problem) if event.extremes), None)
    if event is None or event.ends is None or not force.least < -1e-13:
        return piece
    status = Status.of_event(event.ends)
    high = falls_below_zero(piece.times, _impulse(piece, problem))
    none = piece.coefficients[:0]
    if high is None or high <= float(piece.times[0]):
        return replace(piece, times=piece.times[:1], coefficients=none, ends=none[:, :, 0], zeros=[], status=status)
    steps = int(np.searchsorted(np.asarray(piece.times, float), high))
    times = np.append(piece.times[:steps], problem.number(high))
    zeros = [zero for zero in piece.zeros if zero.time <= high] + [Zero(problem.number(high), event.name, -1)]
    coefficients = piece.coefficients[:steps]
    ends = np.concatenate([piece.ends[: steps - 1], rows_at(piece, times[-1:], problem)])
    return replace(piece, times=times, coefficients=coefficients, ends=ends, zeros=zeros, status=status)


def normal_force(piece: Slice, problem: Problem) -> Extremes:
    """Extremes of the normal force over every step of the slice, in internal units.

    Parameters
    ----------
    piece
        The steps of a slice.
    problem
        The run.

    Returns
    -------
    Extremes
        Of g_n; empty where no normal force is integrated.
    """
    if "impulse" not in problem.variables.names:
        return Extremes()
    return rate_extremes(piece.times, _impulse(piece, problem))


def _impulse(piece: Slice, problem: Problem) -> np.ndarray:
    """Taylor coefficients of the integral of the normal force, (n, order + 1), internal units."""
    return problem.variables.coefficients("impulse", piece.coefficients)
