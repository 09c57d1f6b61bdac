"""The command line: words become calls, errors become one sentence and an exit code. Heavy imports wait."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from cyclopts import App, CycloptsError

from . import host, landscape, run, show, sweep


DONE, BUG, USAGE, PHYSICS, ACCURACY, STORE, CHUNKS, INTERRUPTED, TERMINATED = 0, 1, 2, 3, 4, 5, 6, 130, 143

app = App(
    name="tippetop",
    help="Tops that roll and glide: integrate, log events, store, draw.",
    version_flags=["--version"],
    version=lambda: _version(),
    result_action="return_value",
)
for module in (run, landscape, sweep, show):
    for command in module.COMMANDS:
        app.command(command if command in show.TEXT_ONLY else host.prepared(command))


def _version() -> str:
    from importlib.metadata import version

    return version("tippetop")


def _terminate(*_: Any) -> NoReturn:
    raise SystemExit(TERMINATED)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Runs the command line and exits: 0 done, 1 a bug, 2 usage or configuration, 3 the physics stopped it, 4 the
    accuracy contract was broken, 5 store or disk, 6 failed chunks, 130 and 143 interrupted."""
    signal.signal(signal.SIGTERM, _terminate)
    sys.exit(outcome(arguments))


def outcome(arguments: Sequence[str] | None = None) -> int:
    """What `main` exits with."""
    try:
        return app(arguments, exit_on_error=False, print_error=False) or DONE
    except CycloptsError as error:
        return complain([str(error)], USAGE)
    except KeyboardInterrupt:
        return complain(["interrupted: nothing was stored."], INTERRUPTED)
    except BrokenPipeError:  # the reader of our output went away
        sys.stderr.close()
        return DONE
    except Exception as error:
        known = _known_errors(error)
        if known is None:
            raise
        return known


def _known_errors(error: Exception) -> int | None:
    """Exit code of an error that is the user's or the machine's, after saying it; None for a bug."""
    from ..errors import InputError, StoreError

    if isinstance(error, InputError):
        return complain(error.sentences, USAGE)
    if isinstance(error, StoreError):
        return complain([str(error)], STORE)
    return None


def complain(sentences: list[str], code: int) -> int:
    """Says sentences on stderr and gives the exit code back."""
    for sentence in sentences:
        print(f"tippetop: {sentence}", file=sys.stderr)
    return code
