"""Sentences on wrong words of a command line."""

from __future__ import annotations

import shlex

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from ..errors import InputError


def sentences(error: CycloptsError) -> list[str]:
    """Return the sentences on an error that cyclopts found."""
    if isinstance(error, CoercionError) and isinstance(error.__cause__, InputError):
        return error.__cause__.sentences
    command, found = " ".join(error.command_chain or ()), str(error)
    if isinstance(error, UnknownOptionError):
        option, _, value = (error.token.keyword or error.token.value).partition("=")
        key = scenario_key(option) if command in ("run", "check", "fit", "compare") else None
        if key is not None:
            words = error.root_input_tokens or []
            joined = [word.partition("=")[2] for word in words if word.startswith(f"{option}=")]
            following = words[words.index(option) + 1 :] if option in words else joined
            value = value or next((word for word in following[:1] if word[:2] != "--"), "VALUE")
            return [f"unknown option {option}: write --set {shlex.quote(f'{key}={value}')}."]
    elif isinstance(error, MissingArgumentError) and error.argument is not None:
        name = error.argument.name
        if error.argument.index is not None:
            name = name.lstrip("-").upper()
        found = f"{name} must be given, with a value."
    elif isinstance(error, UnusedCliTokensError):
        found = f"unexpected argument `{' '.join(error.unused_tokens or [])}`."
    return [f"{found} See tippetop {command} --help."]


def scenario_key(option: str) -> str | None:
    """Return the dotted key that an option means: --theta -> initial.theta; None if none."""
    from ..mechanics.systems import SYSTEMS
    from ..scenario.schema import dotted_keys

    word = option.lstrip("-").replace("-", "_")
    keys = ["friction.law", *(key for system in SYSTEMS.values() for key in dotted_keys(system))]
    return next((key for key in keys if word in (key, key.rpartition(".")[2])), None)
