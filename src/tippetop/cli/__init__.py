"""The command line: arguments become calls, errors become sentences and an exit code.

Modules are imported when they are needed, so that a command starts fast.
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

from ..awaiting import abandoned
from ..errors import BuildError, InputError, StoreError, missing_extra
from . import streams
from .streams import complain


DONE, BUG, USAGE, PHYSICS, ACCURACY, STORE, CHUNKS, INTERRUPTED, TERMINATED = (
    *range(7),
    130,
    143,
)
"""Exit codes; `help_command.EXIT_CODES` has their meanings."""
DISK_ERRORS = {  # of the operating system, wherever they come from: the program has no bug
    *(errno.ENAMETOOLONG, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO),
    *(errno.EACCES, errno.EPERM, errno.ELOOP, errno.ENOTDIR),
}
LIMITS = errno.EMFILE, errno.ENFILE, errno.ENOMEM

_received: list[int] = []  # exit codes of the signals that came, the first one first


def _interrupt(*_: Any) -> NoReturn:
    """Handle SIGINT: raise KeyboardInterrupt; exit immediately if a signal came before.

    The exit code is that of the first signal, which may have been a SIGTERM.
    """
    if _received:
        os._exit(_received[0])  # a second signal: exit now; acknowledged data are on the disk
    # before the raise: by this entry `main` tells a signal from a bug
    _received.append(INTERRUPTED)
    raise KeyboardInterrupt


def _terminate(*_: Any) -> NoReturn:
    """Handle SIGTERM: exit after open files were closed."""
    _received.append(TERMINATED)  # as in `_interrupt`
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # open files are being closed
    raise SystemExit(TERMINATED)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit with one of `help_command.EXIT_CODES`."""
    streams.prepare()
    gc.set_threshold(100_000)  # a hundred collections while modules load take a tenth of a start
    signal.signal(signal.SIGTERM, _terminate)
    warnings.showwarning = _warn  # type: ignore[assignment]
    signal.signal(signal.SIGINT, _interrupt)
    try:
        code = outcome(arguments)
    except Exception:
        if not _received:
            raise
        # an import turned the signal into an ImportError
        code = complain(["interrupted while it was loaded."], _received[0])
    except SystemExit as stopped:
        # without an entry it comes from `run_command`, whose handlers note signals elsewhere and
        # which has printed its sentence
        if stopped.code == TERMINATED and _received:
            complain(["terminated; data on the disk are kept."], TERMINATED)
        code = stopped.code if isinstance(stopped.code, int) else BUG
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # only the output is left to be written
    code = streams.flush(code)
    if abandoned():
        os._exit(code)  # the interpreter would wait for the thread of a compilation
    sys.exit(code)


def _warn(message: Warning | str, *_: Any) -> None:
    """Print a warning in one line, without its place in the source: our `warnings.showwarning`."""
    streams.report(f"warning: {' '.join(str(message).split())}")


def outcome(arguments: Sequence[str] | None = None) -> int:
    """Call the command and return its exit code; errors become sentences on stderr.

    `arguments` are the words of the command line, by default those of the process. Any other
    exception is a bug, and keeps its traceback.
    """
    words = sys.argv[1:] if arguments is None else [*arguments]
    try:
        from .application import called

        return called(words)
    except KeyboardInterrupt:
        return complain(["interrupted; nothing more was stored."], INTERRUPTED)
    except BrokenPipeError:  # the reader of the output is gone
        return DONE
    except InputError as error:
        return complain(error.sentences, USAGE)
    except BuildError as error:
        return complain([str(error)], USAGE)
    except ImportError as error:
        if sentence := missing_extra(error):
            return complain([sentence], USAGE)
        raise
    except StoreError as error:
        return complain([str(error)], STORE)
    except (MemoryError, RuntimeError, OSError) as error:
        number = getattr(error, "errno", 0)
        if isinstance(error, MemoryError) or number in LIMITS or "start new thread" in str(error):
            why = str(error) or "out of memory"
            sentence = f"a limit of this process (ulimit) must be higher, but: {why}."
            return complain([sentence], STORE)
        if not isinstance(error, OSError) or number not in DISK_ERRORS:
            raise
        place = f"`{error.filename}`" if error.filename else "standard output"
        return complain([f"{place} must be writable, but: {error.strerror}."], STORE)
