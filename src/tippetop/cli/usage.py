"""Sentences on wrong words of a command line."""

from __future__ import annotations

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from ..errors import InputError


def sentences(error: CycloptsError) -> list[str]:
    """Return the sentences on an error that cyclopts found.

    An InputError of a converter of `values` comes as the cause of a CoercionError.
    """
    if isinstance(error, CoercionError) and isinstance(error.__cause__, InputError):
        return error.__cause__.sentences
    command = " ".join(["tippetop", *(error.command_chain or ())])
    found = str(error)
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        name = error.argument.name
        if error.argument.index is None:
            found = f"{name} must be given, with a value."
        else:
            found = f"{name.lstrip('-').upper()} must be given."
    elif isinstance(error, UnusedCliTokensError):
        found = f"unexpected argument `{' '.join(error.unused_tokens or [])}`."
    if command in ("tippetop run", "tippetop check") and isinstance(
        error, UnknownOptionError | UnusedCliTokensError
    ):
        found += " Numbers of a scenario are changed by --set, such as --set initial.theta=0.2."
    return [f"{found} See {command} --help."]
