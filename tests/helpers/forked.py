"""The command line in a process of its own that finds everything imported: a fork of
multiprocessing's server.

Whatever stops or kills it cannot tell it from one that an interpreter began, 1.5 processor seconds
earlier. What is about the start or the end of an interpreter takes `subprocess`.
"""

import multiprocessing
import os
import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path


SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(
    [
        "tippetop.cli.run_command",
        "tippetop.runs.recording",
        "tippetop.runs.resuming",
        "tippetop.runs.forecast",
        "tippetop.engine.hybrid",
        "tippetop.library.finished_run",
        "pint",
        "xarray",
    ]
)


def _work(
    arguments: Sequence[str], prelude: str, environment: dict[str, str], folder: str, streams: Path
) -> None:
    """In the fork."""
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(streams / name, os.O_WRONLY | os.O_CREAT, 0o600), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    exec(prelude, {})
    if arguments:
        from tippetop.cli import main

        main(list(arguments))


class Forked:
    """A command that has begun, in the environment and the folder of whoever begins it; used as
    `subprocess.Popen` is.

    Parameters
    ----------
    arguments
        Its words; none: the Python before them is all.
    prelude
        Python that runs before it.
    """

    def __init__(self, arguments: Sequence[str] = (), prelude: str = ""):
        self._streams = Path(tempfile.mkdtemp())  # among the temporary files of the session
        for name in ("out", "err"):
            (self._streams / name).touch()
        given = arguments, prelude, dict(os.environ), os.getcwd(), self._streams
        self._process = SERVER.Process(target=_work, args=given, daemon=True)
        self._process.start()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def poll(self) -> int | None:
        """Its exit code; minus a signal that killed it; None while it runs."""
        return self._process.exitcode

    @property
    def returncode(self) -> int | None:
        """As of `poll`."""
        return self.poll()

    def send_signal(self, number: int) -> None:
        """Sends it a signal, if it still runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kills it."""
        self.send_signal(signal.SIGKILL)

    def communicate(self) -> tuple[str, str]:
        """What it printed and what it said on stderr, once it ends."""
        self._process.join()
        out, err = ((self._streams / name).read_text() for name in ("out", "err"))
        return out, err
