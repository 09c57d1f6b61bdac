"""Cached properties in processes that fork."""

import os
import signal
import threading
from typing import Any

import pytest
import xarray as xr

import tippetop as tt
from tippetop.runs import attributes


def test_a_child_forked_while_a_thread_reads_a_run_reads_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run, other = (tt.run("inverting", until=0.01) for _ in range(2))
    inside, leave = threading.Event(), threading.Event()

    def slow(*_: Any) -> xr.Dataset:
        inside.set()
        leave.wait(60)
        return xr.Dataset()

    monkeypatch.setattr(attributes, "dataset", slow)
    thread = threading.Thread(target=lambda: run.trajectory)
    thread.start()
    assert inside.wait(60)
    child = os.fork()
    if not child:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(20)
        monkeypatch.setattr(attributes, "dataset", lambda *_: xr.Dataset())
        os._exit(len(other.trajectory))
    leave.set()
    thread.join()
    assert os.waitpid(child, 0)[1] == 0
