"""Every table that is returned can be written to a file and read again, and printed in words."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from examples import CANONICAL
from refusals import refusal
from typed import typed

import tippetop as tt
from tippetop.errors import StoreError


@pytest.fixture(scope="module")
def run() -> tt.Run:
    """A run with every kind of table."""
    return tt.run("plastic-toy", until=0.3)


@pytest.fixture(scope="module")
def stored(run: tt.Run, tmp_path_factory: pytest.TempPathFactory) -> tt.StoredRun:
    return tt.open(run.save(tmp_path_factory.mktemp("stored") / "R.zarr"))


@pytest.fixture(scope="module")
def tables(
    run: tt.Run, stored: tt.StoredRun, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, xr.Dataset]:
    folder = tmp_path_factory.mktemp("tables")
    axis = {"of": "initial.omega3", "values": np.array([100.0, 150.0])}
    plan = {"scenario": "inverting", "set": {"run": {"until": 0.1}}, "axis": [axis]}
    top = tt.TippeTop(**CANONICAL)
    derived = tt.derivatives.sensitivities("inverting", ["mu", "omega3"], until=0.1)
    return {
        **run.datasets(),  # those of its store are equal, and are exported below
        "replay": stored.replay(0.0, 0.1, 0.01),
        "wide": tt.run(
            "inverting", until=0.01, precision="longdouble", columns=["theta", "axis"]
        ).trajectory,
        "ensemble": tt.ensemble("inverting", {"omega3": [100.0, np.nan]}, until=0.1),
        "sweep": tt.sweep(plan, folder / "S.zarr", workers=1),
        "gridded": tt.open(folder / "S.zarr", gridded=True),
        "sensitivities": derived.trajectory,
        "sensitivities of events": derived.events,
        "lyapunov": tt.derivatives.lyapunov("inverting", until=0.1),
        "surface": tt.landscapes.minimal_surface(top, D=[1e-6, 2e-6], lam=[1e-6, 2e-6]),
    }


@pytest.mark.parametrize("engine", [None, "scipy"])
def test_every_table_survives_a_file_of_netcdf(
    engine: str | None, tables: dict[str, xr.Dataset], tmp_path: Path
) -> None:
    how = {} if engine is None else {"engine": engine}
    for name, table in tables.items():
        file = tmp_path / f"{name}.nc"
        table.to_netcdf(file, **how)
        with xr.open_dataset(file, **how) as found:
            assert set(found.coords) == set(table.coords), name
            assert set(found.variables) == set(table.variables), name
            assert found.attrs.keys() == table.attrs.keys(), name
            for key, column in table.variables.items():
                np.testing.assert_array_equal(found[key], column, err_msg=f"{name}: {key}")
                assert found[key].attrs.get("units") == column.attrs.get("units"), (name, key)


def test_attributes_that_are_tables_are_texts_of_json(run: tt.Run, stored: tt.StoredRun) -> None:
    for table in (run.trajectory, stored.events):
        assert json.loads(table.attrs["parameters"]) == run.attributes["parameters"]


@pytest.mark.parametrize("to", ["nc", "csv", "parquet"])
def test_a_run_in_memory_and_the_command_write_the_same_file(
    to: str, run: tt.Run, stored: tt.StoredRun, tmp_path: Path
) -> None:
    name = {"nc": "netcdf"}.get(to, to)
    assert typed(f"export {stored.path} --to {name} --out {tmp_path}/command.{to}") == 0
    for each, of in (("memory", run), ("store", stored)):
        assert of.export(tmp_path / f"{each}.{to}") == tmp_path / f"{each}.{to}"
    if to == "nc":
        for group in run.datasets():
            memory, store, command = (
                xr.open_dataset(tmp_path / f"{each}.nc", group=group)
                for each in ("memory", "store", "command")
            )
            assert store.identical(command)
            assert set(memory.variables) == set(store.variables)
            assert memory.equals(store)
    else:
        texts = {file.read_bytes() for file in tmp_path.glob(f"*.{to}")}
        assert len(texts) == 1


def test_a_single_table_is_the_root_of_its_file(run: tt.Run, tmp_path: Path) -> None:
    with xr.open_dataset(run.export(tmp_path / "events.nc", group="events")) as found:
        np.testing.assert_array_equal(found.theta, run.events.theta)
        assert found.attrs["system"] == "tippe-top"


def test_a_wrong_export_is_refused(run: tt.Run, tmp_path: Path) -> None:
    with refusal(r"`path` must end with one of .nc, .csv, .parquet, .pq"):
        run.export(tmp_path / "run.xlsx")
    with refusal("`group` must be trajectory or events or phases"):
        run.export(tmp_path / "run.csv", group="event")
    run.export(tmp_path / "run.csv")
    with pytest.raises(StoreError, match="overwrite=True"):
        run.export(tmp_path / "run.csv")


def test_a_data_frame_has_words_and_components(tables: dict[str, xr.Dataset]) -> None:
    for name, table in tables.items():
        frame = tt.dataframe(table).reset_index()
        for key, column in table.variables.items():
            words = column.attrs.get("flag_meanings", "").split()
            if words:
                codes = set(column.values.ravel().tolist())
                assert set(frame[key]) == {words[code] for code in codes}, (name, key)
            elif letters := {"xyz", "wxyz"} & {*column.dims} - {key}:
                assert {f"{key}_{letter}" for letter in letters.pop()} < {*frame}, (name, key)
            else:
                assert key in frame or key in ("xyz", "wxyz"), (name, key)
    rows = tables["trajectory"]
    np.testing.assert_array_equal(tt.dataframe(rows)["axis_z"], rows["axis"].sel(xyz="z"))
    reasons = tt.dataframe(tables["phases"])["reason"]
    assert reasons.iloc[0] == "start"
    with refusal(r"`table` must be an xarray\.Dataset, but is 3"):
        tt.dataframe(3)  # type: ignore[arg-type]
