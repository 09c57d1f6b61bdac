"""What long and accurate runs leave: wide numbers without loss, exports, thin reading, and the
contract.
"""

import dataclasses
import json
from pathlib import Path

import heyoka as hy
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from tippetop.cli import outcome
from tippetop.errors import InputError
from tippetop.figures import theta
from tippetop.mechanics.operand import leaves, product_error
from tippetop.problem import ROUNDING
from tippetop.runs import certificate, recording
from tippetop.runs.run import solve
from tippetop.scenario import build
from tippetop.store import chunks


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("long") / "run.zarr"
    recording.record(build.load("inverting", until=7.0), path)
    return path


@pytest.mark.parametrize(("precision", "bits"), [("longdouble", 63), ("quad", 105)])
def test_wide_rows_are_stored_without_losing_digits(precision: str, bits: int) -> None:
    """hi + lo gives the integrated number back to the bits that two doubles hold, unit conversion
    included.
    """
    problem = build.load(
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


@pytest.mark.parametrize("to", ["netcdf", "csv", "parquet"])
def test_an_export_says_the_same_as_the_store(store: Path, tmp_path: Path, to: str) -> None:
    out = tmp_path / f"run.{to}"
    assert outcome(["export", str(store), "--to", to, "--out", str(out)]) == 0
    mine = xr.open_zarr(store, group="trajectory", consolidated=False)
    if to == "netcdf":
        theirs = xr.open_dataset(out, group="trajectory", engine="h5netcdf")
        assert theirs["theta"].attrs["units"] == "rad"
        np.testing.assert_array_equal(theirs["axis"], mine["axis"])
        events = xr.open_dataset(out, group="events", engine="h5netcdf")
        assert events.sizes["event"] > 300
        events.close()
    else:
        theirs = pd.read_parquet(out) if to == "parquet" else pd.read_csv(out)
        theirs.columns = [name.partition(" [")[0] for name in theirs]
        np.testing.assert_array_equal(theirs["axis_z"], mine["axis"][:, 2])
    for name in ("time", "theta", "jellett"):
        np.testing.assert_array_equal(theirs[name], mine[name])
    if to == "netcdf":
        theirs.close()


def test_an_export_of_events_names_their_kinds(store: Path, tmp_path: Path) -> None:
    out = tmp_path / "events.csv"
    assert (
        outcome(["export", str(store), "--to", "csv", "--group", "events", "--out", str(out)]) == 0
    )
    assert set(pd.read_csv(out)["kind"]) == {"turning", "equator", "inverted"}


def test_a_group_that_is_named_is_exported_alone(store: Path, tmp_path: Path) -> None:
    out = tmp_path / "events.nc"
    assert (
        outcome(["export", str(store), "--to", "netcdf", "--group", "events", "--out", str(out)])
        == 0
    )
    with xr.open_datatree(out, engine="h5netcdf") as tree:
        assert [group.name for group in tree.leaves] == ["events"]


def test_a_scenario_has_no_group_to_be_exported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "top.xml"
    assert (
        outcome(["export", "inverting", "--to", "mjcf", "--group", "events", "--out", str(out)])
        == 2
    )
    assert "--group must be left out with --to mjcf" in capsys.readouterr().err
    assert not out.exists()


def test_a_bad_export_is_said(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a"
    assert outcome(["export", str(store), "--to", "pdf", "--out", str(out)]) == 2
    out.write_text("mine")
    assert outcome(["export", str(store), "--to", "csv", "--out", str(out)]) == 5
    assert out.read_text() == "mine"
    assert "must not exist" in capsys.readouterr().err
    assert outcome(["export", str(store), "--to", "csv", "--out", str(out), "--overwrite"]) == 0
    assert out.read_text().startswith("time [s],")


def test_a_run_without_rows_is_exported_by_its_other_tables(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = [
        part for text in ("run.output=keyframes", "run.output_step=") for part in ("--set", text)
    ]
    run, rows = str(tmp_path / "k.zarr"), tmp_path / "rows.csv"
    assert outcome(["run", "inverting", "--until", "1", *sets, "--out", run]) == 0
    assert outcome(["export", run, "--to", "csv", "--out", str(rows)]) == 2
    assert (
        "must have rows to be exported, but has none: say --group events" in capsys.readouterr().err
    )
    assert outcome(["export", run, "--to", "csv", "--group", "trajectory", "--out", str(rows)]) == 0
    assert "L_x [kg m2 s-1],L_y [kg m2 s-1],L_z [kg m2 s-1]" in rows.read_text()


def test_a_thin_reading_loses_no_peak(store: Path) -> None:
    whole = chunks.digest(store, "trajectory", "theta")
    thin = chunks.digest(store, "trajectory", "theta", most=200)
    assert len(whole["theta"].values) == 7001
    assert len(thin["theta"].values) <= 210
    for extreme in (np.min, np.max):
        assert extreme(thin["theta"].values) == extreme(whole["theta"].values)
    assert thin["time"].values[-1] == whole["time"].values[-1]
    assert np.all(np.diff(thin["time"].values) > 0)
    assert thin["axis"].values.shape == (len(thin["time"].values), 3)


def test_a_certificate_measures_the_error_of_the_run() -> None:
    """Against a run that is spoiled on purpose, it must show the damage; against a good one, the
    promise holds.
    """
    problem = build.load("inverting", until=3.0)
    good = certificate.certificate(problem)
    assert good["theta"] < 1e-12
    assert good["turnings"]["time"] < 1e-12
    assert certificate.certificate_violations(good) == []
    spoiled = certificate.certificate(dataclasses.replace(problem, tolerance=1e-6))
    assert spoiled["theta"] > 100 * good["theta"]
    assert certificate.certificate_violations({**good, "theta": 1e-9})


def test_a_broken_promise_is_said_and_exits_with_4(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(certificate.MAX_DRIFT, "jellett", 1e-18)
    assert outcome(["run", "inverting", "--until", "1", "--json"]) == 4
    out, err = capsys.readouterr()
    assert "the accuracy contract is broken: the drift of jellett must be at most 1.0e-18" in err
    assert json.loads(out)["status"] == "finished"


def test_certify_is_kept_in_the_store(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.zarr"
    assert (
        outcome(
            ["run", "inverting", "--until", "2", "--certify", "--window", "1", "--out", str(path)]
        )
        == 0
    )
    capsys.readouterr()
    assert outcome(["info", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["certificate"]["window"] == [0.0, 1.0]


def test_check_advises_the_form_that_lasts(capsys: pytest.CaptureFixture[str]) -> None:
    """When it does: test_forecast."""
    sets = ("form=vector", "run.output_step=10", "run.until=1e6")
    assert outcome(["check", "rolling", *(word for each in sets for word in ("--set", each))]) == 0
    advice = " ".join(capsys.readouterr().out.split())  # however it is wrapped
    assert 'form = "reduced" with tolerance = 1e-18 keeps it' in advice


def unevenness(parameter: float, rng: np.random.Generator) -> float:
    """The mean error of rounding a product with a parameter, in its standard
    deviations, at worst.
    """
    found = []
    for low in np.linspace(0.5, 0.95, 10):
        x = rng.uniform(low, low + 0.05, 100_000)
        errors = product_error(parameter, x) / np.spacing(parameter * x)
        found.append(abs(errors.mean()) / max(errors.std() / np.sqrt(x.size), 1e-30))
    return max(found)


@pytest.mark.slow
def test_the_rolling_preset_keeps_its_contract_over_ten_thousand_seconds() -> None:
    problem = build.load("rolling", ["run.output_step=1"], until=1e4)
    done = solve(problem, keep=False)
    assert not certificate.contract_violations(done.report, ROUNDING["double"])


def test_the_rolling_preset_is_integrated_in_the_form_that_keeps_its_contract() -> None:
    assert build.load("rolling").form.name == "contact"


@pytest.mark.parametrize("theta", [1.7e-4, 1.9e-5, np.pi - 1.7e-4])
def test_a_reduced_start_next_to_a_pole_is_refused(theta: float) -> None:
    near = [f"initial.theta={theta!r}"]
    with pytest.raises(InputError, match='form = "vector" can'):
        build.load("rolling", [*near, "form=reduced"])
    for form in ("auto", "vector", "contact"):
        build.load("rolling", [*near, f"form={form}"])


@pytest.mark.parametrize("theta", [1e-3, np.pi - 1e-3])
def test_a_reduced_start_that_is_allowed_keeps_theta(theta: float) -> None:
    runs = [
        solve(
            build.load(
                "rolling", [f"initial.theta={theta!r}", f"form={form}", "run.output_step=0.01"]
            )
        )
        for form in ("vector", "reduced")
    ]
    vector, reduced = (run.columns()["theta"].values for run in runs)
    np.testing.assert_allclose(reduced, vector, rtol=0, atol=5e-15 / 1e-3)


def test_products_with_the_parameters_of_the_reduced_form_round_evenly(
    rng: np.random.Generator,
) -> None:
    """With alpha = 3/10 and I3 = 2/5, as in the other forms, they do not: that drives energy one
    way in long runs.
    """
    reduced, vector = (
        [float(p) for p in leaves(build.load("rolling", [f"form={form}"]).internal_body)]
        for form in ("reduced", "vector")
    )
    assert max(unevenness(p, rng) for p in reduced) < 6
    assert sum(unevenness(p, rng) > 30 for p in vector) == 2


def test_a_band_of_more_turnings_than_can_be_seen_is_one_piece(rng: np.random.Generator) -> None:
    """Thinned logs have gaps everywhere: a piece for each took 10 ms to draw."""
    t = np.cumsum(rng.exponential(1.0, (25_000, 2)).ravel())
    low, high = (t[::2], np.full(25_000, 0.5)), (t[1::2], np.full(25_000, 1.0))
    assert (
        len(theta.bands(tuple(x[:500] for x in low), tuple(x[:500] for x in high), np.empty(0)))
        > 10
    )
    ((when, bottom, top),) = theta.bands(low, high, np.empty(0))
    assert (when[0], when[-1]) == (t[0], t[-1])
    assert (bottom == 0.5).all()
    assert (top == 1.0).all()
