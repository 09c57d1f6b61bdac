"""Processes: the command line called in this one, in a fork of it, and a pool of forks that may
crash or hang.

A fork has everything imported and compiled already, so that an attack takes a fraction of a second;
the kernel kills it like any other process.
"""

import contextlib
import faulthandler
import io
import os
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any, NamedTuple

from verdict import Verdict


LIMIT = 60.0  # [s] an attack may take; what takes longer hangs


class Done(NamedTuple):
    """How a call of the command line ended; code -1: an error that nobody caught."""

    code: int
    out: str
    err: str

    @property
    def sentences(self) -> list[str]:
        """What it says on stderr, warnings aside."""
        lines = self.err.strip().splitlines()
        return [
            line for line in lines if line.strip() and not line.startswith("tippetop: warning:")
        ]

    def fault(self, allowed: tuple[int, ...]) -> Verdict | None:
        """What is wrong with it, whatever it was about: None if it ended as one of these exit codes
        should.
        """
        if self.code == -1 or "Traceback" in self.err:
            return Verdict("traceback", self.err[-3000:])
        if self.code not in allowed:
            return Verdict("unsaid", f"exit code {self.code}: {self.err[-500:]}")
        if self.code and not any(line.startswith("tippetop: ") for line in self.sentences):
            return Verdict("unsaid", f"exit code {self.code} without a sentence: {self.err[-500:]}")
        if odd := [line for line in self.sentences if not line.startswith("tippetop: ")]:
            return Verdict("unsaid", f"not a sentence of ours: {odd[0][:500]}")
        return None


def command(*words: object) -> Done:
    """The command line, called in this process."""
    from tippetop.cli import main

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([str(word) for word in words])
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
        except BaseException:
            code = -1
            traceback.print_exc()
    return Done(code, out.getvalue(), err.getvalue())


def forked(work: Callable[[], Any]) -> tuple[int, Connection]:
    """Begins work in a fork; its process, and where its result can be received."""
    here, there = Pipe(duplex=False)
    pid = os.fork()
    if pid:
        there.close()
        return pid, here
    code = 1
    try:
        here.close()
        there.send(work())
        code = 0
    except BaseException:
        with contextlib.suppress(BaseException):
            there.send(Done(-1, "", traceback.format_exc()))
    finally:
        os._exit(code)


def apart(work: Callable[[], Any]) -> Any:
    """The result of work that is done in a fork; None if it died."""
    pid, result = forked(work)
    try:
        return result.recv()
    except EOFError:
        return None
    finally:
        os.waitpid(pid, 0)


def _processor_time(pid: int) -> float:
    """Seconds that a process and its ended children have computed."""
    try:
        numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, numbers[11:15])) / os.sysconf("SC_CLK_TCK")


def _crowd() -> float:
    """Processes for each core, at least one."""
    return max(1.0, os.getloadavg()[0] / len(os.sched_getaffinity(0)))


class _Worker:
    """A fork that judges one case after the other."""

    def __init__(self, judge: Callable[[int, Path], Verdict], folder: Path):
        self.folder = folder
        self.log = folder.with_suffix(".log")
        self.pipe, child = Pipe()
        self.pid = os.fork()
        if self.pid:
            child.close()
            return
        try:
            os.setsid()
            self._work(judge, child)
        finally:
            os._exit(1)

    def _work(self, judge: Callable[[int, Path], Verdict], pipe: Connection) -> None:
        with self.log.open("w") as log:
            for stream in (1, 2):
                os.dup2(log.fileno(), stream)
            parent = os.getppid()
            while True:
                while not pipe.poll(1.0):
                    if (
                        os.getppid() != parent
                    ):  # it was killed, and another fork may hold its end of the pipe
                        return
                number = pipe.recv()
                shutil.rmtree(self.folder, ignore_errors=True)
                self.folder.mkdir()
                log.truncate(0)
                faulthandler.dump_traceback_later(LIMIT - 3, file=log)
                try:
                    verdict = judge(number, self.folder)
                except BaseException:
                    verdict = Verdict("traceback", traceback.format_exc()[-3000:])
                faulthandler.cancel_dump_traceback_later()
                pipe.send(verdict)

    def begin(self, number: int) -> None:
        """Gives it a case."""
        self.number, self.clock, self.spent = number, time.monotonic(), _processor_time(self.pid)
        self.pipe.send(number)

    def result(self) -> Verdict | None:
        """Its verdict; one on its own end if it died or hangs; None while it works."""
        verdict = None
        if self.pipe.poll():
            try:
                verdict = self.pipe.recv()
            except (EOFError, ConnectionError):
                _, status = os.waitpid(self.pid, 0)
                self.pid = 0
                verdict = Verdict("crash", f"status {status}: {self._said()}")
        elif self._hangs():
            verdict = Verdict("hang", self._said())
            self.end()
        if verdict is not None:
            verdict.number, verdict.seconds = self.number, time.monotonic() - self.clock
        return verdict

    def _hangs(self) -> bool:
        """Whether it takes longer than the limit, for which it may wait as long as the machine is
        crowded.
        """
        seconds, computed = time.monotonic() - self.clock, _processor_time(self.pid) - self.spent
        return computed > LIMIT or (seconds > LIMIT * _crowd() and computed <= LIMIT / 10)

    def _said(self) -> str:
        return self.log.read_text(errors="replace")[-4000:]

    def end(self) -> None:
        """Kills it, and what it began."""
        if self.pid:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
            self.pid = 0


def judged(
    judge: Callable[[int, Path], Verdict],
    count: int,
    until: float,
    folder: Path,
    first: int = 0,
    processes: int = 2,
) -> Iterator[Verdict]:
    """Verdicts on cases `first`, ...

    until they count for `count` tries, or the clock is past `until`.
    """
    tries, begun, number, parent = 0, 0, first, os.getppid()
    workers: list[_Worker] = []
    idle: list[_Worker] = []
    try:
        while True:
            while tries + begun < count and time.monotonic() < until and begun < processes:
                if not idle:
                    worker = _Worker(judge, Path(tempfile.mkdtemp(dir=folder)) / "case")
                    workers.append(worker)
                    idle.append(worker)
                idle.pop().begin(number)
                number, begun = number + 1, begun + 1
            if not begun or os.getppid() != parent:
                return
            busy = [w for w in workers if w.pid and w not in idle]
            wait([w.pipe for w in busy], timeout=0.5)
            for worker in busy:
                verdict = worker.result()
                if verdict is None:
                    continue
                begun, tries = begun - 1, tries + verdict.tries
                if worker.pid:
                    idle.append(worker)
                yield verdict
    finally:
        for worker in workers:
            worker.end()
