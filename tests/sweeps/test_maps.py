"""What is said, exported and drawn of a sweep."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from plans import PLAN, all_numbers, plan_of
from refusals import refusal
from typed import reported, typed

import tippetop
from tippetop.columns import flag_words
from tippetop.ensembles.outcomes import CLASSES
from tippetop.figures.sweep_map import draw_map
from tippetop.mechanics.theory import thresholds
from tippetop.runs import starting
from tippetop.sweeps import maps
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.sweep_summary import open_sweep


AXIS = {"of": "friction.mu", "geomspace": [0.1, 1.0]}
LAMBDA = {"of": "lambda", "linspace": [0.5, 2.0], "n": 5}


def test_the_commands_know_a_sweep(whole: Path, file: Path, tmp_path: Path) -> None:
    found = reported(f"check {file}")
    assert (found["tops"], found["chunks"], found["tops_per_chunk"]) == (24, 4, 7)
    found = reported(f"info {whole}")
    assert (found["status"], found["tops_done"], found["runs"]) == ("finished", 24, [5])
    assert sum(found["counts"]["status"].values()) == sum(found["counts"]["class"].values()) == 24
    assert 0 < found["drift"]["jellett"]["worst"] < 1e-13
    assert typed(f"check {file}") == typed(f"info {whole}") == 0
    assert typed(f"info {whole}/runs/5 --json") == 0
    file.write_text(PLAN.replace("chunk", "chnk"))
    assert typed(f"sweep {file} --out {tmp_path}/S.zarr") == 2
    assert not (tmp_path / "S.zarr").exists()


def test_exports_hold_every_column(whole: Path, tmp_path: Path) -> None:
    import pandas as pd

    table = open_sweep(whole)
    places = {to: tmp_path / f"S.{to}" for to in ("netcdf", "csv", "parquet")}
    for to, place in places.items():
        assert typed(f"export {whole} --to {to} --out {place}") == 0
    with xr.open_dataset(places["netcdf"]) as found:
        for name in table.variables:
            assert found[name].values.tobytes() == table[name].values.tobytes()
    text = pd.read_csv(places["csv"], dtype=str)
    assert list(text)[:4] == ["initial.omega3 [rad s-1]", "friction.mu [s m-1]", "status", "class"]
    text.columns = [name.partition(" [")[0] for name in text]
    for frame in (text, pd.read_parquet(places["parquet"])):
        assert list(frame)[:4] == ["initial.omega3", "friction.mu", "status", "class"]
        assert frame["class"].tolist() == [*flag_words(table["class"])]
        np.testing.assert_array_equal(frame["final_Lz"].astype(float), table["final_Lz"])
    assert typed(f"export {whole} --to csv --out {tmp_path}/E.csv --group events") == 2


def test_figures_of_a_sweep_are_drawn(whole: Path, tmp_path: Path) -> None:
    assert typed(f"plot {whole} class --out {tmp_path}/a.png") == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def synthetic(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, of: Plan, **columns: np.ndarray
) -> maps.Map:
    """A map of made-up columns."""
    table = xr.Dataset({name: ("top", values) for name, values in columns.items()})
    table["status"] = ("top", np.ones(of.n, np.int8))
    table = table.assign_coords({k: ("top", v) for k, v in all_numbers(of).items()})
    for axis in of.design.axes:
        table[axis.of].attrs = {"units": "1", "long_name": axis.of}
    table.attrs = {"plan": json.dumps(of.document), "status": "finished", "title": "sweep: a top"}
    monkeypatch.setattr(maps, "open_sweep", lambda path: table)
    kinds = [k for k, v in maps.NEEDED.items() if v[0] in columns]
    return maps.make_map(tmp_path, kinds[-1])


@pytest.mark.parametrize(
    ("kind", "label"),
    [("inverted_at", "time of inversion t (s)"), ("lyapunov", "growth rate of an error (s⁻¹)")],
)
def test_a_map_puts_every_top_in_its_cell(
    kind: str, label: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Descending and unsorted axes, a slice of a third; the field is a function of the numbers."""
    axes = [
        {"of": "initial.omega3", "linspace": [175.0, 100.0], "n": 16},
        {"of": "friction.mu", "values": [0.3, 0.1, 0.2]},
        {"of": "initial.theta", "values": [0.1, 0.2, 0.3]},
    ]
    of = plan_of(*axes)
    w, mu, theta = all_numbers(of).values()
    found = synthetic(tmp_path, monkeypatch, of, **{kind: w + 1000 * mu + 1e6 * theta})
    x, y = (axis.centres for axis in found.axes)
    np.testing.assert_allclose(x, np.linspace(100, 175, 16), rtol=1e-14)
    expected = x[:, None] + 1000 * y + 1e6 * 0.2
    np.testing.assert_allclose(found.fields[kind], expected, rtol=1e-13)
    assert found.notes == ["initial.θ = 0.2 (one of 3)"]
    picture = draw_map(found).get_figure(root=True)
    assert label in [panel.get_ylabel() for panel in picture.axes]


