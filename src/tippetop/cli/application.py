"""The words of the command line become a call: cyclopts, with the commands that the
words can mean.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module

from cyclopts import App, CycloptsError, Parameter

from ..errors import InputError
from . import host, overview, usage


HELP = {"--help", "-h", "--version"}


def called(words: Sequence[str]) -> int:
    """Calls the command that the words name.

    Raises InputError for words that mean nothing, and what it raises.
    """
    named = words[0] if words else ""
    app = app_of([named]) if named in overview.COMMANDS else app_of(overview.COMMANDS)
    if HELP & set(words):
        from .console import Console

        app.console = Console()
    try:
        return app(words, exit_on_error=False, print_error=False) or 0
    except CycloptsError as error:
        raise InputError(usage.sentence(error, list(overview.COMMANDS))) from None


def app_of(names: Iterable[str]) -> App:
    """Return the application with these commands."""
    app = App(
        name="tippetop",
        help="\n\n".join(overview.PURPOSE),
        version_flags=["--version"],
        version=overview.version,
        help_format="plaintext",
        result_action="return_value",
        default_parameter=Parameter(negative=(), name_transform=_option),
        suppress_keyboard_interrupt=False,  # `cli.outcome` says how the run ended
    )
    for name in names:
        function = command(name)
        app.command(
            function if name in overview.WITHOUT_ENGINE else host.prepared(function), name=name
        )
    return app


def command(name: str) -> Callable[..., int]:
    """Return the function of a command."""
    return getattr(import_module(f".{overview.MODULES[name]}", __package__), name)


def _option(name: str) -> str:
    """Return the name of an option: as_json -> json, from_ -> from."""
    return name.removeprefix("as_").strip("_").replace("_", "-")
