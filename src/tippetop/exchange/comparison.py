"""Comparison of the motion of another program with the exact reference at its own times."""

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.contact import body as contact
from ..problem import Problem
from ..runs.run import solve, with_rows_at
from .motion import Convention, Motion, angle_between, motion
from .motion_table import read


LEVELS = (1e-3, 1e-2, 1e-1)
STEP = re.compile(r"(?:^|[^a-zA-Z])(?:dt|h|step)[=_-]?([0-9.]+(?:e-?[0-9]+)?)", re.IGNORECASE)
ROUNDING = 1e-13  # smaller differences have no order of convergence
TOUCH = 1e-6  # [radius] largest gap of a contact


class Compared(NamedTuple):
    """One motion with its reference.

    Parameters
    ----------
    path
        The file.
    step
        Its time step [s] from the name of the file, or None.
    t
        Times [s], (rows,).
    curves
        Differences, (rows,) each; of energy and Jellett's integral relative to the first value.
    theta, reference
        theta of both [rad], (rows,); NaN if unknown.
    numbers
        The result as plain data.
    """

    path: Path
    step: float | None
    t: np.ndarray
    curves: dict[str, np.ndarray]
    theta: np.ndarray
    reference: np.ndarray
    numbers: dict[str, Any]

    @property
    def main(self) -> str:
        """The quantity by which motions are judged."""
        return next(n for n in ("attitude", "axis", "theta", "place", "omega3") if n in self.curves)


def compare(problem: Problem, path: str | Path, convention: Convention = Convention()) -> Compared:  # noqa: B008
    """Compare one table with the exact motion of a problem.

    Parameters
    ----------
    problem
        The reference.
    path
        A table, as `table.read` takes it.
    convention
        The conventions of its frames.

    Returns
    -------
    Compared

    Raises
    ------
    InputError
        If the table is wrong, or has no quantity that can be compared.
    """
    given = motion(read(path, wrapped=bool(problem.system.vectors)), convention)
    t = given.t
    if t[0] < 0 or t[-1] <= 0:
        raise InputError(
            f"`{path}`: times must begin at 0, the start of the reference, or later, but "
            f"begin at {t[0]:g} s."
        )
    run = solve(with_rows_at(problem, t))
    rows = len(run.times)
    if rows < 2:
        raise InputError(
            f"the reference must reach the times of `{path}`, but ends before: {run.reason}."
        )
    columns = {name: column.values for name, column in run.columns().items()}
    there = Motion(*(part if part is None else part[:rows] for part in given))  # type: ignore[arg-type]
    curves = differences(there, columns)
    if not curves:
        raise InputError(
            f"`{path}` must have theta, an axis, a quaternion or a place to be compared, "
            "but has none."
        )
    body = problem.body()
    kept, touching = {}, {}
    if isinstance(body, contact.Touch) and there.axis is not None:
        kept, touching = conserved(there, problem, body), _contact(there, problem, body)
    errors = {name: curve - _relative(columns[name]) for name, curve in kept.items()}
    numbers: dict[str, Any] = {
        "file": str(path),
        "rows": rows,
        "from": float(t[0]),
        "until": float(run.times[-1]),
    }
    numbers |= {name: size_of(run.times, curve) for name, curve in curves.items()}
    for what, changes in (("drift", kept), ("error", errors)):
        for name, curve in changes.items():
            numbers[f"{name}_{what}"] = float(np.nanmax(np.abs(curve)))
    numbers |= touching
    if rows < len(t):
        numbers["reference_ended"] = run.reason
    if faults := _start_faults(numbers, curves, convention):
        numbers["suspicion"] = faults
    unknown = np.full(rows, np.nan)
    theta = unknown if there.theta is None else there.theta
    step = STEP.search(Path(path).stem)
    return Compared(
        Path(path),
        float(step[1]) if step else None,
        run.times,
        curves | errors,
        theta,
        columns.get("theta", unknown),
        numbers,
    )


