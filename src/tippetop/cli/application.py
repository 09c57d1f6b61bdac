"""The commands, called from the words of the command line by cyclopts.

The words of the command line go in; the exit code of the command comes out.
"""

from __future__ import annotations

from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter

from ..errors import InputError
from . import host, usage


PURPOSE = (
    "Integrate tippe tops, heavy tops and eccentric cylinders that roll and glide on a plane, to "
    "machine precision; store, check and draw their motions.\n\n"
    "A first run: `tippetop run inverting --figure inverting.png`. `tippetop presets` lists the "
    "scenarios to start from, `tippetop new` writes one with every key, `tippetop help` explains "
    "them. The manual is README.md and docs/ of the source."
)
_MODULES = {
    "run_command": "run resume replay",
    "landscape_commands": "surface potential",
    "sweep_command": "sweep",
    "plot": "plot",
    "show": "info check export systems presets",
    "view": "view",
    "film_command": "film",
    "benchmark": "benchmark",
    "exchange": "compare fit",
    "reconstruct": "reconstruct",
    "help_command": "new help completion",
}
COMMANDS = {
    name: f"tippetop.cli.{module}:{name}"
    for module, names in _MODULES.items()
    for name in names.split()
}
"""The function of each command, of the same name, which cyclopts imports when it is needed."""
WITHOUT_ENGINE = {"export", "systems", "presets", "new", "help", "completion"}
"""Commands that never use the engine: they start without `host.prepare`, which loads heyoka."""


def application() -> App:
    """Return the application of cyclopts, with all commands; their modules are not imported."""
    app = App(
        name="tippetop",
        help=PURPOSE,
        help_format="plaintext",
        result_action="return_value",
        default_parameter=Parameter(negative=(), name_transform=_option),
        suppress_keyboard_interrupt=False,  # `cli.outcome` reports how the run ended
    )
    for name, function in COMMANDS.items():
        app.command(function, name=name)
    return app


def called(words: Sequence[str]) -> int:
    """Call the command named by the first word and return its exit code."""
    app = application()
    if not words or {"--help", "-h"} & {*words}:
        from .text import console

        app.console = console()
        for name in COMMANDS.keys() & words[:1] or COMMANDS:
            app[name]  # imports its function, whose docstring is the help
    elif words[0] in COMMANDS.keys() - WITHOUT_ENGINE:
        host.prepare()
    try:
        return app(words, exit_on_error=False, print_error=False) or 0
    except CycloptsError as error:
        raise InputError(usage.sentences(error)) from None


def _option(name: str) -> str:
    """Return the name of an option: as_json -> json, from_ -> from."""
    return name.removeprefix("as_").strip("_").replace("_", "-")
