"""The library leaves its host alone: it runs in any thread, keeps the host's signal handlers, and
stops when asked.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from plans import plan_of
from stores import assert_same, turning

import tippetop
from tippetop.errors import Interrupted
from tippetop.runs import recording, resuming
from tippetop.store import root
from tippetop.store.ledger import Ledger


PROBLEM = turning(20.0)
"""A run of some twenty slices."""


@pytest.fixture(autouse=True, scope="module")
def short_slices() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 256)
        yield


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, short_slices: None) -> Path:
    store = tmp_path_factory.mktemp("undisturbed") / "whole.zarr"
    recording.record(PROBLEM, store)
    return store


def elsewhere(work: Callable[[], Any]) -> Any:
    """Return what work returns in another thread, or raise what it raises there."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()


def after(slices: int, work: Callable[[], Any]) -> Callable[[object], None]:
    """A progress callback that does some work once, after so many slices."""
    left = [slices]

    def progress(_: object) -> None:
        left[0] -= 1
        if left[0] == 0:
            work()

    return progress


def test_a_run_stops_and_continues_in_any_thread(undisturbed: Path, tmp_path: Path) -> None:
    store, stop = tmp_path / "run.zarr", threading.Event()
    with pytest.raises(Interrupted):
        elsewhere(lambda: recording.record(PROBLEM, store, progress=after(2, stop.set), stop=stop))
    assert 0 < root.attributes(store)["report"]["t_end"] < 20
    stop.clear()
    with pytest.raises(Interrupted):
        elsewhere(lambda: resuming.resume(store, progress=after(2, stop.set), stop=stop))
    elsewhere(lambda: resuming.resume(store))
    assert_same(store, undisturbed)


def test_an_exception_frees_the_lock_and_leaves_what_can_be_resumed(
    undisturbed: Path, tmp_path: Path
) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
    store = tmp_path / "run.zarr"
    with pytest.raises(KeyboardInterrupt):
        recording.record(
            PROBLEM, store, progress=after(3, lambda: signal.raise_signal(signal.SIGINT))
        )
    Ledger.locked(store).release()
    assert [thread for thread in threading.enumerate() if thread.name.startswith("store")] == []
    resuming.resume(store)
    assert_same(store, undisturbed)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_host_keeps_its_handlers(
    number: signal.Signals, undisturbed: Path, tmp_path: Path
) -> None:
    seen: list[int] = []

    def mine(number: int, _: object) -> None:
        seen.append(number)

    before = signal.signal(number, mine)
    try:
        recording.record(
            PROBLEM, tmp_path / "run.zarr", progress=after(3, lambda: signal.raise_signal(number))
        )
        assert signal.getsignal(number) is mine
    finally:
        signal.signal(number, before)
    assert seen == [number]
    assert_same(tmp_path / "run.zarr", undisturbed)


def test_a_sweep_stops_and_continues_in_any_thread(tmp_path: Path) -> None:
    axis = {"of": "friction.mu", "values": [0.1, 0.2, 0.3, 0.4]}
    plan = plan_of(axis, set={"run": {"until": 0.2}}, chunk=2, runs=[1])
    store, stop = tmp_path / "S.zarr", threading.Event()
    seen: list[int] = []
    before = signal.signal(signal.SIGINT, lambda *_: seen.append(1))
    try:  # the host's own Ctrl-C is called, and the sweep goes its way
        tippetop.sweep(
            plan,
            tmp_path / "whole.zarr",
            workers=1,
            progress=lambda *_: signal.raise_signal(signal.SIGINT),
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(seen) == 3

    def one_chunk(done: int, of: int) -> None:
        if done == 2:
            stop.set()

    with pytest.raises(Interrupted):
        elsewhere(lambda: tippetop.sweep(plan, store, workers=1, progress=one_chunk, stop=stop))
    elsewhere(lambda: tippetop.sweep(plan, store, workers=1))
    assert_same(store, tmp_path / "whole.zarr")
