"""Integrate tops one after the other, each as a run of its own instead of in a lane.

For tops that lanes cannot follow, such as those of user-defined systems with phases.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanics.contact.surroundings import dotted_numbers
from ..mechanics.units import SECOND
from ..problem import TURN, Problem, Problems
from ..runs.run import solve
from ..sampling import ListedTimes
from ..scenario.contact import contact_faults, on_stem, touches
from .outcomes import SWINGS, Outcomes


def problem_of(tops: Problems, top: int) -> Problem:
    """Return the problem of one of the tops, by its number, to run alone; unchecked.

    Its only row is that of the end. A gap that its scenario did not give is that of this top.
    """

    def numbers(table: str) -> dict[str, Any]:
        """Return the numbers of this top in a table of the scenario."""
        given = tops.given(table)
        return {
            name: v if isinstance(v, bool) else float(v[top] if np.ndim(v) else v)
            for name, v in given.items()
        }

    base = tops.base
    tables = {table: numbers(table) for table in base.tables}
    parameters = tables["parameters"]
    initial = tables["initial"]
    until = tables["run"]["until"]
    rules = base.contact
    if rules is not None:
        rules = rules._replace(**tables["contact"], **tables.get("stem", {}))
    if touches(base) and "initial.gap" not in tops.columns:  # as in `checked_tops`
        initial.pop("gap", None)  # that of the base, whose angles and sizes may differ
        initial = on_stem(initial, parameters, rules)
    kept = base.columns
    if kept is not None and not tops.orientation:
        kept = tuple(name for name in kept if name not in TURN)
    return replace(
        base,
        parameters=parameters,
        friction=base.friction._replace(**tables["friction"]),
        initial=initial,
        surroundings=dotted_numbers(tables),
        contact=rules,
        until=until,
        times=ListedTimes(np.array([until])),
        output="times",
        columns=kept,
        orientation=tops.orientation,
    )


def checked_tops(tops: Problems) -> tuple[Problems, list[tuple[int, str]]]:
    """Return all tops with the gaps at which they begin, and faults that `Problems.checked` lacks.

    They are clashes of numbers, and those of a contact that may open: the number of a top, and the
    first sentence on it. `sweeps.sweep_summary` prints them too.
    """
    faults = []
    gaps = np.full(tops.n, np.nan)
    for top in np.flatnonzero(tops.valid).tolist():
        problem = problem_of(tops, top)
        gaps[top] = problem.initial.get("gap", 0.0)
        some = *problem.clashes(), *contact_faults(problem)  # sentences
        faults += [(top, sentence) for sentence in some[:1]]
    if touches(tops.base) and "initial.gap" not in tops.columns:  # as in `problem_of`
        tops = replace(tops, columns={**tops.columns, "initial.gap": gaps})
    return tops, faults


def run_each(
    outcomes: Outcomes, numbers: list[int], ended: Callable[[], None], *, events: bool = False
) -> None:
    """Run tops one after the other, and write their rows.

    Parameters
    ----------
    outcomes
        A row per top; tops that cannot be integrated are marked as invalid, by `refuse`.
    numbers
        Numbers of the tops.
    ended
        Called whenever a top has ended.
    events
        Whether events are logged.
    """
    for top in numbers:
        try:
            _run(outcomes, top, events)
        except InputError as error:
            outcomes.refuse(top, error.sentences[0])
        ended()


def _run(outcomes: Outcomes, top: int, logs: bool) -> None:
    """Run a top and write its row of `outcomes`, in internal units; `logs`: and its events.

    As `lanes._write` for tops in lanes: a change of one is a change of both. `_conclude` converts
    the columns of both to SI. Raises InputError if the top cannot be integrated.
    """
    problem = problem_of(outcomes.tops, top)
    second = problem.unit(SECOND)
    times = outcomes.times[top]
    wanted = np.flatnonzero(times >= 0)  # the others are before the start
    run = solve(replace(problem, times=ListedTimes(times[wanted] * second)))
    # a run that ends early has fewer rows
    outcomes.rows[top, wanted[: len(run.rows)]] = run.rows
    if logs:
        outcomes.events[top] = run.events
    end = run.progress
    values = {
        "t_end": end.t_end / second,
        "steps": end.steps,
        "normal_force_min": end.force.least,
        "normal_force_max": end.force.most,
        **{name: end.tally[name] for name in SWINGS},
        **{kept.name: value for kept, value in end.numbers},
    }
    # `_conclude` computes the columns for which a run has no number
    for name in outcomes.columns.keys() & values.keys():
        outcomes.columns[name][top] = values[name]
    outcomes.status[top] = run.status.code
    outcomes.final[:, top] = run.final
    outcomes.settled[top] = end.settled_since is not None
    for name, worst in end.drift.items():
        outcomes.drift[name][top] = worst