def test_a_map_of_times_has_the_class_where_there_is_no_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A top that is still under way has not lifted off, nor has one that ended upright."""
    axes = [
        {"of": "initial.omega3", "linspace": [40.0, 80.0], "n": 5},
        {"of": "friction.mu", "values": [0.1, 0.3]},
    ]
    of = plan_of(*axes)
    kind = np.arange(of.n) % len(CLASSES)
    times = np.where(np.array(CLASSES)[kind] == "inverted", 3.0, np.nan)
    found = synthetic(
        tmp_path, monkeypatch, of, **{"inverted_at": times, "class": kind.astype(np.int8)}
    )
    ends = found.fields["class"]
    np.testing.assert_array_equal(np.isnan(ends), np.isfinite(found.fields["inverted_at"]))
    numbers = all_numbers(of)
    for top in np.flatnonzero(np.isnan(times)):
        i = int(np.argmin(np.abs(found.axes[0].centres - numbers["initial.omega3"][top])))
        j = int(np.argmin(np.abs(found.axes[1].centres - numbers["friction.mu"][top])))
        assert ends[i, j] == kind[top]


def test_borders_are_where_the_threshold_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over lambda itself the border of the inverted spin is the line lambda = 1."""
    of = plan_of(LAMBDA, {"of": "gamma", "linspace": [0.75, 1.2], "n": 5})
    found = synthetic(tmp_path, monkeypatch, of, inverted_at=np.zeros(of.n))
    values = found.borders["λ = λ_s: inverted spin stable above"]
    np.testing.assert_allclose(
        np.exp(values), np.broadcast_to(found.axes[0].span[:, None], values.shape), rtol=1e-12
    )
    tumbling = found.borders["λ = λ_t: tumbling possible above"]
    assert np.nanmin(tumbling) < 0  # a fold below gamma_+ only
    assert np.isnan(tumbling[:, found.axes[1].span > 0.85]).all()


def test_borders_of_pegs_are_named_after_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cells of the map reach beyond alpha = 0."""
    of = plan_of({"of": "parameters.alpha", "values": [-0.5, -0.1]}, LAMBDA)
    found = synthetic(tmp_path, monkeypatch, of, lyapunov=np.zeros(of.n))
    assert "λ = λ_s: upright spin stable above" in found.borders


def test_drawn_axes_are_gathered_in_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    axes = [
        {"of": "initial.omega3", "between": [100, 200]},
        {"of": "friction.mu", "between": [0.1, 1], "log": True},
    ]
    sample = {"method": "sobol", "n": 4096, "seed": 1}
    of = plan_of(*axes, sample=sample)
    w, _ = all_numbers(of).values()
    found = synthetic(
        tmp_path, monkeypatch, of, **{"class": np.where(w < 150, 1, 3).astype(np.int8)}
    )
    kinds = found.fields["class"]
    assert np.all(kinds[found.axes[0].edges[1:] < 150] == 1)
    assert np.all(kinds[found.axes[0].edges[:-1] > 150] == 3)
    assert found.notes == ["most frequent of the tops in a cell"]


def test_what_cannot_be_drawn_is_said(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    of = plan_of({**AXIS, "n": 4})
    with refusal("must have theta_end, but the plan did not keep it"):
        synthetic(tmp_path, monkeypatch, of, **{"class": np.zeros(4, np.int8)})


@pytest.mark.filterwarnings("ignore:the accuracy contract is broken by 1 of 7 tops")
def test_ends_change_at_the_analytic_thresholds(tmp_path: Path) -> None:
    """End upright below lambda_u, inverted above lambda_s, neither between, within 2 %."""
    body = starting.load("inverting").body()
    upright = thresholds.lambda_u(body) / thresholds.lambda_s(body)
    values = [*(upright * np.array([0.95, 0.98, 1.04])), 0.5, 0.98, 1.02, 1.05]
    axis = {"of": "lambda", "values": [float(v) for v in values]}
    start = {"run": {"until": 200.0}, "initial": {"theta": 0.02}, "friction": {"mu": 1.0}}
    found = tippetop.sweep(plan_of(axis, set=start), tmp_path / "S.zarr")
    names = flag_words(found["class"])
    assert names[:2].tolist() == ["upright"] * 2
    assert not {"upright", "inverted"} & set(names[2:5])
    assert names[5:].tolist() == ["inverted"] * 2
