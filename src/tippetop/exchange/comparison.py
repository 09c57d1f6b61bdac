"""Comparison of motions of another program with the exact reference at their own times.

A problem and a table go in; a `Compared` comes out, with differences over time and numbers on them.
A `Verdict` on several tables is what users see, as `library.exchanging.Comparison`.
"""

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays
from ..errors import InputError
from ..mechanics.contact import body as contact
from ..mechanics.contact.surroundings import groups_of
from ..mechanics.operand import Vector
from ..problem import Problem
from ..runs.run import Solution, solve, with_rows_at
from ..runs.shape import lies, lowest
from .headers import CAMERA, KIND, UNITS
from .motion import Convention, angle_in_picture, in_body_axes, motion
from .motion_table import read
from .predictions import ACCELEROMETER, at_chip, columns_at, followed
from .residuals import residuals
from .simulators import attitude_of, columns_of, gravity


# Quantities by which a motion is judged: the first of these that its file has
MAIN = ("attitude", "axis", "theta", "place", "omega3", "gyroscope", "accelerometer")
# Differences, in the unit of a quantity (rad of an attitude), whose first excess is reported; the
# key "0.1" in `leaves` is that of the last, and `benchmark.score` names all three in its table
LEVELS = (1e-3, 1e-2, 1e-1)
STEP = re.compile(r"(?:^|[^a-zA-Z])(?:dt|h|step)[=_-]?([0-9.]+(?:e-?[0-9]+)?)", re.IGNORECASE)
ROUNDING = 1e-13  # smaller differences have no order of convergence


class Compared(NamedTuple):
    """One motion with its reference.

    `compare` makes it, and `benchmark.score` for results of engines.

    Parameters
    ----------
    path
        The file.
    t
        Times [s], (rows,).
    curves
        Differences, (rows,) each, by quantity. Of `compare` also the signed differences of the
        relative changes of `energy` and `jellett`, which have no entry of these names in `numbers`.
    theta, reference
        theta of both [rad], (rows,); NaN if unknown.
    numbers
        The result as plain data, which `compare --json` prints: file, rows, from, until; what
        `size_of` returns of each quantity of `differences`; NAME_drift and NAME_error of conserved
        quantities; where they are known contact, reference_ended, suspicion. `benchmark.score`
        fills quantities only.
    """

    path: Path
    t: np.ndarray
    curves: Arrays
    theta: np.ndarray
    reference: np.ndarray
    numbers: PlainData

    @property
    def step(self) -> float | None:
        """Its time step [s] from the name of the file, or None."""
        match = STEP.search(self.path.stem)
        return float(match[1]) if match else None

    @property
    def main(self) -> str:
        """The quantity by which motions are judged."""
        return next(name for name in MAIN if name in self.curves)


