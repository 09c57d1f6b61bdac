"""Commands and what they print."""

from collections.abc import Callable

import pytest
from typed import typed


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Callable:
    """Run a command, compare its exit code, and return what it prints on both streams."""

    def run(words: str, code: int = 0) -> tuple[str, str]:
        capsys.readouterr()
        assert typed(words) == code
        return capsys.readouterr()

    return run
