"""Where chunks are computed: in this process, in processes of this machine, or by workers of dask.

Results come in any order. They travel to the one process that holds the store's lock, which writes
them: workers need no file system in common, two writers cannot meet, and a worker that dies leaves
nothing half-written.
"""

import contextlib
import itertools
import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from typing import Any

from ..engine import taylor
from ..errors import InputError
from . import chunk
from .chunk import Rows, Task


Outcome = tuple[Task, Rows | str]  # rows, or why there are none
AHEAD = 2  # chunks in flight for each thread of the workers: one that computes, one that waits
CONNECT_FOR = "10 s"


class SchedulerLost(Exception):
    """The scheduler went away while chunks were in flight."""


def in_process(tasks: Iterator[Task], threads: int) -> Iterator[Outcome]:
    """Computes in this process."""
    for task in tasks:
        try:
            yield task, chunk.compute_chunk(task, threads)
        except Exception as error:  # whatever it is, the other chunks are computed
            yield task, _sentence(error)


@contextlib.contextmanager
def connect(scheduler: str) -> Iterator[Any]:
    """A client of the dask scheduler at an address. Raises InputError if there is none."""
    from distributed import Client
    from distributed.comm.addressing import get_address_host_port

    try:
        get_address_host_port(scheduler)
        client = Client(scheduler, timeout=CONNECT_FOR, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # TimeoutError is an OSError
        raise InputError(
            [
                "`scheduler` must be the address of a running dask scheduler, but "
                f"`{scheduler}`: {error}."
            ]
        ) from None
    with client:
        yield client


def in_processes(tasks: Iterator[Task], count: int) -> Iterator[Outcome]:
    """Compute in processes of this machine, one thread each.

    A process that dies breaks the pool: the chunks in flight are computed in a new pool, each
    alone, once all others are computed. So a chunk that kills its process takes no other with it.

    Raises InputError if a process cannot start.
    """
    suspects: list[Task] = []

    def submit(pool: ProcessPoolExecutor, most: int) -> None:
        for task in itertools.islice(tasks, most):
            try:
                flying[pool.submit(chunk.compute_chunk, task)] = task
            except BrokenProcessPool:
                suspects.append(task)
                raise

    while True:
        flying: dict[Any, Task] = {}
        try:
            with _pool(count, again=bool(suspects)) as pool:
                submit(pool, count + 1)
                while flying:
                    for future in wait(flying, return_when=FIRST_COMPLETED).done:
                        result = _result(future)
                        yield flying.pop(future), result
                        submit(pool, 1)
                break
        except BrokenProcessPool:
            suspects += flying.values()
    for task in suspects:
        with _pool(1, again=True) as pool:
            try:
                result = _result(pool.submit(chunk.compute_chunk, task))
            except BrokenProcessPool:
                result = "every worker that tried it died"
        yield task, result


def _result(future: Any) -> Rows | str:
    """Return the rows of a chunk, or why there are none. Raises BrokenProcessPool."""
    try:
        return future.result()
    except BrokenProcessPool:
        raise
    except Exception as error:  # whatever it is, the other chunks are computed
        return _sentence(error)


@contextlib.contextmanager
def _pool(count: int, *, again: bool) -> Iterator[ProcessPoolExecutor]:
    """A pool of processes. They end with the block, however it ends, and with this process.

    Raises InputError if one must be made again because processes cannot start at all.
    """
    reader, writer = multiprocessing.Pipe(duplex=False)
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin, (reader,))
    try:
        try:
            if again:
                pool.submit(os.getpid).result()
        except BrokenProcessPool:
            guard = 'a script needs `if __name__ == "__main__":`'
            raise InputError([f"`workers` must be processes that can start: {guard}."]) from None
        yield pool
        pool.shutdown()
    finally:
        writer.close()
        pool.shutdown(cancel_futures=True)
        reader.close()


def _begin(alive: Connection) -> None:
    """Prepare a worker: Ctrl-C is for the process that waits for it, and so is what it reports."""

    def watch() -> None:
        alive.poll(None)  # until the other end is closed, or its process is gone
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.disable(logging.ERROR)
    taylor.silence()
    threading.Thread(target=watch, daemon=True, name="parent").start()


def on_client(client: Any, tasks: Iterator[Task]) -> Iterator[Outcome]:
    """Computes on the workers of a dask client. Raises SchedulerLost.

    dask gives the chunk of a dead worker to another, but blames all chunks that the worker held:
    those that it gives up are tried once more, each alone, so that a chunk that kills its workers
    takes no other with it.
    """
    from distributed import CancelledError

    blamed = []
    try:
        for task, result, killed in _flow(client, tasks):
            if killed:
                blamed.append(task)
            else:
                yield task, result
        for task in blamed:
            for _, result, _ in _flow(client, iter([task])):
                yield task, result
    except (CancelledError, OSError) as error:  # CommClosedError is an OSError
        raise SchedulerLost from error


def _flow(client: Any, tasks: Iterator[Task]) -> Iterator[tuple[Task, Any, bool]]:
    """Task, its columns or a sentence, and whether its workers died."""
    from distributed import CancelledError, KilledWorker, as_completed
    from distributed.comm import CommClosedError

    flying: dict[Any, Task] = {}
    completed = as_completed(loop=client.loop)

    def send() -> None:
        while len(flying) < AHEAD * max(1, sum(client.nthreads().values())):
            task = next(tasks, None)
            if task is None:
                return
            future = client.submit(chunk.compute_chunk, task, pure=False)
            flying[future] = task
            completed.add(future)

    send()
    for future in completed:
        if future.status in (
            "pending",
            "lost",
        ):  # its worker died with the result, and another computes it again
            completed.add(future)
            continue
        if future.status == "cancelled":
            raise SchedulerLost
        task, killed = flying.pop(future), False
        try:
            result = future.result()
        except (CancelledError, CommClosedError):
            raise
        except Exception as error:  # whatever it is, the other chunks are computed
            result, killed = _sentence(error), isinstance(error, KilledWorker)
        yield task, result, killed
        send()


def _sentence(error: BaseException) -> str:
    """What happened to a chunk, in a sentence."""
    if type(error).__name__ == "KilledWorker":
        return "every worker that tried it died"
    return f"{type(error).__name__}: {error}".rstrip(".: ")
