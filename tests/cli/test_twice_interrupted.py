"""A second Ctrl-C ends at once, without a traceback."""

import signal
import time
from pathlib import Path

import pytest
from forked import Forked
from stores import ended, wait_until


SLOW = """
import time
from tippetop import cli

def outcome(arguments):
    try:
        open("ready", "x").close()
        time.sleep(60)
    except KeyboardInterrupt:
        time.sleep(20)  # what is open is being closed
        return cli.INTERRUPTED

cli.outcome = outcome
cli.main([])
"""


def test_who_interrupts_twice_reads_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    process = Forked(prelude=SLOW)
    wait_until((tmp_path / "ready").exists, process)
    process.send_signal(signal.SIGINT)
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    assert ended(process) == (130, "")
