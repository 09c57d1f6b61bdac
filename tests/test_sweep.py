"""A sweep's store is the ensemble of its tops, bit by bit, whoever computes it and whatever interrupts it."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import zarr

import tippetop
from tippetop import archive, plan, pool, sweep_lines, sweep_map, sweeping
from tippetop.archive import StoreError
from tippetop.cli import outcome
from tippetop.plan import Plan
from tippetop.scenario import ScenarioError
from tippetop.sweep_report import open_sweep, report
from tippetop.sweeping import Unfinished


PLAN = """
scenario = "inverting"
set.run.until = 0.5
chunk = 7
runs = [5]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 175.0]
n = 6
[[axis]]
of = "friction.mu"
values = [0.3, 0.1, 0.2, 0.4]
"""
LINES = sweep_lines.lines


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "PLAN.toml"
    path.write_text(PLAN)
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store that nothing has disturbed."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "PLAN.toml").write_text(PLAN)
    tippetop.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "S.zarr"


def files(store: Path) -> dict[str, bytes]:
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def assert_same(store: Path, other: Path) -> None:
    mine, yours = files(store), files(other)
    assert sorted(mine) == sorted(yours)
    assert [name for name in mine if mine[name] != yours[name]] == []


def chunks(store: Path) -> list[int]:
    """What became of each chunk."""
    return np.asarray(zarr.open_group(store=str(store), mode="r")["chunk_status"]).tolist()


def written(store: Path) -> int:
    """How many chunks are done."""
    return chunks(store).count(1)


def computed(monkeypatch: pytest.MonkeyPatch, change: Callable[[int], None] = lambda chunk: None) -> list[int]:
    """The chunks that are computed from now on; `change` may raise for one of them."""
    seen: list[int] = []

    def lines(task: sweep_lines.Task, threads: int = 1) -> dict[str, np.ndarray]:
        seen.append(task.chunk)
        change(task.chunk)
        return LINES(task, threads)

    monkeypatch.setattr(sweep_lines, "lines", lines)
    return seen


# --- what is in it --------------------------------------------------------------------------------------------------


def test_the_columns_are_those_of_the_ensemble(whole: Path, file: Path) -> None:
    """In one go and in other chunks: the same bits."""
    of = plan.read(file)
    expected = tippetop.ensemble("inverting", of.columns(np.arange(of.n)), until=0.5, threads=1)
    found = open_sweep(whole)
    assert set(expected.variables) < set(found.variables)
    for name in expected.variables:
        assert found[name].values.tobytes() == expected[name].values.tobytes(), name
        assert found[name].attrs == expected[name].attrs
    assert set(found.coords) == {"initial.omega3", "friction.mu"}


def test_a_run_of_its_own_is_the_top(whole: Path) -> None:
    """The scalar integrator agrees with the lanes, in every variable at the end."""
    attrs, top = archive.attributes(whole / "runs" / "5"), open_sweep(whole).isel(top=5)
    assert attrs["initial"]["omega3"] == float(top["initial.omega3"])
    assert attrs["friction"]["mu"] == float(top["friction.mu"])
    for name, value in attrs["final_state"].items():
        scale = 1e-4 if name.startswith("L") else 1.0
        assert float(top[f"final_{name}"]) == pytest.approx(value, abs=1e-11 * scale), name


def test_gridded_has_the_axes_as_dimensions(whole: Path) -> None:
    table = open_sweep(whole)
    grid = tippetop.gridded(table[["theta_end", "class"]])
    assert grid["theta_end"].dims == ("initial.omega3", "friction.mu")
    for top in (0, 9, 23):
        one = table.isel(top=top)
        place = {key: float(one[key]) for key in grid.dims}
        assert float(grid["theta_end"].sel(place)) == float(one["theta_end"])


def test_absurd_tops_spoil_no_other(tmp_path: Path) -> None:
    axes = [
        {"of": "initial.omega3", "values": [155.0, float("nan"), 1e300, 150.0]},
        {"of": "friction.mu", "values": [0.3, -1.0]},
    ]
    of = plan.of({"scenario": "inverting", "set": {"run": {"until": 0.2}}, "axis": axes, "keep": ["final_state"]})
    found = tippetop.sweep(of, tmp_path / "S.zarr", workers=1)
    assert "class" not in found
    status = np.array(found["status"].attrs["flag_meanings"].split())[found["status"].values]
    assert status.tolist() == ["finished", *["invalid"] * 5, "finished", "invalid"]
    good = plan.of(
        {"scenario": "inverting", "set": {"run": {"until": 0.2}}, "axis": [{**axes[0], "values": [155, 150]}]}
    )
    alone = tippetop.sweep(good, tmp_path / "good.zarr", workers=1)
    for name in found:
        assert found[name].values[[0, 6]].tobytes() == alone[name].values.tobytes(), name
    faults = report(tmp_path / "S.zarr")["faults"]
    assert faults[0] == "top 1: `friction.mu` must be finite, at least 0, but is -1."
    assert {fault.split(":")[0] for fault in faults} == {f"top {i}" for i in (1, 2, 3, 4, 5)}


# --- what interrupts it ---------------------------------------------------------------------------------------------


class Stop(Exception):
    """Something ends the process."""


def test_gone_on_with_it_is_bit_identical(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(done: int, of: int) -> None:
        if done == 14:
            raise Stop

    store = tmp_path / "S.zarr"
    with pytest.raises(Stop):
        tippetop.sweep(file, store, workers=1, progress=stop)
    assert written(store) == 2
    assert report(store)["tops_done"] == 14
    assert report(store)["status"] == "running"
    seen, told = computed(monkeypatch), []
    tippetop.sweep(file, store, workers=1, progress=lambda *at: told.append(at))
    assert seen == [2, 3]
    assert told == [(14, 24), (21, 24), (24, 24)]
    assert_same(store, whole)
    tippetop.sweep(file, store, workers=1)
    assert seen == [2, 3]
    assert_same(store, whole)


def test_a_kill_between_data_and_status_is_no_harm(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every file that a chunk writes may be the last one."""
    write, store = zarr.Array.__setitem__, tmp_path / "S.zarr"
    files_per_chunk = len(open_sweep(whole).variables) + 1
    for last in (files_per_chunk + 5, files_per_chunk, files_per_chunk + 1, 12):
        count = [0]

        def killed(array: Any, at: Any, value: Any, count: list[int] = count, last: int = last) -> None:
            count[0] += 1
            if count[0] == last:
                raise Stop
            write(array, at, value)

        with monkeypatch.context() as patched:
            patched.setattr(zarr.Array, "__setitem__", killed)
            with pytest.raises(Stop):
                tippetop.sweep(file, store, workers=1)
        (store / "sweep" / "class" / "c" / "0.0123.partial").write_text("zarr was writing this")
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


