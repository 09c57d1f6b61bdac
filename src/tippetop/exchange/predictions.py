"""Columns of many motions at given times, for sets of values of the free numbers of a scenario.

Values of the free numbers and times go in; columns come out, computed by an ensemble.
"""

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ..columns import Arrays
from ..engine.instruments import IN_BODY
from ..ensembles.rows_at_times import rows_at_times
from ..mechanics.units import SECOND
from ..problem import Problem, Problems, refuse
from ..runs.shape import moments
from .motion import in_body_axes, turned


# Tolerance of the integrator while numbers are searched: half of the time
TOLERANCE = 1e-9
# Steps per internal unit of time beyond which a smooth motion is given up: a canonical inversion
# takes 9, a rattleback 27
MOST_STEPS = 60.0
ACCELEROMETER = ("accelerometer", "gyroscope", "turning")


def followed(problem: Problem, free: Sequence[str]) -> Problem:
    """Return a scenario whose motion goes through its end and, if it is smooth, through lift-off.

    Raises InputError if it lacks a number of a name in `free`, of which initial ones need no value,
    or its motion is not one of doubles from a start.
    """
    refuse(problem, free)
    changes: Any = {} if problem.system.is_hybrid else {"on_liftoff": "continue"}
    return dataclasses.replace(problem, stop_when="until", **changes)


def columns_at(
    problem: Problem, points: Mapping[str, np.ndarray], times: np.ndarray, names: Collection[str]
) -> Arrays:
    """Return columns (points, rows) or (points, rows, parts), SI, by name.

    They are NaN where a motion cannot be computed.

    Parameters
    ----------
    problem
        The scenario, see `followed`.
    points
        Values of the free numbers, (points,) each, SI.
    times
        (points, rows) [s], ascending.
    names
        Of the columns: those of runs, and `IN_BODY`.
    """
    if not points:  # nothing is free: a motion for each row of `times`, up to its last time
        points = {"run.until": times[:, -1]}
    known = {*names}
    # omega from L, about the centre of mass: the engine has instruments in smooth motion only. The
    # L of a heavy top, which has no x, is about its tip.
    by_momentum = problem.system.is_hybrid or "x" in problem.system.angles._fields
    by_momentum &= "accelerometer" not in known and not known.isdisjoint(IN_BODY)
    if by_momentum:
        known = {"orientation", "L"} | (known - IN_BODY.keys())
    turning = not known.isdisjoint({"orientation", *IN_BODY})
    tops = Problems.vary(problem, points, turning)
    # 1: also a motion of much less than a unit of time has MOST_STEPS
    most = int(MOST_STEPS * (1 + times.max() / problem.unit(SECOND)))
    read = rows_at_times(tops, times, known, most=most)
    if by_momentum:
        q = read["orientation"]
        inertia = moments(tops.body(lambda number: np.broadcast_to(number, tops.n)))
        read["gyroscope"] = in_body_axes(q, read["L"]) / inertia.T[:, None]
        read["omega"] = turned(q, read["gyroscope"])
    return read


def at_chip(read: Arrays, chip: Sequence[float]) -> np.ndarray:
    """Return the specific force at a place in the body, (..., 3) [m/s^2].

    `read`: the columns `ACCELEROMETER` of a motion, (..., 3) each, in body axes: the specific force
    at the centre of mass, the angular velocity, and its rate. `chip` is the place in body axes.
    """
    w = read["gyroscope"]
    # the acceleration of the place relative to the centre of mass
    bent = np.cross(read["turning"], chip) + np.cross(w, np.cross(w, chip))
    return np.asarray(read["accelerometer"] + bent)
