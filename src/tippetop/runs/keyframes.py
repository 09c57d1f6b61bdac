"""Keyframes: an integrator's exact state every so many steps, from which any part of a run can be
integrated again.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..engine.driver import Driver
from ..engine.observables import Observables
from ..engine.taylor import driver_of, fingerprint
from ..mechanics.units import SECOND
from ..problem import Problem


PER_CHUNK = 1024  # keyframes: 1 MB of 120 numbers each
EXACT = {"state": "state", "clock": "time", "carried": "carried"}
"""Columns of numbers of any precision, by the names in a snapshot."""
WORDS = {
    "state": "all that is integrated",
    "clock": "time in double length",
    "carried": "integrals between phases",
}
KNOWN = ("tally", "functions", "kept", "phase")
PARTS = {"double": 1, "longdouble": 2, "quad": 3}  # doubles that add up to a number exactly


def columns(problem: Problem, driver: Driver, t_end: float, steps: int) -> dict[str, Column]:
    """Return the present state as a row of the group `keyframes`.

    Parameters
    ----------
    problem, driver
        The run, at the end of a step.
    t_end, steps
        How far it has come [s], and in how many steps.

    Returns
    -------
    dict
        time [s]; the steps made; in internal units, as doubles that add up to the number: all that
        is integrated, and the time in double length; what the observer knows.
    """
    kept, number = driver.snapshot(), problem.number
    kept["state"] = [*kept["state"], *[number(0)] * (driver.width - len(kept["state"]))]
    exact = {
        name: _parts(np.array(kept[source], dtype=number), PARTS[problem.precision])
        for name, source in EXACT.items()
        if source in kept
    }
    known = np.concatenate(
        [np.ravel(np.array(kept[name], dtype=float)) for name in KNOWN if name in kept]
    )
    about = {
        "time": (np.array(t_end), "time", {"units": SECOND.symbol}),
        "step": (np.array(steps), "steps made", {}),
        "observer": (known, "numbers of the events, and of the phase of a contact", {}),
        **{
            name: (value, f"{WORDS[name]}: doubles to be added", {})
            for name, value in exact.items()
        },
    }
    about["state"] = (*about["state"][:2], {"equations": fingerprint(driver)})
    dims = {"state": ("variable", "part"), "clock": ("half", "part"), "observer": ("number",)}
    dims["carried"] = ("integral", "part")
    return {
        name: Column(
            ("keyframe", *dims.get(name, ())),
            value[None],
            {"units": "1", "long_name": words, **more},
        )
        for name, (value, words, more) in about.items()
    }


def rows(path: Path, problem: Problem) -> dict[str, Column]:
    """Return the start and the keyframes of a stored run as rows. Raises StoreError."""
    from ..store.root import loaded, open_group

    table = loaded(open_group(path, "keyframes"), path)
    columns = {str(name): variable.values for name, variable in table.variables.items()}
    start = problem.start()
    times = np.concatenate([[0.0], columns["time"]])
    if not problem.system.is_hybrid:
        states = _sum(columns["state"], problem.number)[:, : len(start)]
    else:
        driver = driver_of(problem)
        states = np.zeros((0, len(start)), problem.number)
        for k in range(len(times) - 1):
            restore(driver, {name: values[k] for name, values in columns.items()})
            states = np.vstack([states, driver.present()])
    return Observables(problem).columns(times, np.vstack([start, states]))


def empty(problem: Problem, driver: Driver) -> dict[str, Column]:
    """Return the columns of the group without rows."""
    row = columns(problem, driver, 0.0, 0)
    return {name: column._replace(values=column.values[:0]) for name, column in row.items()}


def restore(driver: Driver, row: dict[str, np.ndarray]) -> None:
    """Put a driver in the state of a keyframe."""
    exact = {EXACT[name]: _sum(row[name], driver.number) for name in EXACT if name in row}
    driver.restore(_known(driver, row["observer"]) | exact, exact["state"], tuple(exact["time"]))


def _known(driver: Driver, numbers: np.ndarray) -> dict[str, Any]:
    """What the observer knows, as `Driver.restore` takes it."""
    kinds, functions = driver.tallies.lane.dtype, driver.tallies.functions[:, :, 0]
    names = kinds.names or ()
    tally = [kinds[name].type(value).item() for name, value in zip(names, numbers, strict=False)]
    rest = numbers[len(tally) :]
    last = functions.size + len(driver.tallies.kept)
    return {
        "tally": tally,
        "functions": rest[: functions.size].reshape(functions.shape),
        "kept": rest[functions.size : last],
        "phase": rest[last:].tolist(),
    }


def _parts(values: np.ndarray, count: int) -> np.ndarray:
    """Numbers of any precision as so many doubles that add up to them, along a new last axis."""
    pieces = []
    for _ in range(count):
        pieces.append(values.astype(float))
        values = values - pieces[-1].astype(values.dtype)
    return np.stack(pieces, axis=-1)


def _sum(parts: np.ndarray, number: Any) -> np.ndarray:
    """The numbers that `_parts` split."""
    total = parts[..., 0].astype(number)
    for k in range(1, parts.shape[-1]):
        total = total + parts[..., k].astype(number)
    return total
