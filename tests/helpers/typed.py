"""Commands as they are typed."""

import shlex

from tippetop.cli import outcome


def typed(words: str) -> int:
    """Run a command in this process and return its exit code."""
    return outcome(shlex.split(words))
