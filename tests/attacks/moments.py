"""When a process is killed: at a moment of its life, or right at one of its file operations."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from forking import Done, command, forked


OPERATIONS = {
    "os.rename",
    "os.link",
    "os.remove",
    "os.mkdir",
    "os.rmdir",
    "os.truncate",
    "attacks.fsync",
}
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
FRESH = 0.05  # of the cases: processes that are fresh interpreters


def _armed(at: int, after: float) -> None:
    """Kills this process at its `at`-th file operation, or `after` seconds later."""
    left, fsync = [at], os.fsync

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            mode, flags = arguments[1:3]
            writes = set(mode) & set("wxa+") if isinstance(mode, str) else flags & WRITING
            if not writes:
                return
        elif event not in OPERATIONS:
            return
        left[0] -= 1
        if left[0] == 0:
            if after > 0:
                signal.setitimer(
                    signal.ITIMER_REAL, after
                )  # its default is to end the process, as a kill does
            else:
                os.kill(os.getpid(), signal.SIGKILL)

    def audited(descriptor: int) -> None:
        sys.audit("attacks.fsync")
        fsync(descriptor)

    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    os.fsync = audited
    sys.addaudithook(hook)


def operations(words: list[object]) -> int:
    """How many file operations a command makes, run in a fork."""

    def counted() -> int:
        count, fsync = [0], os.fsync

        def hook(event: str, arguments: tuple[Any, ...]) -> None:
            if event == "open":
                mode, flags = arguments[1:3]
                count[0] += bool(
                    set(mode) & set("wxa+") if isinstance(mode, str) else flags & WRITING
                )
            else:
                count[0] += event in OPERATIONS

        def audited(descriptor: int) -> None:
            sys.audit("attacks.fsync")
            fsync(descriptor)

        os.fsync = audited
        sys.addaudithook(hook)
        done = command(*words)
        assert done.code == 0, done.err
        return count[0]

    pid, result = forked(counted)
    found = result.recv()
    os.waitpid(pid, 0)
    assert isinstance(found, int), found
    return found


def victim(words: list[object], when: dict[str, Any]) -> Done | None:
    """A command in a process that is killed at a moment; how it ended if it was faster
    than that.
    """
    if when["how"] == "fresh":
        tools = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "helpers")]
        chunks = (
            f"import sys; sys.path += {tools!r}; import undisturbed; "
            "undisturbed.many_chunks()"
        )  # as in the forks
        code = f"{chunks}; from tippetop.cli import main; main({[str(w) for w in words]!r})"
        process = subprocess.Popen(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        try:
            out, err = process.communicate(timeout=when["after"])
            return Done(process.returncode, out, err)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None

    def work() -> Done:
        if when["how"] == "operation":
            _armed(when["at"], when["after"])
        return command(*words)

    pid, result = forked(work)
    if when["how"] == "moment":
        result.poll(when["after"])
        os.kill(pid, signal.SIGKILL)  # it may have ended: then it waits for us
    try:
        return result.recv()
    except EOFError:
        return None
    finally:
        os.waitpid(pid, 0)


def moment(rng: np.random.Generator, count: int, seconds: float) -> dict[str, Any]:
    """When a command of so many file operations and seconds is killed, and how."""
    if rng.random() < FRESH:
        return {"how": "fresh", "after": float(rng.uniform(0.3, 3.0))}
    if rng.random() < 0.5:
        return {"how": "moment", "after": float(rng.uniform(0.0, seconds))}
    after = float(rng.choice([0.0, rng.uniform(1e-6, 5e-4)]))
    return {"how": "operation", "at": int(rng.integers(1, count + 1)), "after": after}
