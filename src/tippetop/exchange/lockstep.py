"""Searches in threads whose motions are computed together.

A function of many points, and tasks that call it with few at a time, go in. A call waits until
every task waits, or has ended; then one call has the points of all, which run in lanes.
"""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any

import numpy as np


class Lockstep:
    """Join the calls of a function by tasks that run at the same time.

    Parameters
    ----------
    function
        function(points, rows) -> an array (points, ...), with `points` (points, free), whose
        results do not depend on each other.
    """

    def __init__(self, function: Callable[[np.ndarray, int], np.ndarray]):
        """Begin with one thread, that of the caller, which waits for nothing."""
        self.function = function
        self.lock = threading.RLock()
        self.busy = 1  # threads that wait neither for the function nor for their tasks
        # by number of rows: the points and the answer of each call
        self.asked: dict[int, list[tuple[np.ndarray, Future]]] = {}
        self.stopped = False

    def __call__(self, points: np.ndarray, rows: int) -> np.ndarray:
        """Return the function of points, computed together with those of other tasks."""
        if self.stopped:
            raise CancelledError
        answer: Future = Future()
        with self.lock:
            self.asked.setdefault(rows, []).append((points, answer))
            self._leave()
        return np.asarray(answer.result())

    def map(self, task: Callable[[Any], Any], items: Iterable[Any]) -> list:
        """Return the task of each item; each runs in a thread, and may call `map` itself.

        An exception in one of them ends the others.
        """
        items = [*items]
        left = len(items)

        def run(item: Any) -> Any:
            """Run one task; after the last one the caller of `map` is busy again."""
            nonlocal left
            try:
                return task(item)
            finally:
                with self.lock:
                    left -= 1
                    if left:
                        self._leave()

        if left < 2:
            return [task(item) for item in items]
        with self.lock:
            self.busy += left - 1  # the caller waits
        with ThreadPoolExecutor(left) as pool:
            running = [pool.submit(run, item) for item in items]
            try:
                return [one.result() for one in running]
            except BaseException:
                self.stopped = True
                raise

    def _leave(self) -> None:
        """Count a thread that waits; after the last one, call the function for all that asked."""
        self.busy -= 1
        if self.busy:
            return
        asked, self.asked = self.asked, {}
        self.busy = sum(map(len, asked.values()))
        for rows, some in asked.items():
            points, answers = zip(*some, strict=True)
            try:
                found = self.function(np.concatenate(points), rows)
            except Exception as error:
                for answer in answers:
                    answer.set_exception(error)
            else:
                parts = np.split(found, np.cumsum([*map(len, points)])[:-1])
                for answer, part in zip(answers, parts, strict=True):
                    answer.set_result(part)
