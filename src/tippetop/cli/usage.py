"""Errors in the words of a command line become sentences: what is wrong, and what to
write instead.
"""

from __future__ import annotations

import shlex
from typing import Any, get_args

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    UnknownOptionError,
    UnusedCliTokensError,
)
from cyclopts.exceptions import UnknownCommandError

from ..errors import InputError, nearest, suggestion


NUMBERS = {float: "a number", int: "a whole number"}


def sentence(error: CycloptsError, commands: list[str]) -> str:
    """The sentence on an error that cyclopts found."""
    command = " ".join(error.command_chain or ())
    help_ = f"see tippetop {command} --help" if command else "see tippetop --help"
    if isinstance(error, UnknownCommandError):
        word = next((w for w in error.unused_tokens or [] if w not in commands), "")
        return (
            f"unknown command `{word}`.{suggestion(word, commands)} The commands are "
            f"{', '.join(commands)}."
        )
    if isinstance(error, UnknownOptionError):
        return _unknown_option(error, command, help_)
    if isinstance(error, UnusedCliTokensError):
        words = " ".join(error.unused_tokens or [])
        settable = (
            " (values are changed with --set table.key=value)"
            if command in ("run", "check")
            else ""
        )
        return f"unexpected argument `{words}`{settable}; {help_}."
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        return _missing(error, command, help_)
    if isinstance(error, CoercionError) and error.token is not None:
        if isinstance(error.__cause__, InputError):
            return " ".join(error.__cause__.sentences)
        name = error.token.keyword or _name_of(error.argument)
        kinds = {
            error.target_type,
            *get_args(error.target_type),
        }  # of `int | None` it is a number all the same
        words = next((words for kind, words in NUMBERS.items() if kind in kinds), "valid")
        return f"{name} must be {words}, but is `{error.token.value}`."
    return f"{error}; {help_}."


def _missing(error: MissingArgumentError, command: str, help_: str) -> str:
    """An argument that is not given at all, or an option without its value."""
    name, words, argument = _name_of(error.argument), error.root_input_tokens or [], error.argument
    given = next((n for n in argument.names if n in words), None) if argument is not None else None
    if given is not None:
        after = words[
            len(words) - words[::-1].index(given) :
        ]  # the last one: those before have their values
        if not after:
            return f"{given} must be followed by a value; {help_}."
        instead = (
            ""
            if after[0].startswith("--")
            else f" (if that is the value: {given}={shlex.quote(after[0])})"
        )
        return (
            f"{given} must be followed by a value, but is followed by `{after[0]}`{instead}; "
            f"{help_}."
        )
    example = " ".join(["tippetop", *words, name, *(["..."] if name.startswith("-") else [])])
    return f"{name} is missing: write {example}; {help_}."


def _name_of(argument: Any) -> str:
    """--out for an option, SCENARIO for what is given by its place."""
    if argument is None:
        return "the argument"
    return argument.name if argument.index is None else argument.name.lstrip("-").upper()


def _unknown_option(error: UnknownOptionError, command: str, help_: str) -> str:
    """An option that does not exist: a key of the scenario is changed with --set."""
    option, equals, value = (error.token.keyword or error.token.value).partition("=")
    known = [
        name for argument in error.argument_collection if argument.parse for name in argument.names
    ]
    key = scenario_key(option.lstrip("-").replace("-", "_")) if "--set" in known else None
    if key is not None:
        words = error.root_input_tokens or []
        after = words[words.index(option) + 1 :] if option in words else []
        joined = next((w for w in words if w.startswith(f"{option}=")), "")
        value = value if equals else joined.partition("=")[2] or (after[0] if after else "")
        given = value if value and not value.startswith("--") else "VALUE"
        return f"unknown option {option}: write --set {shlex.quote(f'{key}={given}')}."
    near = nearest(option, known) if option.startswith("--") else None
    return f"unknown option {option}{f'; did you mean {near}?' if near else ';'} {help_}."


def scenario_key(word: str) -> str | None:
    """The dotted key of a scenario that a word stands for: theta -> initial.theta; None if there is
    none.
    """
    from ..mechanics.friction import PARTS
    from ..mechanics.systems import SYSTEMS
    from ..problem.options import OPTIONS

    tables: dict[str, Any] = {}
    for system in SYSTEMS.values():
        for table, names in (("parameters", system.parameters), ("initial", system.initial)):
            tables |= {name: f"{table}.{name}" for name in names if name not in tables}
        for law in system.laws.values():
            tables |= {
                name: f"friction.{name}" for name in (*law.parameters, *PARTS) if name not in tables
            }
    tables |= {name: f"run.{name}" for name in OPTIONS}
    tables |= {
        "centre_at_rest": "initial.centre_at_rest",
        "law": "friction.law",
        "friction": "friction.law",
    }
    tables |= {"system": "system", "form": "form"}
    return tables.get(word) or tables.get(word.rpartition(".")[2])
