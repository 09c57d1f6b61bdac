"""What integrated states mean: the columns of any rows are the system's formulas in SI units, row
by row.
"""

import examples
import numpy as np
import pytest

import tippetop as tt
from tippetop.engine import observables
from tippetop.engine.observables import Observables
from tippetop.mechanics.systems import SYSTEMS
from tippetop.problem import Problem
from tippetop.runs import starting


ROLLS = {"theta": 0.4, "theta_dot": 1.0, "phi_dot": 3.0, "omega3": 90.0}
SLIDES = {**ROLLS, "nu_x": 0.1, "nu_y": -0.2}
STARTS = {
    "tippe-top": SLIDES,
    "rolling-tippe-top": ROLLS,
    "gliding-heavy-top": SLIDES,
    "heavy-top": ROLLS,
    "gliding-cylinder": {"theta": 0.4, "theta_dot": 1.0, "nu_x": 0.1},
    "rolling-cylinder": {"theta": 0.4, "theta_dot": 1.0},
    "spheroid": SLIDES,
    "rolling-spheroid": ROLLS,
    "disc": SLIDES,
    "rolling-disc": ROLLS,
}
EVERY_FORM = [(name, form) for name in STARTS for form in SYSTEMS[name].forms]


def made(system: str, form: str, theta: float | None = None, **options: object) -> Problem:
    used = SYSTEMS[system]
    start = {**STARTS[system], **({} if theta is None else {"theta": theta})}
    law = ("viscous", {"mu": 0.3}) if used.frictional else ("none", {})
    numbers = examples.numbers_of(system)
    return examples.problem(system, numbers, start, 1.0, law, form=form, **options)


def at_start(problem: Problem) -> dict:
    """Return the columns of the start."""
    return Observables(problem).columns(np.zeros(1), np.array(problem.start())[None])


def rows_of(problem: Problem, rng: np.random.Generator, n: int = 7) -> np.ndarray:
    """Rows near the start; theta and its likes stay away from the poles."""
    start = np.array(problem.start(), dtype=float)
    return start * (1 + 0.01 * rng.uniform(-1, 1, (n, len(start))))


@pytest.mark.parametrize(("system", "form"), EVERY_FORM)
def test_the_start_reads_as_it_was_given(system: str, form: str) -> None:
    problem = made(system, form)
    columns = at_start(problem)
    for name, value in problem.initial.items():
        assert columns[name].values[0] == pytest.approx(value, rel=1e-12), name
    assert columns["time"].values.tolist() == [0.0]
    for name, column in columns.items():
        assert column.attrs["units"] is not None, name
        assert column.attrs["long_name"], name
        assert np.all(np.isfinite(column.values)), name


@pytest.mark.parametrize(("system", "form"), EVERY_FORM)
def test_columns_are_the_formulas_of_the_system_in_si_units(
    system: str, form: str, rng: np.random.Generator
) -> None:
    """Compiled over internal units, against numpy's formulas, scaled."""
    problem = made(system, form)
    view, rows = Observables(problem), rows_of(made(system, form), rng)
    columns, scalars = view.columns(np.arange(7.0), rows), view.moment(rows)
    assert {quantity.name for quantity in problem.system.quantities} <= set(columns)
    for quantity in problem.system.quantities:
        exact = np.broadcast_to(quantity.formula(scalars, view.body), 7) * float(
            problem.scales.of(quantity.unit)
        )
        found = columns[quantity.name].values
        np.testing.assert_allclose(
            found, exact, rtol=1e-12, atol=1e-13 * np.abs(exact).max(), err_msg=quantity.name
        )
        assert columns[quantity.name].attrs["units"] == quantity.unit.symbol


def test_the_bits_of_a_row_do_not_depend_on_its_neighbours(rng: np.random.Generator) -> None:
    """Neither on how many there are, in one block or several."""
    problem = made("tippe-top", "vector")
    rows = rows_of(problem, rng, observables.BLOCK + 13)
    view = Observables(problem)
    whole = view.evaluate(rows)
    for part in (slice(0, 1), slice(5, 8), slice(observables.BLOCK - 2, None)):
        for name, values in view.evaluate(rows[part]).items():
            assert values.tobytes() == whole[name][part].tobytes(), name


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_at_a_pole_angles_without_meaning_are_nan_and_nothing_else_is(theta: float) -> None:
    """Any azimuth would do there; the axis leaves a pole with its speed."""
    problem = made("tippe-top", "vector", theta=theta)
    record, _ = problem.variables.split(np.array(problem.start(), dtype=float))
    columns = at_start(problem)
    undefined = {name for name, column in columns.items() if np.any(np.isnan(column.values))}
    assert undefined == {"phi", "phi_dot", "nu_x", "nu_y", "psi"} & set(columns)
    assert columns["theta"].values[0] == theta
    assert record.ux == record.uy == 0.0


def test_psi_has_one_range_and_one_description_whether_it_is_an_angle_of_the_start_or_not() -> None:
    tables = [tt.run(name, until=0.2).trajectory for name in ("off-axis-top", "inverting")]
    assert tables[0].psi.long_name == tables[1].psi.long_name
    assert "in (-pi, pi]" in tables[0].psi.long_name
    for table in tables:
        assert table.psi.min() < -2.9 < 2.9 < table.psi.max() <= np.pi


@pytest.mark.parametrize("precision", ["longdouble", "quad"])
def test_wider_rows_give_the_columns_and_what_doubles_leave_out(precision: str) -> None:
    sets = [f"initial.{name}={value!r}" for name, value in STARTS["tippe-top"].items()]
    wide, plain = (
        starting.load("inverting", [*sets, f"run.precision={p}"]) for p in (precision, "double")
    )
    columns, others = at_start(wide), at_start(plain)
    for name, column in others.items():
        if name == "time":
            continue
        high, low = columns[name].values, columns[f"{name}_lo"].values
        np.testing.assert_allclose(high, column.values, rtol=1e-12, atol=1e-17, err_msg=name)
        assert np.all(np.abs(low[high != 0]) <= np.spacing(np.abs(high[high != 0])) / 2), name
        assert columns[f"{name}_lo"].attrs["units"] == column.attrs["units"]
    assert any(np.any(columns[f"{name}_lo"].values != 0) for name in others if name != "time")
