"""Changes to the process that a command line may make, and a library may not."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import signal
import threading
from collections.abc import Iterator


# M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of <malloc.h>. Each slice of a run allocates and frees
# about 20 MB: a fifth of the run's time where the system has to provide them again, page by page.
ALLOCATOR = {-1: 1 << 30, -3: 32 << 20}


def prepare() -> None:
    """Keep freed memory and silence other libraries: heyoka warns on standard output.

    `application.called` does this once, before the command.
    """
    # pydantic reads all installed packages to find plugins
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # of a process that tidies up after workers
    os.environ.setdefault("PYTHONWARNINGS", "ignore:resource_tracker")
    # Ctrl-C while heyoka's C++ imported it would print a traceback.
    import numpy  # noqa: F401

    from ..engine import taylor

    with contextlib.suppress(AttributeError, OSError):  # a C library other than glibc
        for option, size in ALLOCATOR.items():
            ctypes.CDLL(None).mallopt(option, size)
    taylor.silence()
    logging.disable(logging.ERROR)


@contextlib.contextmanager
def stopping() -> Iterator[tuple[threading.Event, list[int]]]:
    """Provide an event that SIGINT and SIGTERM set in this block, and a list of those that came.

    The block passes the event as `stop` to a run, which ends after a slice. At its end the former
    handlers are put back. Only the main thread can do this.
    """
    event = threading.Event()
    numbers = list[int]()

    def ask(number: int, _: object) -> None:
        """Note a signal, and let the run end after its present slice."""
        numbers.append(number)
        event.set()

    handlers = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield event, numbers
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
