"""rich's console, for those commands that draw tables."""

from typing import NoReturn

from rich.console import Console as RichConsole


class Console(RichConsole):
    """A console that leaves a reader who went away to `cli.outcome`."""

    def on_broken_pipe(self) -> NoReturn:
        """Called in an except block: raises the BrokenPipeError again."""
        raise