def compare(problem: Problem, path: str | Path, convention: Convention) -> Compared:
    """Compare one table with the exact motion of a problem.

    Parameters
    ----------
    problem
        The reference.
    path
        A table, as `motion_table.read` takes it.
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
    table = read(path, wrapped=bool(problem.system.vectors), track=convention.track)
    t = table.t
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
    columns = columns_of(run.problem, run.times, run.rows)
    if {"omega", "orientation"} <= columns.keys():
        columns["gyroscope"] = in_body_axes(columns["orientation"], columns["omega"])
    theirs = {name: part[:rows] for name, part in motion(table, convention).items()}
    if "axis" in columns:
        columns |= {
            name: angle_in_picture(columns["axis"], name)
            for name in theirs
            if CAMERA.fullmatch(name)
        }
    if "accelerometer" in theirs:
        columns["accelerometer"] = specific_force(run, columns, convention.chip)
    known = {"t"} | theirs.keys() & columns
    if lost := [f"`{name}`" for name in table.columns if KIND.get(name, name) not in known]:
        raise InputError(
            f"`{path}`: every column must be comparable with the reference, but "
            f"{', '.join(lost)} cannot be: leave them out."
        )
    curves = differences(theirs, columns)
    if not set(MAIN) & curves.keys():
        raise InputError(
            f"`{path}` must have theta, an axis, a quaternion, a place, a spin or an accelerometer "
            "to be compared, but has none."
        )
    body = problem.body()
    kept = conserved(theirs, problem, body)
    # the exact energy changes too, by friction
    errors = {name: curve - _relative(columns[name]) for name, curve in kept.items()}
    numbers: PlainData = {
        "file": str(path),
        "rows": rows,
        "from": float(t[0]),
        "until": float(run.times[-1]),
    }
    numbers |= {name: size_of(run.times, curve) for name, curve in curves.items()}
    for what, changes in (("drift", kept), ("error", errors)):
        for name, curve in changes.items():
            numbers[f"{name}_{what}"] = float(np.nanmax(np.abs(curve)))
    numbers |= _contact(theirs, problem, body)
    if rows < len(t):
        numbers["reference_ended"] = run.reason
    if faults := _start_faults(numbers, curves, convention):
        numbers["suspicion"] = faults
    unknown = np.full(rows, np.nan)
    return Compared(
        Path(path),
        run.times,
        curves | errors,
        theirs.get("theta", unknown),
        columns.get("theta", unknown),
        numbers,
    )


def specific_force(run: Solution, columns: Arrays, chip: tuple[float, ...]) -> np.ndarray:
    """Return what an accelerometer in the body measures along its axes, (rows, 3) [m/s^2].

    `columns` are those of `simulators.columns_of`, read where the contact may change: the force of
    the contact is one of them only there. `chip` is the place of the accelerometer from the centre
    of mass, body axes [m]. Raises InputError for another place if the contact may change.
    """
    problem = run.problem
    if problem.contact is None:
        exact = followed(replace(problem, precision="double"), ())
        return at_chip(columns_at(exact, {}, run.times[None], ACCELEROMETER), chip)[0]
    if any(chip):
        raise InputError(
            f"`chip` must be 0,0,0 to be compared where the contact may change, but is {chip}."
        )
    return in_body_axes(columns["orientation"], columns["force"]) / problem.body().m


def differences(there: Mapping[str, np.ndarray], columns: Mapping[str, np.ndarray]) -> Arrays:
    """Return the differences of two motions by quantity, (rows,) each, not negative; NaN in gaps.

    Both are columns by name, SI: `there` of the other program, `columns` of the reference. That of
    an `orientation` is named `attitude`; a quantity that only one of them has is left out.
    """
    result: Arrays = {}
    for name in [name for name in there if name in columns]:
        off = residuals(name, there[name], columns[name]).reshape(len(columns["time"]), -1)
        given = np.isfinite(off).any(axis=1)
        size = np.sqrt(np.nansum(off**2, axis=1))
        if name == "axis":  # from chords
            size = 2 * np.arcsin(np.clip(size / 2, 0, 1))
        if given.any():
            result["attitude" if name == "orientation" else name] = np.where(given, size, np.nan)
    return result


def conserved(there: Arrays, problem: Problem, body: Any) -> Arrays:
    """Return by how much the other motion itself conserves energy and Jellett's integral.

    They are changes relative to the first value, (rows,) each, of the quantities that the columns
    of the motion and its surroundings allow. Names are those of columns of the reference, from
    which `compare` reads the exact changes.
    """
    attitude = attitude_of(there, body)
    others = {*groups_of(problem.surroundings)} - {"tilt"}
    if attitude is None or "omega" not in there or others:
        return {}
    w = there["omega"]
    L = np.stack(contact.momentum_of(Vector(*w.T), lies(attitude, body), body), axis=1)
    values = {}
    if problem.system.name.endswith("tippe-top"):
        L3 = (L * there["axis"]).sum(axis=1)
        values["jellett"] = contact.jellett_of(L[:, 2], L3, body)
    if {"velocity", "place"} <= there.keys():
        moving = body.m * (there["velocity"] ** 2).sum(axis=1) + (w * L).sum(axis=1)
        values["energy"] = moving / 2 - body.m * there["place"] @ gravity(body)
    return {name: _relative(value) for name, value in values.items() if np.isfinite(value).any()}


def _relative(values: np.ndarray) -> np.ndarray:
    """Return the changes of values (rows,) since the first finite one, relative to it."""
    return values / values[np.isfinite(values)][0] - 1


def _contact(there: Arrays, problem: Problem, body: Any) -> PlainData:
    """Return how deep the other motion penetrates the floor, and how high it rises from it [m].

    Both are under the key `contact` of `Compared.numbers`. {} if `there`, its columns by name, has
    no height or attitude; `body` is `b` in SI.
    """
    attitude = attitude_of(there, body)
    if problem.system.name == "heavy-top" or attitude is None or "place" not in there:
        return {}
    gap = there["place"][:, 2] + lowest(attitude, body)[:, 2]
    if not np.isfinite(gap).any():
        return {}
    return {
        "contact": {
            "penetration": float(max(0.0, -np.nanmin(gap))),
            "gap": float(max(0.0, np.nanmax(gap))),
        }
    }


def size_of(t: np.ndarray, curve: np.ndarray) -> PlainData:
    """Return numbers on the difference `curve` at times t [s], (rows,) each, for `compare --json`.

    They are the largest one, the time when it occurs (`at`), mean, root mean square, and `leaves`:
    by level of `LEVELS`, as text, the first time [s] when it is exceeded, or None. NaN is left out.
    `benchmark.score` and `orders_of` read them by these keys.
    """
    given = np.isfinite(curve)
    t = t[given]
    curve = curve[given]
    return {
        "max": float(curve.max()),
        "at": float(t[curve.argmax()]),
        "mean": float(curve.mean()),
        "rms": float(np.sqrt(np.mean(curve**2))),
        "leaves": {f"{level:g}": next(iter(t[curve > level].tolist()), None) for level in LEVELS},
    }


def shown(value: float | None, form: str = ".2g", missing: str = "-") -> str:
    """Return a number as text, and the text `missing` for None."""
    return missing if value is None else format(value, form)


def _start_faults(numbers: PlainData, curves: Arrays, convention: Convention) -> str:
    """Return a message if the first row differs from the start of the reference, or "".

    Only a table that begins at t = 0 is judged, by its angles.
    """
    known = "--up y: their z, x, y are our x, y, z" if convention.up == "y" else "z up"
    for name in ("attitude", "axis", "theta"):
        if name in curves and numbers["from"] == 0.0 and curves[name][0] > 0.01:
            return (
                f"the first row must be the start of the reference, but its {name} differs by "
                f"{curves[name][0]:.3g} rad: check the start, the frames ({known}) and the order "
                "of the quaternion."
            )
    return ""


def orders_of(compared: Sequence[Compared]) -> list[PlainData]:
    """Return the orders of convergence d log(error)/d log(step) between different steps.

    Errors are root mean squares over the time before the coarser motion first exceeds 0.1 (rad, or
    m of a place). Each has `steps`, and orders by quantity; `Verdict` prints and returns them. A
    motion whose file name has no step is left out.
    """
    stepped = [(c.step, c) for c in compared if c.step]
    stepped.sort(key=lambda pair: -pair[0])
    result = []
    for (long, coarse), (short, fine) in itertools.pairwise(stepped):
        if long == short:
            continue
        orders: PlainData = {"steps": [long, short]}
        for name in ("theta", "attitude", "axis", "place"):
            if name not in coarse.curves or name not in fine.curves:
                continue
            left = coarse.numbers[name]["leaves"]["0.1"]
            end = coarse.t[-1] if left is None else left
            errors = [np.sqrt(np.nanmean(c.curves[name][c.t <= end] ** 2)) for c in (coarse, fine)]
            if min(errors) > ROUNDING:
                orders[name] = math.log(errors[0] / errors[1]) / math.log(long / short)
        result.append(orders)
    return result


class Verdict:
    """Motions of another program compared with the exact one.

    `tippetop.compare` returns a public subclass, which describes the attributes.
    """

    def __init__(self, problem: Problem, files: Sequence[Path], convention: Convention):
        self.motions = tuple(compare(problem, file, convention) for file in files)
        self.orders = orders_of(self.motions)
        self.title = f"{problem.system.title}, {problem.form.name} form"

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, as `tippetop compare --json` prints it."""
        files = [{"step": m.step, **m.numbers} for m in self.motions]
        plain = files[0] if len(files) == 1 else {"files": files}
        return plain | {"orders": self.orders} if self.orders else plain

    def __str__(self) -> str:
        """Return the table of differences, remarks on files, and orders of convergence, as text."""
        lines = _table(self.motions)
        for m in self.motions:
            if "reference_ended" in m.numbers:
                lines.append(f"{m.path}: the reference ended: {m.numbers['reference_ended']}.")
            if "suspicion" in m.numbers:
                lines.append(f"{m.path}: {m.numbers['suspicion']}")
        for pair in self.orders:
            values = ", ".join(
                f"{name} {value:.2f}" for name, value in pair.items() if name != "steps"
            )
            coarse, fine = pair["steps"]
            lines.append(
                f"order of convergence from step {coarse:g} to {fine:g} s: "
                f"{values or 'none can be given'}"
            )
        return "\n".join(lines)

    __repr__ = __str__


