"""rich's console, for commands that print tables of several columns."""

from typing import NoReturn

from rich.console import Console as RichConsole

from .text import width


class Console(RichConsole):
    """A console that lets `cli.outcome` handle a reader that is gone."""

    def __init__(self) -> None:
        super().__init__(highlight=False, markup=False, width=width())

    def on_broken_pipe(self) -> NoReturn:
        """Raise the BrokenPipeError again: rich calls this in an except block."""
        raise
