"""Test that acknowledged data survive a fault at every operation on the disk."""

import contextlib
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from faults import ONCE, WAYS, Faults, Over
from nightly import at_night
from stores import files, state_of, tiny_chunks

import tippetop as tt
from tippetop.errors import InputError, StoreError
from tippetop.landscape import landscape_body
from tippetop.landscape import surface_recording as surfaces
from tippetop.runs import replay, starting
from tippetop.sampling import EvenTimes
from tippetop.store.folder import Folder
from tippetop.store.ledger import LEDGER, Ledger


PLAN = """
scenario = "inverting"
set.run.until = 0.05
chunk = 2
keep = ["theta_max"]
[[axis]]
of = "initial.omega3"
values = [100.0, 120.0, 140.0, 160.0]
"""


def run(place: Path, **how: Any) -> None:
    tt.run("inverting", output_step=0.001, columns="theta", until=0.1, out=place, **how)


def resume(place: Path) -> None:
    """Continue a run, or begin it."""
    if not place.exists():
        run(place)
    else:
        unless("must be unfinished", lambda: tt.resume(place))


def unless(finished: str, work: Callable[[], object]) -> None:
    """Do some work, unless it is done."""
    try:
        work()
    except (StoreError, InputError) as error:
        if finished not in str(error):
            raise


def extend(place: Path) -> None:
    unless("must be later", lambda: tt.resume(place, until=0.2))


def surface(place: Path) -> None:
    body = landscape_body.top(starting.load("inverting").parameters)
    axes = np.linspace(-1e-4, 1e-4, 6), [0.0, 1e-5]
    unless("must not exist yet", lambda: surfaces.write(place, body, *axes, chunk=4))


def potential(place: Path) -> None:
    """Write a potential, unless it is there: what is there is compared with a whole one."""
    V = tt.landscapes.potential("inverting", z=np.linspace(-0.9, 0.9, 9), D=0.0, lam=1e-6)
    attrs = {"title": "effective potential"}
    unless("must not exist yet", lambda: surfaces.write_potential(place, V, attrs))


def tidied(work: Callable[[Path], object]) -> Callable[[Path], None]:
    """Return the work, after which the lock's new name goes: nothing opens such a store again."""

    def do(place: Path) -> None:
        work(place)
        (place / "writer.new").unlink(missing_ok=True)

    return do


def sweep(place: Path) -> None:
    (place.parents[1] / "PLAN.toml").write_text(PLAN)
    tt.sweep(place.parents[1] / "PLAN.toml", place, workers=1)


def replayed(place: Path) -> None:
    replay.into_store(
        place.parents[1] / "K.zarr", EvenTimes(0.001, 0.04, 0.02), place, overwrite=True
    )


def refused(place: Path) -> None:
    """Neither the old store nor the new one is lost: there is something to overwrite."""
    with pytest.raises(StoreError, match="must not exist yet"):
        run(place)


class Target(NamedTuple):
    work: Callable[[Path], object]
    again: Callable[[Path], object]
    before: Callable[[Path], object] = lambda _: None
    check: Callable[[Path], object] = lambda _: None


TARGETS = {
    "run": Target(run, resume),
    "extend": Target(extend, extend, run),
    "overwrite": Target(
        lambda p: run(p, overwrite=True), lambda p: run(p, overwrite=True), surface, refused
    ),
    "sweep": Target(sweep, sweep),
    "surface": Target(surface, tidied(surface)),
    "potential": Target(potential, tidied(potential)),
    "replay": Target(replayed, replayed),
}


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    tiny_chunks(monkeypatch)


@pytest.fixture
def acknowledged(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """What the last commit acknowledged: rows and chunks."""
    known, commit = [0], Ledger.commit

    def noted(store: Ledger, *given: Any, **record: Any) -> None:
        commit(store, *given, **record)
        known[0] = 0 if ".part-" in str(store.path) else extent(store.state)

    monkeypatch.setattr(Ledger, "commit", noted)
    return known


def extent(state: Any) -> int:
    return sum(state.rows.values()) + len(state.chunks)


@contextlib.contextmanager
def quietly() -> Iterator[None]:
    """Ignore warnings of removed scratch folders in this block."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*a killed run")
        yield


def campaign(
    target: Target,
    ways: tuple[str, ...],
    most: int,
    known: list[int],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> int:
    """Faults at operations spread over all, at most this many of each way; their number."""
    root, before = folder / "disk", folder / "before"
    place, tried = root / "S.zarr", 0
    run(folder / "K.zarr")
    root.mkdir()
    target.before(place)
    root.rename(before)

    def prepare() -> None:
        shutil.rmtree(root, ignore_errors=True)
        shutil.copytree(before, root)

    prepare()
    faults = Faults(monkeypatch, root)
    calm: dict[Any, tuple[int, dict[str, bytes]]] = {}  # number of operations, and the files
    for way in ways:
        counted = ONCE.get(way)
        if counted not in calm:
            prepare()
            faults.arm(10**9, way)
            target.work(place)
            faults.disarm()
            calm[counted] = faults.count, files(root)
        count, whole = calm[counted]
        stride = -(-(count + 1) // most)
        for at in range(1 + tried % stride, count + 2, stride):  # the last one is after the end
            prepare()
            known[0] = 0
            faults.arm(at, way)
            with quietly(), contextlib.suppress(StoreError, Over):
                target.work(place)
            faults.disarm()
            if known[0] or at > count:
                assert extent(state_of(place)) >= known[0], (way, at)
            with quietly():
                target.check(place)
                target.again(place)
            found = files(root)
            assert sorted(found) == sorted(whole), (way, at, {*found} ^ {*whole})
            assert [name for name in found if found[name] != whole[name]] == [], (way, at)
            tried += 1
    return tried


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize(("count", "least"), [(1, 5), at_night(10**6, 300)])
def test_what_was_acknowledged_survives_a_fault(
    name: str,
    count: int,
    least: int,
    small: None,
    acknowledged: list[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert campaign(TARGETS[name], WAYS, count, acknowledged, tmp_path, monkeypatch) > least


@pytest.mark.slow
@pytest.mark.parametrize("left_out", ["ledger", "names", "place"])
def test_a_sync_that_is_left_out_is_found(
    left_out: str,
    small: None,
    acknowledged: list[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The campaign can fail: of the ledger, of the names in a store, of the name of the store."""
    sync_one = Folder.sync_one

    def less(folder: Folder, name: str) -> None:
        if name != {"ledger": LEDGER, "names": ""}[left_out]:
            sync_one(folder, name)

    if left_out == "place":
        monkeypatch.setattr("tippetop.store.files.synced", lambda *_: None)
    else:
        monkeypatch.setattr(Folder, "sync_one", less)
    with pytest.raises((AssertionError, StoreError, FileNotFoundError)):
        campaign(TARGETS["run"], ("power",), 60, acknowledged, tmp_path, monkeypatch)
