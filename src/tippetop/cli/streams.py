"""Standard output and standard error of the command line, which may be closed, full or narrow.

All commands print by it; a closed pipe ends them without a traceback.
"""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path
from typing import Any


def prepare() -> None:
    """Make the standard streams usable: escape characters that their encoding does not have.

    Closed ones (`>&-`) become the null device, because a store must not get their number.
    """
    while (fd := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(fd, True)
    os.close(fd)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name) or Path(os.devnull).open("w")  # noqa: SIM115
        setattr(sys, name, stream)
        with contextlib.suppress(AttributeError):  # the caller of `main` replaced it
            stream.reconfigure(errors="backslashreplace")


def visible(text: str) -> str:
    """Escape control characters, because a file may contain sequences that a terminal executes."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text
    )


def print_json(facts: Any) -> int:
    """Print plain data as one JSON object with null for non-finite numbers; return exit code 0."""
    import json

    from ..store.root import finite

    print(json.dumps(finite(facts), allow_nan=False))
    return 0


def report(sentence: str) -> None:
    """Print a sentence on standard error."""
    try:
        print(f"tippetop: {visible(sentence)}", file=sys.stderr)
    except OSError:
        _discard(2)


def complain(sentences: list[str], code: int) -> int:
    """Print sentences on standard error and return the exit code."""
    for sentence in sentences:
        report(sentence)
    return code


def flush(code: int) -> int:
    """Write the rest of the output at the end of the process.

    Return the exit code: `code`, or another one if standard output cannot be written.
    """
    try:
        sys.stdout.flush()
    except OSError as error:
        _discard(1)
        if not isinstance(error, BrokenPipeError):
            report(f"standard output must be writable, but: {error.strerror}.")
            return code or 5  # `cli.STORE`
    return code


def _discard(fd: int) -> None:
    """Send the rest of a stream to the null device, so that it is not tried again at exit."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, fd)
    os.close(null)
