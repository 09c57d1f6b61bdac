"""Long work that cannot be interrupted, such as a compilation: done in a thread.

`engine.integrator` compiles by it, and `derivatives.through` integrates.
"""

from __future__ import annotations

import contextvars
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from .errors import Interrupted


if TYPE_CHECKING:
    from concurrent.futures import Future


Result = TypeVar("Result")
SILENT = 2.0  # [s] after which a terminal shows the reason
LOOK = 0.05  # [s] between two looks at the signals and at `stop`

# Work that cannot be ended: the process must not wait for it.
_abandoned: list[Future] = []


def awaited(work: Callable[[], Result], doing: str, stop: threading.Event | None = None) -> Result:
    """Return the result of `work`, or raise its exception.

    Signals are handled while it is done: neither LLVM nor heyoka looks for them.

    Parameters
    ----------
    work
        A function that is called in a new thread with the context of this one (it contains the
        error state of numpy); in any thread but the main one, which has the signals, just here.
    doing
        The line on stderr, if that is a terminal, about work that takes longer than 2 s.
    stop
        Raises Interrupted as soon as this is set.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    from concurrent.futures import Future, wait  # imports logging: late

    context = contextvars.copy_context()
    result = Future[Result]()

    def done() -> None:
        """Do the work in the thread, and keep its result or its exception in `result`."""
        try:
            result.set_result(context.run(work))
        except BaseException as error:
            result.set_exception(error)

    thread = threading.Thread(target=done, name="awaited", daemon=True)
    quiet = not sys.stderr.isatty() or bool(os.environ.get("TIPPETOP_QUIET"))
    began = time.monotonic()
    try:
        thread.start()  # in here: a signal may come before it returns
        while not result.done():
            wait([result], LOOK)
            if not quiet and time.monotonic() - began > SILENT:
                print(f"tippetop: {doing} ...", file=sys.stderr, flush=True)
                quiet = True
            if stop is not None and stop.is_set():
                raise Interrupted
    finally:
        if not result.done():
            _abandoned.append(result)
    return result.result()


def abandoned() -> bool:
    """Return whether abandoned work is still running: only `os._exit` ends the process then.

    `cli` calls it at the end.
    """
    return not all(result.done() for result in _abandoned)