def _table(motions: Sequence[Compared]) -> list[str]:
    """Return a table of motions, the best first, as lines; one motion is a column.

    A quantity that some motions lack is `-` in their rows.
    """
    from pandas import DataFrame

    ordered = sorted(motions, key=lambda m: m.numbers[m.main]["max"])
    rows = DataFrame(map(_row, ordered)).fillna("-")
    one = len(rows) == 1
    text = rows.T.to_string(header=False) if one else rows.to_string(index=False)
    return text.splitlines()


def _row(motion: Compared) -> dict[str, str]:
    """Return the numbers of one motion as text, by heading, in the order of the table.

    Quantities that its file lacks have no key: `_table` fills those that other motions have. The
    quantity `main` is not repeated among the errors at the end.
    """
    numbers = motion.numbers
    name = motion.main
    errors = {
        quantity: f"{numbers[quantity]['max']:.2g} {UNITS.get(quantity, 'rad')}"
        for quantity in motion.curves.keys() & numbers  # without energy and jellett
    }
    left = numbers[name]["leaves"]["0.1"]  # [s], of 0.1 in the unit of the quantity
    contact = numbers.get("contact")
    return {
        "file": motion.path.name,
        "largest error": f"{name} {errors.pop(name)}",
        "0.1 exceeded at": "never" if left is None else f"{left:.4g} s",
        "until": f"{numbers['until']:.4g} s",
        "error of energy": shown(numbers.get("energy_error")),
        "error of Jellett": shown(numbers.get("jellett_error")),
        "in the floor": f"{contact['penetration']:.2g} m" if contact else "-",
        **{f"error of {other}": errors[other] for other in sorted(errors)},
    }
