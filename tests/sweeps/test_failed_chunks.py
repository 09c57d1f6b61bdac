"""How a chunk that failed is described, wherever it was computed."""

from typing import Any

import numpy as np
import pytest

from tippetop.sweeps import chunk, workers
from tippetop.sweeps.workers import in_process


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (ArithmeticError("it will not do"), "ArithmeticError: it will not do"),
        (ValueError("one sentence."), "ValueError: one sentence"),
        (MemoryError(), "MemoryError"),
    ],
)
def test_an_error_is_one_sentence_without_its_end(error: Exception, sentence: str) -> None:
    """The sweep ends the sentence: `chunk 1 failed: ... .`"""
    assert workers._sentence(error) == sentence


def test_a_chunk_that_fails_does_not_stop_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks come back in order with their columns or a sentence; they are computed one at a time,
    when asked for.
    """
    begun: list[int] = []

    def compute(task: Any, threads: int) -> dict[str, np.ndarray]:
        begun.append(task)
        if task == 1:
            raise RuntimeError("no")
        return {"status": np.full(threads, task)}

    monkeypatch.setattr(chunk, "compute_chunk", compute)
    results = in_process(iter([0, 1, 2]), 3)  # type: ignore[list-item]
    task, columns = next(results)
    assert (task, begun) == (0, [0])
    assert columns["status"].tolist() == [0, 0, 0]  # type: ignore[index]
    assert next(results) == (1, "RuntimeError: no")
    assert next(results)[0] == 2
    assert next(results, None) is None


def test_ctrl_c_is_no_failed_chunk(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(task: Any, threads: int) -> dict:
        raise KeyboardInterrupt

    monkeypatch.setattr(chunk, "compute_chunk", interrupted)
    with pytest.raises(KeyboardInterrupt):
        next(in_process(iter([0]), 1))  # type: ignore[list-item]
