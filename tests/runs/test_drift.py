"""The drift that a run reports is that of its rows: told by runs that were made badly
on purpose.
"""

from collections.abc import Callable

import examples
import numpy as np
import pytest

from tippetop.engine.invariants import invariants, sizes
from tippetop.engine.observables import Observables
from tippetop.mechanics.units import ANGULAR_MOMENTUM
from tippetop.runs import starting
from tippetop.runs.certificate import contract_violations
from tippetop.runs.run import solve


Columns = dict[str, np.ndarray]


def momenta(column: Columns, p: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """L_3, and L_z about a point of the axis where the moment across it is I1."""
    L3 = p["I3"] * column["omega3"]
    return L3, p["I1"] * column["phi_dot"] * np.sin(column["theta"]) ** 2 + L3 * np.cos(
        column["theta"]
    )


def jellett(column: Columns, p: dict[str, float]) -> np.ndarray:
    """R L_z - alpha R L_3, about the centre of mass."""
    L3, Lz = momenta(column, p)
    return p["R"] * (Lz - p["alpha"] * L3)


def about_the_tip(p: dict[str, float]) -> dict[str, float]:
    return {**p, "I1": p["I1"] + p["m"] * p["l"] ** 2}


def vertical_momentum(column: Columns, p: dict[str, float]) -> np.ndarray:
    return momenta(column, about_the_tip(p))[1]


def energy(column: Columns, p: dict[str, float]) -> np.ndarray:
    """Of a heavy top about its fixed tip."""
    across = column["theta_dot"] ** 2 + (column["phi_dot"] * np.sin(column["theta"])) ** 2
    turning = about_the_tip(p)["I1"] * across + p["I3"] * column["omega3"] ** 2
    return turning / 2 + p["m"] * p["g"] * p["l"] * np.cos(column["theta"])


@pytest.mark.parametrize(
    ("scenario", "name", "formula"),
    [
        ("inverting", "jellett", jellett),
        ("heavy-top", "Lz", vertical_momentum),
        ("heavy-top", "energy", energy),
        ("heavy-top", "energy_balance", energy),
    ],
)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_the_drift_is_the_worst_relative_change(
    scenario: str, name: str, formula: Callable, tolerance: float
) -> None:
    sets = ["form=euler", f"run.tolerance={tolerance}", "run.output_step=0.0005"]
    run = solve(starting.load(scenario, sets, until=2.0))
    values = formula(examples.columns(run), run.problem.parameters)
    worst = np.abs(values / values[0] - 1).max()
    assert worst > 1e-12  # it was made badly
    assert run.report["drift"][name] == pytest.approx(
        worst, rel=0.05
    )  # rows, and the ends of steps


def sizes_of(*sets: str, scenario: str = "inverting") -> tuple[dict[str, float], dict[str, float]]:
    """What drifts are relative to, and the invariants at the start."""
    problem = starting.load(scenario, list(sets))
    values = Observables(problem).evaluate(problem.start()[None, :])
    both = sizes(problem, values), invariants(problem, values)
    return tuple({name: float(v[0]) for name, v in each.items()} for each in both)  # type: ignore[return-value]


@pytest.mark.parametrize("scenario", ["inverting", "rolling", "heavy-top", "round-cylinder"])
def test_a_drift_is_relative_to_the_start(scenario: str) -> None:
    size, start = sizes_of(scenario=scenario)
    assert size == {name: abs(value) for name, value in start.items()}


def test_a_drift_of_what_is_small_because_its_parts_cancel_is_relative_to_a_tenth_of_them() -> None:
    """lambda = R L_z - c L_3 where cos(theta) = alpha, as it is for a top that hardly spins: the
    unit is then m g R.
    """
    spins = ["initial.theta=1.2661036727794992", "initial.phi_dot=0.0", "initial.omega3=600.0"]
    problem = starting.load("inverting", spins)
    size, start = sizes_of(*spins)
    assert abs(start["jellett"]) < 1e-12
    momentum = problem.parameters["I3"] * 600.0 / float(problem.scales.of(ANGULAR_MOMENTUM))
    assert momentum > 5
    assert size["jellett"] == pytest.approx(0.1 * momentum, rel=1e-12)
    assert size["energy_balance"] == start["energy_balance"]
    assert sizes_of("initial.omega3=0.1")[0]["jellett"] == 0.1


SLOW = {
    "parameters": {
        "m": 1.53e-3,
        "R": 5.94e-3,
        "alpha": 0.817,
        "I1": 1.22e-8,
        "I3": 1.62e-8,
        "g": 9.82,
    },
    "initial": {"theta": 0.611, "phi_dot": 0.0, "omega3": -1.42},
}


def test_a_top_that_hardly_spins_keeps_the_contract() -> None:
    """It swings: L becomes ten thousand times the lambda that it is made of, whose rounding is no
    drift of 1e-12.
    """
    sets = [
        f"{table}.{name}={value}"
        for table, values in SLOW.items()
        for name, value in values.items()
    ]
    run = solve(starting.load("rolling", sets, until=50.0), keep=False)
    size, start = sizes_of(*sets, scenario="rolling")
    assert run.report["drift"]["jellett"] * size["jellett"] / abs(start["jellett"]) > 1e-13
    assert contract_violations(run.report, 0.0) == []
