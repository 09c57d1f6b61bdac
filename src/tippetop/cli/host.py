"""What the command line does to its own process, and a library may not: memory, log levels, signal
handlers.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator
from typing import Any

from .memory import keep_memory


def prepared(command: Callable[..., int]) -> Callable[..., int]:
    """The command, with the process made ready first for what computes: memory is kept, and
    libraries do not speak between our lines (heyoka warns on standard output, dask on stderr; what
    goes wrong there is reported here).
    """

    @functools.wraps(command)
    def ready(*arguments: Any, **options: Any) -> int:
        os.environ.setdefault(
            "PYDANTIC_DISABLE_PLUGINS", "__all__"
        )  # to look for them reads all that is installed
        os.environ.setdefault(
            "PYTHONWARNINGS", "ignore:resource_tracker"
        )  # of a process that tidies up after workers
        from ..engine import taylor

        keep_memory()
        taylor.silence()
        logging.disable(logging.ERROR)
        return command(*arguments, **options)

    return ready


class Stop:
    """A request to stop: `event` is set by SIGINT or SIGTERM, whose number is then in `signal`."""

    def __init__(self) -> None:
        self.event = threading.Event()
        self.signal = 0

    def ask(self, number: int, _: object) -> None:
        """The signal handler."""
        self.signal = number
        self.event.set()


@contextlib.contextmanager
def stopping() -> Iterator[Stop]:
    """A block in which SIGINT and SIGTERM ask to stop; handlers are put back after it.

    Only the main thread may set handlers: in any other the block just runs.
    """
    stop = Stop()
    main = threading.current_thread() is threading.main_thread()
    handlers = (
        {number: signal.signal(number, stop.ask) for number in (signal.SIGINT, signal.SIGTERM)}
        if main
        else {}
    )
    try:
        yield stop
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
