"""The command line: arguments become calls, errors become sentences and an exit code.

Imports wait until something needs them: `tippetop --help` takes no longer than to start Python.
"""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

from .. import awaiting
from . import overview, streams


DONE, BUG, USAGE, PHYSICS, ACCURACY, STORE, CHUNKS, INTERRUPTED, TERMINATED = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    130,
    143,
)
THE_DISKS = {  # errors of the system that are no bug of ours, wherever they come from
    *(errno.ENAMETOOLONG, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO),
    *(errno.EACCES, errno.EPERM, errno.ELOOP, errno.EMFILE, errno.ENFILE, errno.ENOTDIR),
}

_received: list[int] = []  # exit codes of the signals that came


def _interrupt(*_: Any) -> NoReturn:
    if _received:
        os._exit(_received[0])  # somebody is in a hurry: what was acknowledged is on the disk
    _received.append(INTERRUPTED)
    raise KeyboardInterrupt


def _terminate(*_: Any) -> NoReturn:
    _received.append(TERMINATED)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough: what is open is being closed
    raise SystemExit(TERMINATED)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Runs the command line and exits with one of `reference.EXIT_CODES`."""
    streams.ready()
    gc.set_threshold(
        100_000
    )  # to look a hundred times through what is imported takes a tenth of a start
    signal.signal(signal.SIGTERM, _terminate)
    warnings.showwarning = _warn  # type: ignore[assignment]
    signal.signal(signal.SIGINT, _interrupt)
    try:
        code = outcome(arguments)
    except Exception:
        if not _received:
            raise
        code = complain(
            ["interrupted while it was loaded."], _received[0]
        )  # an import makes an ImportError of it
    except SystemExit as stopped:
        if stopped.code == TERMINATED and _received:
            complain(["terminated; what was written to disk stays."], TERMINATED)
        code = stopped.code if isinstance(stopped.code, int) else BUG
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # only what is printed is left
    code = streams.finished(code)
    if awaiting.abandoned():
        os._exit(
            code
        )  # a compilation still runs in its thread, and the interpreter would wait for it
    sys.exit(code)


def _warn(message: Warning | str, *_: Any) -> None:
    """A warning of a library as one line of ours on stderr, without the place in the library's
    source.
    """
    streams.report(f"warning: {' '.join(str(message).split())}")


def outcome(arguments: Sequence[str] | None = None) -> int:
    """What `main` exits with."""
    words = sys.argv[1:] if arguments is None else [*arguments]
    try:
        if (answer := overview.answer(words)) is not None:
            print(answer)
            return DONE
        from .application import called

        return called(words)
    except KeyboardInterrupt:
        return complain(["interrupted; nothing more was stored."], INTERRUPTED)
    except BrokenPipeError:  # the reader of our output went away
        return DONE
    except Exception as error:
        known = _known_errors(error)
        if known is None:
            raise
        return known


def _known_errors(error: Exception) -> int | None:
    """Exit code of an error that is the user's or the machine's, after printing it;
    None for a bug.
    """
    from ..errors import BuildError, InputError, StoreError, missing_extra

    if isinstance(error, ImportError) and (sentence := missing_extra(error)):
        return complain([sentence], USAGE)
    if isinstance(error, BuildError):
        return complain([str(error)], USAGE)
    if isinstance(error, InputError):
        return complain(error.sentences, USAGE)
    if isinstance(error, StoreError):
        return complain([str(error)], STORE)
    if isinstance(error, OSError) and error.errno in THE_DISKS:
        place = f"`{error.filename}`" if error.filename else "the disk"
        return complain([f"{place} must be usable, but: {error.strerror}."], STORE)
    return None


def complain(sentences: list[str], code: int) -> int:
    """Prints sentences on stderr and gives the exit code back."""
    for sentence in sentences:
        streams.report(sentence)
    return code
