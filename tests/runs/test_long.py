"""What long and accurate runs leave: wide numbers without loss, exports, and the contract."""

from pathlib import Path

import heyoka as hy
import numpy as np
import pytest
from refusals import refusal
from typed import reported, typed

from tippetop.problem import ROUNDING
from tippetop.runs import certificate, starting
from tippetop.runs.run import solve


@pytest.mark.parametrize(("precision", "bits"), [("longdouble", 63), ("quad", 105)])
def test_wide_rows_are_stored_without_losing_digits(precision: str, bits: int) -> None:
    """hi + lo gives the integrated number back to the bits that two doubles hold, unit conversion
    included.
    """
    problem = starting.load(
        "inverting", [f"run.precision={precision}", "run.output_step=0.1"], until=0.3
    )
    run = solve(problem)
    columns, weights = run.columns(), problem.weights()
    index = problem.variables.names.index("Lx")
    name = "state_Lx" if precision == "quad" else "L"
    high, low = (columns[n].values for n in (name, f"{name}_lo"))
    high, low = (v if v.ndim == 1 else v[:, 0] for v in (high, low))
    wide = np.array([hy.real128(h) + hy.real128(v) for h, v in zip(high, low, strict=True)])
    exact = np.array([hy.real128(v) * hy.real128(weights[index]) for v in run.rows[:, index]])
    error = np.array([float(abs(a - b) / abs(b)) for a, b in zip(wide[1:], exact[1:], strict=True)])
    assert error.max() < 2.0 ** (1 - bits)
    assert np.abs(low).max() > 0


def test_the_rows_of_a_run_without_rows_are_exported_if_they_are_named(tmp_path: Path) -> None:
    run, rows = tmp_path / "k.zarr", tmp_path / "rows.csv"
    keyframes = "--set run.output=keyframes --set run.output_step="
    assert typed(f"run inverting --until 1 {keyframes} --out {run}") == 0
    assert typed(f"export {run} --to csv --group trajectory --out {rows}") == 0
    assert "L_x [kg m2 s-1],L_y [kg m2 s-1],L_z [kg m2 s-1]" in rows.read_text()


def test_certify_is_kept_in_the_store(tmp_path: Path) -> None:
    path = tmp_path / "run.zarr"
    assert typed(f"run inverting --until 1 --certify --out {path}") == 0
    assert reported(f"info {path}")["certificate"]["window"] == [0.0, 1.0]


@pytest.mark.slow
def test_the_rolling_preset_keeps_its_contract_over_ten_thousand_seconds() -> None:
    problem = starting.load("rolling", ["run.output_step=1"], until=1e4)
    done = solve(problem, keep=False)
    assert not certificate.contract_violations(done.report, ROUNDING["double"])


@pytest.mark.parametrize("theta", [1.7e-4, 1.9e-5, np.pi - 1.7e-4])
def test_a_reduced_start_next_to_a_pole_is_refused(theta: float) -> None:
    near = [f"initial.theta={theta!r}"]
    with refusal('form = "vector" can'):
        starting.load("rolling", [*near, "form=reduced"])
    for form in ("auto", "vector", "contact"):
        starting.load("rolling", [*near, f"form={form}"])
