"""Standard output and standard error of the command line: closed, full or narrow ones become a
sentence at most.
"""

from __future__ import annotations

import io
import os
import sys
from typing import Any

from ..errors import StoreError


class _Output(io.FileIO):
    """Standard output: what cannot be written is a StoreError."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise StoreError(
                f"standard output must be writable, but: {error.strerror or error}."
            ) from None


class _Errors(io.FileIO):
    """Standard error: what cannot be written is lost, because there is no other place to say so."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


def ready() -> None:
    """Makes the standard streams of this process usable, whatever they are.

    Closed ones (`>&-`) become the null device: no store may get their number, for others write to
    it. Characters that an encoding lacks are escaped.
    """
    fd = 0
    while fd <= 2:
        fd = os.open(os.devnull, os.O_RDWR)
        if fd <= 2:
            os.set_inheritable(fd, True)
    os.close(fd)
    if sys.stdout is sys.__stdout__:  # not where whoever called us put another
        sys.stdout = _text(_Output, 1, sys.stdout)
    if sys.stderr is sys.__stderr__:
        sys.stderr = _text(_Errors, 2, sys.stderr)


def _text(raw: type[io.FileIO], fd: int, old: Any) -> io.TextIOWrapper:
    """The text stream of a descriptor, encoded as `old`."""
    file = raw(fd, "w", closefd=False)
    encoding = getattr(old, "encoding", None) or "utf-8"
    line_buffering = fd == 2 or file.isatty()
    return io.TextIOWrapper(
        io.BufferedWriter(file), encoding, "backslashreplace", line_buffering=line_buffering
    )


def visible(text: str) -> str:
    """Escape control characters, because a file may contain sequences that a terminal executes."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text
    )


def print_json(facts: Any) -> int:
    """Print plain data as one JSON object, in which non-finite numbers are null; return the exit
    code.
    """
    import json

    from ..store.root import finite

    print(json.dumps(finite(facts), allow_nan=False))
    return 0


def report(sentence: str) -> None:
    """Print a sentence on standard error."""
    print(f"tippetop: {visible(sentence)}", file=sys.stderr)


def finished(code: int) -> int:
    """Writes what is left, at the end of the process; gives the exit code, which is another if that
    fails.
    """
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        pass
    except StoreError as error:
        report(str(error))
        code = code or 5
    else:
        return code
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)  # what could not be written goes nowhere, rather than be tried again at exit
    os.close(null)
    return code