@pytest.mark.parametrize("harm", ["flipped", "missing", "cut"])
def test_what_is_damaged_is_made_again(
    harm: str, whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "S.zarr"
    subprocess.run(["cp", "-r", str(whole), str(store)], check=True)
    victim = store / "sweep" / "theta_end" / "c" / "2"
    content = bytearray(victim.read_bytes())
    if harm == "missing":
        victim.unlink()
    else:
        content[len(content) // 2] ^= 4
        victim.write_bytes(content if harm == "flipped" else content[:-9])
    seen = computed(monkeypatch)
    tippetop.sweep(file, store, workers=1)
    assert seen == [2]
    assert_same(store, whole)


def test_a_full_disk_is_said_and_costs_nothing(whole: Path, file: Path, tmp_path: Path) -> None:
    store, limits = tmp_path / "S.zarr", resource.getrlimit(resource.RLIMIT_FSIZE)

    def full(done: int, of: int) -> None:
        if done == 7:
            resource.setrlimit(resource.RLIMIT_FSIZE, (64, limits[1]))

    try:
        with pytest.raises(StoreError, match=r"must be writable, but: File too large. What is stored is kept"):
            tippetop.sweep(file, store, workers=1, progress=full)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_a_chunk_that_fails_is_named_and_the_others_finish(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def poison(chunk: int) -> None:
        if chunk == 1:
            raise ArithmeticError("it will not do")

    store = tmp_path / "S.zarr"
    words = ["sweep", str(file), "--out", str(store), "--workers", "1", "--json"]
    with monkeypatch.context() as patched:
        assert computed(patched, poison) == []
        assert outcome(words) == 6
    said = capsys.readouterr()
    assert "chunk 1 (tops 7 to 13) failed: ArithmeticError: it will not do." in said.err
    assert "Go on with: tippetop sweep" in said.err
    found = json.loads(said.out)
    assert found["chunks"] == {"todo": 0, "done": 3, "failed": 1}
    assert found["failed"] == {"1": "ArithmeticError: it will not do"}
    assert outcome(words) == 0
    assert_same(store, whole)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_waits_for_the_store_and_the_way_on_is_said(
    number: int, code: int, whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    from tippetop import cli

    store = tmp_path / "S.zarr"
    handler = signal.signal(signal.SIGTERM, cli._terminate)
    try:
        with monkeypatch.context() as patched:
            computed(patched, lambda chunk: signal.raise_signal(number) if chunk == 2 else None)
            assert outcome(["sweep", str(file), "--out", str(store), "--workers", "1"]) == code
    finally:
        signal.signal(signal.SIGTERM, handler)
    assert f"Go on with: tippetop sweep {file} --out {store} --workers 1" in capsys.readouterr().err
    assert written(store) == 2
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_another_plan_is_refused(whole: Path, file: Path) -> None:
    file.write_text(PLAN.replace("175", "170"))
    with pytest.raises(StoreError, match="must be of the same plan to be gone on with, but differs in axis"):
        tippetop.sweep(file, whole)


def test_other_versions_are_refused(whole: Path, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = {**archive.versions(), "heyoka": "0"}
    monkeypatch.setattr(archive, "versions", lambda: found)
    with pytest.raises(StoreError, match="must be gone on with by the same versions"):
        tippetop.sweep(file, whole)


def test_there_is_one_writer(file: Path, tmp_path: Path) -> None:
    def second(done: int, of: int) -> None:
        tippetop.sweep(file, tmp_path / "S.zarr", workers=1)

    with pytest.raises(StoreError, match=r"must have one writer, but process [0-9]+ on .* is writing it"):
        tippetop.sweep(file, tmp_path / "S.zarr", workers=1, progress=second)


def test_something_else_is_left_alone(file: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    with pytest.raises(StoreError, match="must be a store of tippetop"):
        tippetop.sweep(file, tmp_path / "mine", workers=1)
    assert list((tmp_path / "mine").iterdir()) == []


def test_no_scheduler_no_store(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "CONNECT_FOR", "200 ms")
    for address in ("nonsense", "tcp://127.0.0.1:9"):
        with pytest.raises(ScenarioError, match="must be the address of a running dask scheduler"):
            tippetop.sweep(file, tmp_path / "S.zarr", scheduler=address)
    assert not (tmp_path / "S.zarr").exists()


# --- the workers of dask --------------------------------------------------------------------------------------------


def test_dask_makes_the_same_store(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its scheduler and two workers, as threads of this process; a chunk that fails, and then all."""
    from distributed import LocalCluster

    store = tmp_path / "S.zarr"
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp://", host="127.0.0.1"
    ) as cluster:
        with monkeypatch.context() as patched:
            patched.setattr(sweep_lines, "lines", failing)
            assert outcome(["sweep", str(file), "--out", str(store), "--scheduler", cluster.scheduler_address]) == 6
        assert "chunk 2 (tops 14 to 20) failed: ArithmeticError: it will not do." in capsys.readouterr().err
        assert chunks(store) == [1, 1, 2, 1]
        tippetop.sweep(file, store, scheduler=cluster.scheduler_address)
    assert_same(store, whole)


def failing(task: sweep_lines.Task, threads: int = 1) -> dict[str, np.ndarray]:
    """Raises for one chunk."""
    if task.chunk == 2:
        raise ArithmeticError("it will not do")
    return LINES(task, threads)


@pytest.mark.slow
def test_two_processes_make_the_same_store(whole: Path, file: Path, tmp_path: Path) -> None:
    tippetop.sweep(file, tmp_path / "S.zarr", workers=2)
    assert_same(tmp_path / "S.zarr", whole)


def start(file: Path, store: Path, *words: str) -> subprocess.Popen:
    code = "from tippetop.cli import main; main()"
    command = [sys.executable, "-c", code, "sweep", str(file), "--out", str(store), *words]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def children(process: subprocess.Popen) -> list[int]:
    """Its worker processes."""
    found = subprocess.run(["pgrep", "-P", str(process.pid), "-f", "spawn_main"], capture_output=True, text=True)
    return [int(word) for word in found.stdout.split()]


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A plan of 40 chunks of tenths of a second, and its undisturbed store."""
    folder = tmp_path_factory.mktemp("longer")
    text = PLAN.replace("0.5", "4.0").replace("n = 6", "n = 250").replace("chunk = 7", "chunk = 25")
    (folder / "PLAN.toml").write_text(text)
    tippetop.sweep(folder / "PLAN.toml", folder / "S.zarr", workers=1)
    return folder / "PLAN.toml", folder / "S.zarr"


def wait_for(store: Path, done: int) -> None:
    while not store.exists() or written(store) < done:
        time.sleep(0.05)


@pytest.mark.slow
def test_killed_workers_cost_nothing(longer: tuple[Path, Path], tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    process = start(longer[0], store, "--workers", "2")
    for done in (3, 12, 25):
        wait_for(store, done)
        os.kill(children(process)[0], signal.SIGKILL)
    _, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    assert_same(store, longer[1])


@pytest.mark.slow
def test_killed_itself_it_goes_on_with_any_number_of_workers(longer: tuple[Path, Path], tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    for done, workers in ((5, "2"), (14, "1"), (25, "3")):
        process = start(longer[0], store, "--workers", workers)
        wait_for(store, done)
        process.kill()
        process.communicate()
        assert written(store) < 40
    process = start(longer[0], store)
    assert process.communicate()[1] == ""
    assert_same(store, longer[1])


def deadly(task: sweep_lines.Task, threads: int = 1) -> dict[str, np.ndarray]:
    """Kills its worker for one chunk, raises for another."""
    if task.chunk == 1:
        os._exit(1)
    return failing(task, threads)


@pytest.mark.slow
def test_a_chunk_that_kills_its_workers_takes_no_other_with_it(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "S.zarr"
    with monkeypatch.context() as patched:
        patched.setattr(sweep_lines, "lines", deadly)
        with pytest.raises(Unfinished) as error:
            tippetop.sweep(file, store, workers=2)
    assert sorted(error.value.sentences) == [
        "chunk 1 (tops 7 to 13) failed: every worker that tried it died.",
        "chunk 2 (tops 14 to 20) failed: ArithmeticError: it will not do.",
    ]
    assert chunks(store) == [1, 2, 2, 1]
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


@pytest.mark.slow
def test_a_scheduler_may_die_too(longer: tuple[Path, Path], tmp_path: Path) -> None:
    store, address = tmp_path / "S.zarr", "tcp://127.0.0.1:8797"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "8797"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen([*dask, "--no-dashboard"], **quiet)
    workers = [subprocess.Popen([*worker, "--no-nanny"], **quiet) for _ in range(2)]
    try:
        process = start(longer[0], store, "--scheduler", address)
        wait_for(store, 4)
        workers[0].kill()
        wait_for(store, 10)
        scheduler.kill()
        _, err = process.communicate()
        assert process.returncode == 6
        assert "tippetop: the scheduler went away; what it gave back is stored." in err
    finally:
        for other in (scheduler, *workers):
            other.kill()
            other.wait()
    assert 10 <= written(store) < 40
    tippetop.sweep(longer[0], store, workers=1)
    assert_same(store, longer[1])


# --- what is said and drawn of it -----------------------------------------------------------------------------------


def test_the_commands_know_a_sweep(whole: Path, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["check", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["tops"], found["chunks"], found["tops_per_chunk"]) == (24, 4, 7)
    assert outcome(["info", str(whole), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["status"], found["tops_done"], found["runs"]) == ("finished", 24, [5])
    assert sum(found["counts"]["status"].values()) == sum(found["counts"]["class"].values()) == 24
    assert 0 < found["drift"]["jellett"]["worst"] < 1e-13
    assert outcome(["check", str(file)]) == outcome(["info", str(whole)]) == 0
    assert outcome(["info", str(whole / "runs" / "5"), "--json"]) == 0
    file.write_text(PLAN.replace("chunk", "chnk"))
    assert outcome(["sweep", str(file), "--out", str(tmp_path / "S.zarr")]) == 2
    assert not (tmp_path / "S.zarr").exists()
    assert outcome(["sweep", str(file), "--out", str(tmp_path / "S.zarr"), "--workers", "0"]) == 2


def test_exports_hold_every_column(whole: Path, tmp_path: Path) -> None:
    import pandas as pd

    table = open_sweep(whole)
    places = {to: tmp_path / f"S.{to}" for to in ("netcdf", "csv", "parquet")}
    for to, place in places.items():
        assert outcome(["export", str(whole), "--to", to, "--out", str(place)]) == 0
    with xr.open_dataset(places["netcdf"], group="sweep", engine="h5netcdf", decode_timedelta=False) as found:
        for name in table.variables:
            assert found[name].values.tobytes() == table[name].values.tobytes()
    for frame in (pd.read_csv(places["csv"], dtype={"final_Lz": str}), pd.read_parquet(places["parquet"])):
        assert list(frame)[:4] == ["initial.omega3", "friction.mu", "status", "class"]
        assert frame["class"].tolist() == [
            table["class"].attrs["flag_meanings"].split()[i] for i in table["class"].values
        ]
        np.testing.assert_array_equal(frame["final_Lz"].astype(float), table["final_Lz"])
    assert outcome(["export", str(whole), "--to", "csv", "--out", str(tmp_path / "E.csv"), "--group", "events"]) == 2


@pytest.mark.parametrize("kind", ["class", "inversion", "normal-force"])
def test_figures_of_a_sweep_are_drawn(kind: str, whole: Path, tmp_path: Path) -> None:
    assert outcome(["plot", str(whole), kind, "--out", str(tmp_path / "a.png")]) == 0
    assert (tmp_path / "a.png").stat().st_size > 15_000


def synthetic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, of: Plan, **columns: np.ndarray) -> sweep_map.Map:
    """A map of made-up columns."""
    table = xr.Dataset({name: ("top", values) for name, values in columns.items()})
    table["status"] = ("top", np.ones(of.n, np.int8))
    table = table.assign_coords({k: ("top", v) for k, v in of.design.numbers(np.arange(of.n)).items()})
    for axis in of.design.axes:
        table[axis.key].attrs = {"units": "1", "long_name": axis.key}
    table.attrs = {"plan": of.document, "status": "finished", "title": "sweep: a top"}
    monkeypatch.setattr(sweep_map, "open_sweep", lambda path: table)
    return sweep_map.mapped(tmp_path, next(k for k, v in sweep_map.NEEDED.items() if v[0] in columns))


def test_a_map_puts_every_top_in_its_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Descending and unsorted axes, a slice of a third; the field is a function of the numbers."""
    axes = [
        {"of": "initial.omega3", "linspace": [175.0, 100.0], "n": 16},
        {"of": "friction.mu", "values": [0.3, 0.1, 0.2]},
        {"of": "initial.theta", "values": [0.1, 0.2, 0.3]},
    ]
    of = plan.of({"scenario": "inverting", "axis": axes})
    w, mu, theta = of.design.numbers(np.arange(of.n)).values()
    found = synthetic(tmp_path, monkeypatch, of, inverted_at=w + 1000 * mu + 1e6 * theta)
    x, y = (axis.centres for axis in found.axes)
    np.testing.assert_allclose(x, np.linspace(100, 175, 16), rtol=1e-14)
    expected = x[:, None] + 1000 * y + 1e6 * 0.2
    np.testing.assert_allclose(found.fields["inverted_at"], expected, rtol=1e-13)
    assert found.notes == ["initial.theta = 0.2 (one of 3)"]


def test_borders_are_where_the_threshold_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over lambda itself the border of the inverted spin is the line lambda = 1."""
    axes = [{"of": "lambda", "linspace": [0.5, 2.0], "n": 5}, {"of": "gamma", "linspace": [0.75, 1.2], "n": 5}]
    of = plan.of({"scenario": "inverting", "axis": axes})
    found = synthetic(tmp_path, monkeypatch, of, inverted_at=np.zeros(of.n))
    values = found.borders["λ = λ_s: inverted spin stable above"]
    np.testing.assert_allclose(np.exp(values), np.broadcast_to(found.axes[0].span[:, None], values.shape), rtol=1e-12)
    assert np.nanmin(found.borders["λ = λ_t: tumbling possible above"]) < 0  # a fold below gamma_+ only
    gamma = found.axes[1].span
    assert np.isnan(found.borders["λ = λ_t: tumbling possible above"][:, gamma > 0.85]).all()


def test_drawn_axes_are_gathered_in_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    axes = [{"of": "initial.omega3", "between": [100, 200]}, {"of": "friction.mu", "between": [0.1, 1], "log": True}]
    sample = {"method": "sobol", "n": 4096, "seed": 1}
    of = plan.of({"scenario": "inverting", "axis": axes, "sample": sample})
    w, _ = of.design.numbers(np.arange(of.n)).values()
    found = synthetic(tmp_path, monkeypatch, of, **{"class": np.where(w < 150, 1, 3).astype(np.int8)})
    kinds = found.fields["class"]
    assert np.all(kinds[found.axes[0].edges[1:] < 150] == 1)
    assert np.all(kinds[found.axes[0].edges[:-1] > 150] == 3)
    assert found.notes == ["most frequent of the tops in a cell"]


def test_a_million_tops_are_mapped_in_seconds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: Any) -> None:
    from tippetop.figures import sweep as figures
    from tippetop.figures.style import save, styled

    axes = [{"of": "initial.omega3", "linspace": [100, 175], "n": 1000}, {**AXIS, "n": 1000}]
    of = plan.of({"scenario": "inverting", "axis": axes})
    found = synthetic(tmp_path, monkeypatch, of, **{"class": rng.integers(0, 6, of.n).astype(np.int8)})
    assert found.fields["class"].shape == (1000, 1000)
    with styled():
        save(figures.drawn(found), tmp_path / "a.png")


AXIS = {"of": "friction.mu", "geomspace": [0.1, 1.0]}


def test_what_cannot_be_drawn_is_said(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ScenarioError, match="must be one of class, inversion, normal-force of a sweep"):
        sweep_map.mapped(whole, "sphere")
    of = plan.of({"scenario": "inverting", "axis": [{**AXIS, "n": 4}]})
    with pytest.raises(ScenarioError, match="must have theta_end, but the plan did not keep it"):
        synthetic(tmp_path, monkeypatch, of, **{"class": np.zeros(4, np.int8)})


def test_dask_sleeps_until_workers_are_wanted() -> None:
    code = "import sys, tippetop.sweeping, tippetop.cli; assert not {'dask', 'distributed'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_without_dask_threads_do_it(whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweeping, "find_spec", lambda name: None)
    tippetop.sweep(file, tmp_path / "S.zarr", workers=2)
    assert_same(tmp_path / "S.zarr", whole)
    with pytest.raises(ScenarioError, match=r"install tippetop\[sweep\]"):
        tippetop.sweep(file, tmp_path / "S.zarr", scheduler="tcp://127.0.0.1:1")
