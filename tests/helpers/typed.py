"""Commands as they are typed."""

import contextlib
import io
import json
import shlex
from collections.abc import Container
from typing import Any

from tippetop.cli import outcome


def typed(words: str) -> int:
    """Run a command in this process and return its exit code."""
    return outcome(shlex.split(words))


def answered(*words: object, codes: Container[int] = (0,)) -> tuple[int, str, str]:
    """Run a command in this process; return its exit code, output and messages.

    Check that the code is one of `codes`, and that each message is a sentence of the package.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = outcome([str(word) for word in words])
    lines = [line for line in err.getvalue().splitlines() if line.strip()]
    messages = [line for line in lines if not line.startswith("tippetop: warning:")]
    assert code in codes, (code, messages)
    assert all(line.startswith("tippetop: ") for line in messages), messages
    assert messages or not code
    return code, out.getvalue(), "\n".join(messages)


def reported(words: str) -> Any:
    """Run a command with `--json` in this process and return its report."""
    return json.loads(answered(*shlex.split(words), "--json")[1])


def refused(words: str, code: int = 2) -> str:
    """Run a command that fails with this code in this process and return its messages."""
    return answered(*shlex.split(words), codes=[code])[2]