def differences(there: Motion, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the differences of two motions by quantity, (rows,) each; NaN in gaps."""
    result: dict[str, np.ndarray] = {}
    if there.theta is not None and "theta" in columns:
        result["theta"] = np.abs(there.theta - columns["theta"])
    if there.axis is not None and "axis" in columns:
        apart = np.linalg.norm(there.axis - columns["axis"], axis=1)
        result["axis"] = 2 * np.arcsin(np.clip(apart / 2, 0, 1))
    if there.orientation is not None and "orientation" in columns:
        result["attitude"] = angle_between(there.orientation, columns["orientation"])
    if there.place is not None and "x" in columns:
        flat = ["x", "y"] if "y" in columns else ["x"]
        ours = np.stack([columns[name] for name in flat], axis=1)
        off = there.place[:, : len(flat)] - ours
        off = off[:, np.isfinite(off).any(axis=0)]  # components that are never given do not count
        result["place"] = np.linalg.norm(off, axis=1) if off.size else np.full(len(off), np.nan)
    if there.omega3 is not None and "omega3" in columns:
        result["omega3"] = np.abs(there.omega3 - columns["omega3"])
    return {name: curve for name, curve in result.items() if np.isfinite(curve).any()}


def conserved(there: Motion, problem: Problem, body: contact.Touch) -> dict[str, np.ndarray]:
    """Return the relative changes of energy and Jellett's integral of the other motion itself."""
    u: Any = there.axis
    w = there.omega
    if w is None:
        return {}
    values = {}
    if problem.system.name.endswith("tippe-top"):
        spin = (w * u).sum(axis=1)
        Lz = body.I1 * w[:, 2] + (body.I3 - body.I1) * spin * u[:, 2]
        values["jellett"] = contact.jellett_of(Lz, body.I3 * spin, body)
    if there.velocity is not None and there.place is not None:
        values["energy"] = energy(there.velocity, w, there.place[:, 2], u, body)
    return {name: _relative(value) for name, value in values.items() if np.isfinite(value).any()}


def energy(velocity: Any, omega: Any, height: Any, axis: Any, body: contact.Touch) -> np.ndarray:
    """Return the energy [J], (rows,)."""
    spin = (omega * axis).sum(axis=1)
    turning = body.I1 * (omega**2).sum(axis=1) + (body.I3 - body.I1) * spin**2
    return (body.m * (velocity**2).sum(axis=1) + turning) / 2 + body.m * body.g * height


def _relative(values: np.ndarray) -> np.ndarray:
    """Return the changes since the first known value, relative to it."""
    return values / values[np.isfinite(values)][0] - 1


def _contact(there: Motion, problem: Problem, body: contact.Touch) -> dict[str, Any]:
    """Return the penetration of the floor by the other motion, and the times when it leaves it."""
    axis: Any = there.axis
    if (
        there.place is None
        or problem.system.name == "heavy-top"
        or not np.isfinite(there.place[:, 2]).any()
    ):
        return {}
    z = axis[:, 2]
    gap = there.place[:, 2] - contact.height(z, contact.touching_ball(z, 1 - z * z, body))
    off = gap > TOUCH * contact.size(body)
    leaves = there.t[1:][off[1:] & ~off[:-1]]
    return {
        "contact": {
            "penetration": float(max(0.0, -np.nanmin(gap))),
            "gap": float(max(0.0, np.nanmax(gap))),
            "leaves": [float(t) for t in leaves[:100]],
            "times_off": len(leaves),
        }
    }


def size_of(t: np.ndarray, curve: np.ndarray) -> dict[str, Any]:
    """Return the largest and the root mean square difference, and when it exceeds each level."""
    given = np.isfinite(curve)
    t, curve = t[given], curve[given]
    beyond = {f"{level:g}": np.flatnonzero(curve > level) for level in LEVELS}
    return {
        "max": float(curve.max()),
        "rms": float(np.sqrt(np.mean(curve**2))),
        "leaves": {
            level: float(t[rows[0]]) if len(rows) else None for level, rows in beyond.items()
        },
    }


def _start_faults(
    numbers: dict[str, Any], curves: dict[str, np.ndarray], convention: Convention
) -> str:
    """Return a message if the first row differs from the start of the reference."""
    known = "--up y: their z, x, y are our x, y, z" if convention.up == "y" else "z up"
    for name in ("attitude", "axis", "theta"):
        if name in curves and numbers["from"] == 0.0 and curves[name][0] > 0.01:
            return (
                f"the first row must be the start of the reference, but its {name} differs by "
                f"{curves[name][0]:.3g} rad: check the start, the frames ({known}) and the order "
                "of the quaternion."
            )
    return ""


def orders(compared: Sequence[Compared]) -> list[dict[str, Any]]:
    """Return the orders of convergence d log(error)/d log(step) between different steps.

    They are those of the time in which the coarser motion is within 0.1 rad.
    """
    stepped = sorted((c for c in compared if c.step), key=lambda c: -(c.step or 0))
    result = []
    for coarse, fine in itertools.pairwise(stepped):
        if coarse.step == fine.step:
            continue
        pair: dict[str, Any] = {"steps": [coarse.step, fine.step]}
        for name in ("theta", "attitude", "axis", "place"):
            if name not in coarse.curves or name not in fine.curves:
                continue
            over = np.flatnonzero(coarse.curves[name] > LEVELS[-1])
            end = coarse.t[over[0]] if len(over) else coarse.t[-1]
            errors = [np.sqrt(np.nanmean(c.curves[name][c.t <= end] ** 2)) for c in (coarse, fine)]
            if min(errors) > ROUNDING:
                pair[name] = math.log(errors[0] / errors[1]) / math.log(
                    (coarse.step or 1) / (fine.step or 1)
                )
        result.append(pair)
    return result
