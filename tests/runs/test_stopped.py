"""A run that was asked to stop before its first step makes none; what stands is certified as far as
it goes.
"""

import threading
from pathlib import Path

import pytest

import tippetop as tt


class After(threading.Event):
    """Is set once it was looked at so many times."""

    def __init__(self, looks: int):
        super().__init__()
        self.looks = looks

    def is_set(self) -> bool:
        self.looks -= 1
        return self.looks < 0


@pytest.fixture
def stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Makes the store of a run that stops when it has looked so often whether it shall."""
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 64)
    tt.run("rolling", until=1e-3)  # what is compiled looks too

    def make(looks: int) -> Path:
        place = tmp_path / f"{looks}.zarr"
        with pytest.raises(tt.Interrupted, match="continues it"):
            tt.run("rolling", until=2.0, out=place, stop=After(looks))
        return place

    return make


def test_a_run_that_is_told_to_stop_before_it_begins_makes_no_step(stopped) -> None:
    place = stopped(0)
    assert tt.open(place).summary.steps == 0
    with pytest.raises(tt.Interrupted):
        tt.resume(place, stop=After(0))
    assert tt.open(place).summary.steps == 0
    assert tt.resume(place).summary.status == "finished"
