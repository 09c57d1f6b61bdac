"""The commands by module, called from the words of the command line by cyclopts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib import import_module

from cyclopts import App, CycloptsError, Parameter

from ..errors import InputError
from . import host, usage


PURPOSE = (
    "Tippe tops, heavy tops and eccentric cylinders that roll and glide on a plane: integrated "
    "to rounding, with their events, stored, checked and drawn.\n\n"
    "A first run: `tippetop run inverting --figure inverting.png`. `tippetop presets` lists the "
    "scenarios to start from, `tippetop new` writes one with every key, `tippetop help` explains "
    "them. The manual is README.md and docs/ of the source."
)
_NAMES = {
    "run_command": "run resume replay",
    "landscape_commands": "surface potential",
    "sweep_command": "sweep",
    "plot": "plot",
    "show": "info check export systems presets",
    "view": "view",
    "benchmark": "benchmark",
    "exchange": "compare fit",
    "reconstruct": "reconstruct",
    "help_command": "new help completion",
}
COMMANDS = {name: module for module, names in _NAMES.items() for name in names.split()}
"""The module of each command."""
WITHOUT_ENGINE = {"export", "systems", "presets", "new", "help", "completion"}


def application(names: Iterable[str] = COMMANDS) -> App:
    """Return the application with these commands, whose modules are imported."""
    app = App(
        name="tippetop",
        help=PURPOSE,
        help_format="plaintext",
        result_action="return_value",
        default_parameter=Parameter(negative=(), name_transform=_option),
        suppress_keyboard_interrupt=False,  # `cli.outcome` reports how the run ended
    )
    for name in names:
        module = import_module(f".{COMMANDS[name]}", __package__)
        app.command(getattr(module, name), name=name)
    return app


def called(words: Sequence[str]) -> int:
    """Call the command named by the first word and return its exit code."""
    known = COMMANDS.keys() & words[:1]
    app = application(known or COMMANDS)
    if not words or {"--help", "-h"} & {*words}:
        from .text import console

        app.console = console()
    elif known - WITHOUT_ENGINE:
        host.prepare()
    try:
        return app(words, exit_on_error=False, print_error=False) or 0
    except CycloptsError as error:
        raise InputError(usage.sentences(error)) from None


def _option(name: str) -> str:
    """Return the name of an option: as_json -> json, from_ -> from."""
    return name.removeprefix("as_").strip("_").replace("_", "-")
