"""How stores are compared, and how a command is waited for that may be stopped at any moment."""

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from forked import Forked

from tippetop.problem import Problem
from tippetop.runs import recording, starting
from tippetop.store import ledger, zarr3


TURNING = ["initial.phi_dot=10.0", "initial.theta=1.0", "initial.omega3=100.0", "friction.mu=0.0"]
"""A start of `inverting` that turns for ever."""
STEPS = 1024
"""Of a short slice: some 6 s of that motion."""
PRELUDE = f"""
import tippetop.runs.integration as i, tippetop.runs.recording as r
i.STEPS_PER_SLICE = {STEPS}
r.COMMIT_EVERY, r.ROWS_PER_CHUNK, r.EVENTS_PER_CHUNK = 0.02, 1000, 250
"""
"""Short slices, small chunks, frequent commits."""


def short_slices(
    monkeypatch: pytest.MonkeyPatch,
    commit_every: float = 0.0,
    steps: int = STEPS,
    rows: int = 1000,
    events: int = 250,
) -> None:
    """What PRELUDE does, with a commit after each slice, or after so many seconds."""
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", steps)
    monkeypatch.setattr(recording, "COMMIT_EVERY", commit_every)
    monkeypatch.setattr(recording, "ROWS_PER_CHUNK", rows)
    monkeypatch.setattr(recording, "EVENTS_PER_CHUNK", events)


def tiny_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slices of 8 steps, a commit after each, and chunks of some rows."""
    short_slices(monkeypatch, steps=8, rows=32, events=4)


def turning(until: float, *sets: str) -> Problem:
    """A run of that motion with a row every 0.01 s, if nothing else is set."""
    return starting.load("inverting", [*TURNING, "run.output_step=0.01", *sets], until)


def interrupted(store: Path, problem: Problem, slices: int = 1) -> Path:
    """Interrupt a run after this number of slices."""
    stop = Mock(side_effect=[*[None] * (slices - 1), KeyboardInterrupt])
    with pytest.raises(KeyboardInterrupt):
        recording.record(problem, store, progress=stop)
    return store


def files(store: Path) -> dict[str, bytes]:
    """Every file of a store, by its path inside."""
    return {
        str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()
    }


def assert_same(store: Path, other: Path) -> None:
    """Two stores hold the same files with the same bytes, and there are some."""
    mine, yours = files(store), files(other)
    assert mine
    assert sorted(mine) == sorted(yours)
    differ = [name for name in mine if mine[name] != yours[name]]
    assert not differ, f"the bytes of these files must be equal: {differ}"


def acknowledged(store: Path) -> int:
    """Return how many rows the ledger of a run acknowledges; -1 without a ledger."""
    return sum(state_of(store).rows.values()) if (store / ledger.LEDGER).exists() else -1


def state_of(store: Path) -> ledger.Acknowledged:
    """What the ledger of a store acknowledges, whether or not it is there."""
    return ledger.Acknowledged.of(ledger.records_of((store / ledger.LEDGER).read_bytes()))


def exchange(one: Path, other: Path) -> None:
    """Exchange two files; move one, if there is no other."""
    aside = one.rename(one.with_name("x"))
    if other.exists():
        other.rename(one)
    aside.rename(other)


def give_away(path: Path) -> None:
    """Make another user the owner of a file or folder."""
    if os.geteuid() != 0:
        pytest.skip("only root can give files away")
    os.chown(path, 65534, -1)


def flip(path: Path, byte: int) -> None:
    """Change one bit of a byte of a file."""
    data = bytearray(path.read_bytes())
    data[byte] ^= 1
    path.write_bytes(data)


def forge(store: Path, edit: Callable[[list[dict[str, Any]]], Any]) -> list[dict[str, Any]]:
    """Edit the records of a ledger, with digests that fit; return them."""
    place = store / ledger.LEDGER
    records = ledger.records_of(place.read_bytes())
    edit(records)
    before, whole = "", b""
    for record in records:
        before, line = ledger.lines([record], before)
        whole += line
    place.write_bytes(whole)
    return records


def edited(store: Path, edit: Callable[[list[dict[str, Any]]], Any]) -> None:
    """Edit the records of a ledger, and the documents that they describe."""
    for path, document in ledger.Acknowledged.of(forge(store, edit)).documents().items():
        (store / path / "zarr.json").write_bytes(zarr3.dump(document))


def chunks(store: Path) -> list[int]:
    """The status of each chunk of a sweep: 0 to be done, 1 done, 2 failed."""
    state = state_of(store)
    count = -(-state.attributes["tops"] // state.attributes["chunk"])
    return [
        1 if f"sweep/{k}" in state.chunks else 2 if f"sweep/{k}" in state.failed else 0
        for k in range(count)
    ]


def written(store: Path) -> int:
    """How many chunks of a sweep are done."""
    return chunks(store).count(1) if store.exists() else 0


Process = subprocess.Popen | Forked
Ended = tuple[int | None, str]


def ended(process: Process) -> Ended:
    """Exit code and stderr of a process, once it ends."""
    _, err = process.communicate()
    return process.returncode, err


def wait_until(condition: Callable[[], bool], process: Process | None = None) -> None:
    """Waits for a condition, as long as the process runs, if there is one."""
    while not condition():
        assert process is None or process.poll() is None, process.communicate()
        time.sleep(0.002)
