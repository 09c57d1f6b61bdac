"""A sweep's store is the ensemble of its tops, bit by bit, whatever interrupts it."""

import json
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from forked import Forked
from nightly import at_night
from plans import PLAN
from refusals import refusal
from stores import assert_same, ended, written
from typed import typed

import tippetop
from tippetop.errors import StoreError
from tippetop.store import provenance, root
from tippetop.sweeps import chunk, workers
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.sweep_summary import gridded, open_sweep, report


LINES = chunk.compute_chunk


def computed(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[int], None] = lambda chunk: None
) -> list[int]:
    """The chunks that are computed from now on; `change` may raise for one of them."""
    seen: list[int] = []

    def compute(task: chunk.Task, threads: int = 1) -> chunk.Rows:
        seen.append(task.chunk)
        change(task.chunk)
        return LINES(task, threads)

    monkeypatch.setattr(chunk, "compute_chunk", compute)
    return seen


# --- what is in it ------------------------------------------------------------------------------


def test_the_columns_are_those_of_the_ensemble(whole: Path, file: Path) -> None:
    """In one go and in other chunks: the same bits."""
    of = Plan.from_toml(file)
    expected = tippetop.ensemble("inverting", of.columns(np.arange(of.n)), until=0.5, threads=1)
    found = open_sweep(whole)
    assert set(expected.variables) < set(found.variables)
    for name in expected.variables:
        assert found[name].values.tobytes() == expected[name].values.tobytes(), name
        assert found[name].attrs == expected[name].attrs
    assert set(found.coords) == {"initial.omega3", "friction.mu"}


def test_a_run_of_its_own_is_the_top(whole: Path) -> None:
    """The scalar integrator agrees with the lanes, in every variable at the end."""
    attrs, top = root.attributes(whole / "runs" / "5"), open_sweep(whole).isel(top=5)
    assert attrs["initial"]["omega3"] == float(top["initial.omega3"])
    assert attrs["friction"]["mu"] == float(top["friction.mu"])
    lanes_have = {name.removeprefix("final_") for name in top.variables}
    carried = set(attrs["final_state"]) - lanes_have  # what turns the body: lanes do without
    assert {"fx", "fy", "fz"} < carried
    for name, value in attrs["final_state"].items():
        if name in carried:
            continue
        scale = 1e-4 if name.startswith("L") else 1.0
        assert float(top[f"final_{name}"]) == pytest.approx(value, abs=1e-11 * scale), name


def test_gridded_has_the_axes_as_dimensions(whole: Path) -> None:
    table = open_sweep(whole)
    grid = gridded(table[["theta_end", "class"]])
    assert grid["theta_end"].dims == ("initial.omega3", "friction.mu")
    for top in (0, 9, 23):
        one = table.isel(top=top)
        place = {key: float(one[key]) for key in grid.dims}
        assert float(grid["theta_end"].sel(place)) == float(one["theta_end"])


# --- what interrupts it -------------------------------------------------------------------------


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


@pytest.mark.parametrize("harm", ["flipped", "missing", "cut"])
def test_what_is_damaged_is_made_again(
    harm: str, whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "S.zarr"
    subprocess.run(["cp", "-r", str(whole), str(store)], check=True)
    victim = store / "sweep" / "theta_end" / "c.2"
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


def test_a_full_disk_is_said_and_costs_nothing(
    whole: Path, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, limits = tmp_path / "S.zarr", resource.getrlimit(resource.RLIMIT_FSIZE)

    def full(done: int, of: int) -> None:
        if done == 7:
            monkeypatch.setattr(
                sys, "dont_write_bytecode", True
            )  # python would leave half of what it compiles
            resource.setrlimit(resource.RLIMIT_FSIZE, (64, limits[1]))

    try:
        with pytest.raises(
            StoreError, match=r"must be writable, but: File too large. Stored chunks are kept"
        ):
            tippetop.sweep(file, store, workers=1, progress=full)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_a_chunk_that_fails_is_named_and_the_others_finish(
    whole: Path,
    file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def poison(chunk: int) -> None:
        if chunk == 1:
            raise ArithmeticError("it will not do")

    store = tmp_path / "S.zarr"
    words = f"sweep {file} --out {store} --workers 1 --json"
    with monkeypatch.context() as patched:
        assert computed(patched, poison) == []
        assert typed(words) == 6
    said = capsys.readouterr()
    assert "chunk 1 (tops 7 to 13) failed: ArithmeticError: it will not do." in said.err
    assert "Continue with: tippetop sweep" in said.err
    found = json.loads(said.out)
    assert found["chunks"] == {"todo": 0, "done": 3, "failed": 1}
    assert found["failed"] == {"1": "ArithmeticError: it will not do"}
    assert typed(words) == 0
    assert_same(store, whole)


SIGNALLED = """
import signal
from tippetop.sweeps import chunk
compute = chunk.compute_chunk
def signalled(task, threads=1):
    if task.chunk == 2:
        signal.raise_signal({})
    return compute(task, threads)
chunk.compute_chunk = signalled
"""


@pytest.mark.parametrize(("number", "code"), [at_night(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_waits_for_the_store_and_the_way_on_is_said(
    number: int, code: int, whole: Path, file: Path, tmp_path: Path
) -> None:
    store = tmp_path / "S.zarr"
    words = f"sweep {file} --out {store} --workers 1"
    found, said = ended(Forked(words.split(), SIGNALLED.format(int(number))))
    assert found == code
    assert f"Continue with: tippetop {words}" in said
    assert written(store) == 2
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_another_plan_is_refused(whole: Path, file: Path) -> None:
    file.write_text(PLAN.replace("175", "170"))
    with pytest.raises(
        StoreError, match="must have the same plan to be continued, but differs in axis"
    ):
        tippetop.sweep(file, whole)


def test_other_versions_are_refused(
    whole: Path, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = {**provenance.versions(), "heyoka": "0"}
    monkeypatch.setattr(provenance, "versions", lambda: found)
    with pytest.raises(
        StoreError, match="must have the same versions to be continued, but differs in heyoka"
    ):
        tippetop.sweep(file, whole)


def test_no_scheduler_no_store(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "CONNECT_FOR", "200 ms")
    for address in ("nonsense", "tcp://127.0.0.1:9"):
        with refusal("must be the address of a running dask scheduler"):
            tippetop.sweep(file, tmp_path / "S.zarr", scheduler=address)
    assert not (tmp_path / "S.zarr").exists()
