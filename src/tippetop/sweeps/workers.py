"""Compute chunks in this process, in processes of this machine, or on workers of dask.

Results come in any order. They travel to the one process that holds the store's lock, which writes
them: workers need no common file system, and a worker that dies leaves nothing half-written.
"""

import contextlib
import itertools
import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from ..engine import taylor
from ..errors import InputError
from . import chunk
from .chunk import Rows, Task


Outcome = tuple[Task, Rows | str]  # rows, or why there are none
CONNECT_FOR = "10 s"
CHECK_EVERY = 10.0  # [s], whether the scheduler is still there
DIED = "every worker that tried it died"


class SchedulerLost(Exception):
    """The scheduler went away while chunks were in flight."""


class Workers(NamedTuple):
    """Workers that chunks are sent to.

    `processes` and `connect` make it. `start(again)` provides an executor; `again` after a worker
    died.
    """

    start: Callable[[bool], AbstractContextManager[Executor]]  # True: again, after some died
    ahead: Callable[[], int]  # chunks in flight: those that are computed, and some that wait
    alive: Callable[[], bool] = lambda: True  # whether their scheduler is still there


def in_process(tasks: Iterator[Task], threads: int) -> Iterator[Outcome]:
    """Yield each task with its columns, computed in this process, or why it failed."""
    for task in tasks:
        try:
            yield task, chunk.compute_chunk(task, threads)
        except Exception as error:  # the other chunks are computed after any error
            yield task, _sentence(error)


def on_workers(workers: Workers, tasks: Iterator[Task]) -> Iterator[Outcome]:
    """Yield each task with its columns, computed by workers, or why it failed.

    A worker that dies takes the chunks in flight with it: they are computed again, each alone, once
    all others are computed. So a chunk that kills its worker fails alone. Raises SchedulerLost, and
    InputError if a process cannot start.
    """
    suspects: list[Task] = []
    known = -1
    while len(suspects) > known:  # further workers died
        known = len(suspects)
        yield from _flow(workers, tasks, suspects, again=known > 0)
    for task in suspects:
        deadly: list[Task] = []
        yield from _flow(workers, iter([task]), deadly, again=True)
        yield from ((task, DIED) for task in deadly)


def _flow(
    workers: Workers, tasks: Iterator[Task], suspects: list[Task], *, again: bool
) -> Iterator[Outcome]:
    """Yield tasks with their results until all are done or processes died.

    Tasks whose worker died are appended to `suspects`; `again` as of `Workers`.
    """
    flying: dict[Any, Task] = {}

    def send() -> None:
        """Submit further tasks until enough chunks are under way, or the pool is broken.

        A task that a broken pool refuses goes to `suspects`, as it is taken from `tasks` already.
        """
        for task in itertools.islice(tasks, max(0, workers.ahead() - len(flying))):
            try:
                flying[executor.submit(chunk.compute_chunk, task)] = task
            except BrokenProcessPool:
                suspects.append(task)
                return

    with workers.start(again) as executor:
        send()
        while flying:
            if not workers.alive():
                raise SchedulerLost
            for future in wait(flying, CHECK_EVERY, FIRST_COMPLETED).done:
                task = flying.pop(future)
                try:
                    result: Rows | str = future.result()
                except CancelledError:
                    raise
                except Exception as error:  # the other chunks are computed after any error
                    if type(error).__name__ in ("BrokenProcessPool", "KilledWorker"):
                        suspects.append(task)
                        continue
                    result = _sentence(error)
                yield task, result
                send()


def processes(count: int) -> Workers:
    """Return `count` processes of this machine as workers, one thread each; none is started yet."""
    # one more chunk waits, so that no process is idle
    return Workers(lambda again: _pool(count, again), lambda: count + 1)


@contextlib.contextmanager
def _pool(count: int, again: bool) -> Iterator[ProcessPoolExecutor]:
    """Start processes. They end with the block, however it ends, and with this process.

    Raises InputError if one must be started again because processes cannot start at all.
    """
    reader, writer = multiprocessing.Pipe(duplex=False)
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _prepare, (reader,))
    # New processes inherit the blocked SIGINT: until `_prepare`, Ctrl-C would print tracebacks.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        try:
            started = [pool.submit(os.getpid) for _ in range(count)]
            if again:
                started[0].result()
        except BrokenProcessPool:
            guard = 'a script needs `if __name__ == "__main__":`'
            raise InputError(f"`workers` must be processes that can start: {guard}.") from None
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        yield pool
        pool.shutdown()  # after an error, workers are told to end first: see below
    finally:
        writer.close()  # ends the workers: `watch` in `_prepare`
        pool.shutdown(cancel_futures=True)
        reader.close()


def _prepare(alive: Connection) -> None:
    """Prepare a worker: it ignores Ctrl-C, reports nothing, and ends with its parent."""

    def watch() -> None:
        """End this process, without cleaning up, when the one that started it has gone."""
        alive.poll(None)  # until the other end is closed, or its process is gone
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.disable(logging.ERROR)
    taylor.silence()
    threading.Thread(target=watch, daemon=True, name="parent").start()


@contextlib.contextmanager
def connect(scheduler: str) -> Iterator[Workers]:
    """Connect to the dask scheduler at an address. Raises InputError if there is none."""
    from distributed import Client
    from distributed.comm.addressing import get_address_host_port

    try:
        get_address_host_port(scheduler)
        client = Client(scheduler, timeout=CONNECT_FOR, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # TimeoutError is an OSError
        raise InputError(
            "`scheduler` must be the address of a running dask scheduler, but "
            f"`{scheduler}`: {error}."
        ) from None

    @contextlib.contextmanager
    def start(again: bool) -> Iterator[Executor]:
        """Provide dask's executor.

        A lost connection is not made again, so `again` changes nothing.
        """
        try:
            yield client.get_executor(pure=False)
        except (CancelledError, OSError) as error:  # CommClosedError is an OSError
            raise SchedulerLost from error

    with client:
        yield Workers(
            start,
            lambda: 2 * max(1, sum(client.nthreads().values())),
            lambda: client.status == "running",
        )


def _sentence(error: BaseException) -> str:
    """Return a sentence about the error of a chunk, without a full stop."""
    return f"{type(error).__name__}: {error}".rstrip(".: ")
