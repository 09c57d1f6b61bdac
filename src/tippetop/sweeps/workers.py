"""Where the chunks of a sweep are computed: in this process or by the workers of dask. Results come in any order.

The results travel to the one process that holds the store's lock, which writes them: workers need no file system in
common, two writers cannot meet, and a worker that dies leaves nothing half-written.
"""

import contextlib
import logging
import signal
import threading
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

from ..engine import taylor
from ..errors import InputError
from . import chunk
from .chunk import Rows, Task


Outcome = tuple[Task, Rows | str]  # rows, or why there are none
AHEAD = 2  # chunks in flight for each thread of the workers: one that computes, one that waits
CONNECT_FOR = "10 s"
GONE_FOR, LOOK = 60.0, 1.0  # [s] without any process of ours until there is none, and between two looks


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
            [f"`scheduler` must be the address of a running dask scheduler, but `{scheduler}`: {error}."]
        ) from None
    with client:
        yield client


def processes_can_be() -> bool:
    """Whether what processes of our own take is installed: dask, and keys for what they say to each other."""
    return all(find_spec(name) for name in ("distributed", "cryptography"))


@contextlib.contextmanager
def local_cluster(workers: int) -> Iterator[Any]:
    """A client of processes of our own on this machine, one thread each.

    They talk over TLS with keys that are made here and live in memory only: who reaches a port of 127.0.0.1, as any
    user of the machine does, gets no further without them.
    """
    import dask
    from distributed import Client, LocalCluster, Security, WorkerPlugin

    class Quiet(WorkerPlugin):
        """In those processes, which are ours alone: Ctrl-C is for the one that waits for them, and so is what they have
        to say: it comes back as the sentence of a chunk."""

        def setup(self, worker: Any) -> None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            logging.disable(logging.ERROR)
            taylor.silence()

    settings = {
        "distributed.worker.profile.enabled": False,  # it looks at every thread each 10 ms
        "distributed.scheduler.http.routes": [],  # what they answer needs no key: nothing is served
        "distributed.worker.http.routes": [],
    }
    options: dict[str, Any] = {
        "protocol": "tls://",
        "security": Security.temporary(),
        "n_workers": workers,
        "threads_per_worker": 1,
        "processes": True,
        "host": "127.0.0.1",
        "dashboard_address": "127.0.0.1:0",  # None would still open port 8787
        "scheduler_kwargs": {"dashboard": False},
        "memory_limit": 0,
    }
    with dask.config.set(settings), contextlib.ExitStack() as held:
        try:
            cluster = held.enter_context(LocalCluster(**options))
            client = held.enter_context(Client(cluster, set_as_default=False))
            client.register_plugin(Quiet())
        except (OSError, RuntimeError) as error:  # a process of ours was killed before it could answer
            raise SchedulerLost from error
        held.enter_context(_watched(client))
        yield client


@contextlib.contextmanager
def _watched(client: Any) -> Iterator[None]:
    """A block in which a client is closed when all of its workers are gone for long: dask gives up to begin a process
    again that dies at its start, and would wait for it for ever."""
    over = threading.Event()

    def watch() -> None:
        gone = 0.0
        with contextlib.suppress(Exception):  # it is being closed
            while not over.wait(LOOK):
                gone = 0.0 if client.nthreads() else gone + LOOK
                if gone >= GONE_FOR:
                    client.close()
                    return

    thread = threading.Thread(target=watch, daemon=True, name="workers")
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def on_client(client: Any, tasks: Iterator[Task]) -> Iterator[Outcome]:
    """Computes on the workers of a dask client. Raises SchedulerLost.

    dask gives the chunk of a dead worker to another, but blames all chunks that the worker held: those that it gives up
    are tried once more, each alone, so that a chunk that kills its workers takes no other with it.
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
        if future.status in ("pending", "lost"):  # its worker died with the result, and another computes it again
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
