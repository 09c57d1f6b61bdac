"""A call of a command from the words of the command line, by cyclopts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module

from cyclopts import App, CycloptsError, Parameter

from ..errors import InputError, suggestion
from . import host, overview, usage


def called(words: Sequence[str]) -> int:
    """Call the command named by the first word and return its exit code."""
    name = words[0]
    if name not in overview.COMMANDS:
        raise InputError(
            f"unknown command `{name}`.{suggestion(name, overview.COMMANDS)} The commands are "
            f"{', '.join(overview.COMMANDS)}."
        )
    app = app_of([name])
    if {"--help", "-h"} & {*words}:
        from .console import Console

        app.console = Console()
    elif name not in overview.WITHOUT_ENGINE:
        host.prepare()
    try:
        return app(words, exit_on_error=False, print_error=False) or 0
    except CycloptsError as error:
        raise InputError(usage.sentences(error)) from None


def app_of(names: Iterable[str]) -> App:
    """Return the application with these commands."""
    app = App(
        name="tippetop",
        help="\n\n".join(overview.PURPOSE),
        version=overview.version,
        help_format="plaintext",
        result_action="return_value",
        default_parameter=Parameter(negative=(), name_transform=_option),
        suppress_keyboard_interrupt=False,  # `cli.outcome` reports how the run ended
    )
    for name in names:
        app.command(command(name), name=name)
    return app


def command(name: str) -> Callable[..., int]:
    """Return the function of a command."""
    return getattr(import_module(f".{overview.COMMANDS[name]}", __package__), name)


def _option(name: str) -> str:
    """Return the name of an option: as_json -> json, from_ -> from."""
    return name.removeprefix("as_").strip("_").replace("_", "-")
