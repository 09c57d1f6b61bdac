"""Rows flow in blocks that are bounded, however many lie in a step; what cannot be held
is refused.
"""

import threading
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refusal

from tippetop.errors import Interrupted
from tippetop.runs import integration, recording, starting
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve
from tippetop.runs.sinks import Memory


class Largest(Memory):
    """Makes rows as a store does, keeps none, and remembers the most at once."""

    most = count = 0

    def add_rows(self, times, states) -> None:
        self.most, self.count = max(self.most, len(times)), self.count + len(states)


def test_memory_does_not_grow_with_the_rows_of_a_slice() -> None:
    integrating, sink = (
        Integration(starting.load("inverting", ["run.output_step=1e-8"], until=0.01)),
        Largest(),
    )
    tracemalloc.start()
    integrating.run(sink)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert sink.count == 1_000_001
    assert sink.most <= integration.ROWS_PER_BLOCK
    assert peak < 100e6  # a million rows of 18 doubles are 144 MB


def test_blocks_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = starting.load("inverting", until=1.0)
    whole = solve(problem)
    monkeypatch.setattr(integration, "ROWS_PER_BLOCK", 7)
    blocks = solve(problem)
    np.testing.assert_array_equal(blocks.times, whole.times)
    np.testing.assert_array_equal(blocks.rows, whole.rows)


def test_rows_that_nobody_keeps_are_not_even_counted_through() -> None:
    """They are 1e12: it would not end."""
    done = solve(starting.load("inverting", ["run.output_step=1e-12"], until=1.0), keep=False)
    assert done.status.value == "finished"


def test_rows_that_memory_cannot_hold_are_refused() -> None:
    problem = starting.load("inverting", ["run.output_step=1e-11"], until=8.0)
    with refusal(r"must fit in .* of memory, but take .* give a store .--out, out=."):
        solve(problem)


def test_a_slice_of_many_rows_is_interrupted_before_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its rows, some 1e10, would take hours."""
    stop, rows = threading.Event(), recording.Recorder.add_rows

    def stopped_at_the_first(self: recording.Recorder, *block: Any) -> None:
        stop.set()
        rows(self, *block)

    monkeypatch.setattr(recording.Recorder, "add_rows", stopped_at_the_first)
    monkeypatch.setattr(recording, "PATIENCE", 0.2)
    problem = starting.load("inverting", ["run.output_step=1e-10"], until=8.0)
    with pytest.raises(Interrupted):
        recording.record(problem, tmp_path / "a.zarr", stop=stop)
