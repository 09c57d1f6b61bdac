"""A second Ctrl-C ends at once, without a traceback."""

import signal
import subprocess
import sys
import time


SLOW = """
import time
from tippetop import cli

def outcome(arguments):
    try:
        print("ready", flush=True)
        time.sleep(60)
    except KeyboardInterrupt:
        time.sleep(20)  # what is open is being closed
        return cli.INTERRUPTED

cli.outcome = outcome
cli.main([])
"""


def test_who_interrupts_twice_reads_no_traceback() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, text = process.communicate(timeout=10)
    assert process.returncode == 130
    assert text == ""
