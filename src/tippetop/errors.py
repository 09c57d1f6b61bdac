"""Errors that the user can mend, and warnings: each is one or more sentences.

`cli.outcome` prints them with an exit code; the library raises them.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any


__all__ = ["InputError", "Interrupted", "StoreError", "TippetopWarning", "Unfinished"]


def __dir__() -> list[str]:
    """Return the public names, for completion."""
    return __all__


NEAR, VERY_NEAR = 0.6, 0.75  # of letters that two words share in order: eps and psi have 0.67


def nearest(word: str, known: Iterable[str], cutoff: float = NEAR) -> str | None:
    """Return the known word to which a mistyped one, in any case, is nearest, or None.

    Parts between hyphens count too: drilling is near to leine-glocker-drilling.
    """
    import difflib

    known = list(known)
    parts = {part: name for name in known for part in name.lower().split("-")}
    lower = parts | {name.lower(): name for name in known}
    matches = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=cutoff)
    return lower[matches[0]] if matches else None


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return `` Did you mean `x`?`` for a sentence, or an empty text if no known word is near."""
    match = nearest(word, known)
    return f" Did you mean `{match}`?" if match else ""


def sentence(key: str, must: str, given: Any) -> str:
    """Return the sentence on a wrong value: "`key` must ..., but is ...", cut if it is long."""
    words = "a table" if isinstance(given, dict) else repr(given)
    return f"`{key}` {must}, but is {words if len(words) <= 60 else words[:57] + '...'}."


def true_sentences(wrong: Mapping[str, Any]) -> list[str]:
    """Return the sentences whose condition is true."""
    return [words for words, is_wrong in wrong.items() if is_wrong]


def refuse_unknown(
    function: str, named: Collection[str], known: Collection[str], hint: str = ""
) -> None:
    """Raise TypeError for a keyword that a function does not have.

    `hint` follows if no known keyword is near.
    """
    for name in named:
        if name not in known:
            hint = suggestion(name, known) or hint
            raise TypeError(f"{function}() has no argument `{name}`.{hint}")


def unknown_key(
    key: str, known: Collection[str], everywhere: Iterable[str] = (), belongs: str = ""
) -> str:
    """Return the sentence on an unknown key, with the nearest key of its table or of another.

    Parameters
    ----------
    key
        With its table, dotted.
    known
        The keys of its table.
    everywhere
        Dotted, those of the scenario.
    belongs
        Where it belongs, if that is known otherwise.
    """
    table, _, name = key.rpartition(".")
    elsewhere = {k.rpartition(".")[2]: k for k in everywhere}
    here = {k: f"{table}.{k}" if table else k for k in known}
    near = elsewhere.get(name) or here.get(nearest(name, here) or "")
    near = near or elsewhere.get(nearest(name, elsewhere, VERY_NEAR) or "")
    meant = f": {belongs}." if belongs else f"; did you mean `{near}`?" if near else "."
    return (
        f"unknown key `{key}`{meant} {f'The keys of `{table}`' if table else 'The keys'} are "
        f"{', '.join(known)}."
    )


class BuildError(ImportError):
    """The compiled part of the package is missing, damaged, or was compiled from another source."""


EXTRAS = {
    "matplotlib": "figures",
    "imageio_ffmpeg": "film",
    **dict.fromkeys(("numba", "scipy"), "grids"),
    "contourpy": "sweep",
    **dict.fromkeys(("distributed", "dask"), "cluster"),
    **dict.fromkeys(("h5netcdf", "h5py", "pandas", "pyarrow"), "export"),
}
"""Optional imports, and the extra of this package that provides each, as in pyproject.toml."""


def refuse_without(name: str) -> None:
    """Raise ModuleNotFoundError if an extra is not installed, before a run rather than after."""
    from importlib.util import find_spec

    if find_spec(name) is None:
        raise ModuleNotFoundError(_missing(name), name=name)


def missing_extra(error: ImportError) -> str | None:
    """Return the sentence on an import of an extra that is not installed, or None."""
    # numba brings llvmlite
    name = (error.name or "").partition(".")[0].replace("llvmlite", "numba")
    return _missing(name) if name in EXTRAS else None


def _missing(name: str) -> str:
    """Return a sentence about a package that is required but not installed."""
    extra = EXTRAS[name]
    return (
        f"{name} is required, but not installed: pip install 'tippetop[{extra}]', "
        f"or in a checkout '.[{extra}]'."
    )


class Interrupted(Exception):
    """The run, or the sweep, stopped as asked; its store can be resumed."""

    def __init__(self, text: str = "stopped on request; its store can be resumed."):
        super().__init__(text)


class StoreError(OSError):
    """The store or the disk: one sentence, exit code 5."""


class _Sentences(Exception):
    def __init__(self, sentences: str | list[str]):
        self.sentences = [sentences] if isinstance(sentences, str) else sentences
        super().__init__("\n".join(self.sentences))


MOST_FAULTS = 20


class InputError(_Sentences, ValueError):
    """Input that cannot be used; each of `sentences` reports one fault, up to a number of them.

    `sentence` makes the sentence on a fault.
    """

    def __init__(self, faults: str | Sequence[Any], sentence: Callable[[Any], str] = str):
        """Make the sentences of the first faults, and one that counts the others."""
        faults = [faults] if isinstance(faults, str) else faults
        more = len(faults) - MOST_FAULTS
        if more > 1:
            rest = f"{more} more faults were found."
            super().__init__([*map(sentence, faults[:MOST_FAULTS]), rest])
        else:
            super().__init__([*map(sentence, faults)])


class Unfinished(_Sentences):
    """A sweep ended without some of its chunks; `sentences` names them.

    The same call computes the missing chunks.
    """


class TippetopWarning(UserWarning):
    """A scenario is doubtful, or a run broke a promise: one sentence."""


def warn(sentences: Iterable[str], level: int) -> None:
    """Issue a warning for each sentence; `level` counts the calls from here up to the user's.

    Wrappers count too: 4 in `sweeps.sweep` are itself, `tippetop.sweep`, `takes` and the user.
    """
    for sentence in sentences:
        warnings.warn(sentence, TippetopWarning, stacklevel=level + 1)


def _leaves(record: Any) -> Iterable[Any]:
    """Yield the numbers of a record of records, depth first, as `operand.leaves` does.

    This module is below `mechanics`, and cannot import it.
    """
    for field in record:
        yield from _leaves(field) if isinstance(field, tuple) else (field,)


def is_one_number(value: Any, arguments: tuple = (0.0,)) -> bool:
    """Return whether a value is a number, expression or symbol, or an array like its arguments.

    It has at most their dimensions, and is complex only if they are.
    """
    if isinstance(value, float):
        return True
    if not (hasattr(value, "__sub__") and hasattr(value, "__mul__")):
        return False  # a text, list, None or function
    leaves = list(_leaves(arguments))
    most = max(getattr(leaf, "ndim", 0) for leaf in leaves)
    is_allowed = not _is_complex(value) or any(map(_is_complex, leaves))
    return getattr(value, "ndim", 0) <= most and is_allowed


def _is_complex(value: Any) -> bool:
    """Return whether a value is a complex number or an array of them."""
    return isinstance(value, complex) or getattr(getattr(value, "dtype", None), "kind", "") == "c"


class NamedFormula:
    """A formula of the user whose faults become an InputError that contains its name, `of`.

    `names_its_faults` makes it. `owner` recognises it by `of`, which no other formula may have.
    """

    def __init__(self, formula: Callable, of: str):
        functools.update_wrapper(self, formula)
        self.formula = formula
        self.of = of

    def __call__(self, *arguments: Any) -> Any:
        """Return the value of the formula. Raises InputError if it fails, or is not one number."""
        try:
            value = self.formula(*arguments)
        except Exception as error:
            rule = ""
            if isinstance(error, TypeError):
                rule = " (a formula has no `if` and no `abs`: see tippetop.mechanics.operand)"
            raise InputError(
                f"the formula of {self.of} fails: {type(error).__name__}: {error}{rule}"
            ) from error
        if not is_one_number(value, arguments):
            raise InputError(
                f"the formula of {self.of} must return one number, but returns {value!r:.60}."
            )
        return value

    def __reduce__(self) -> tuple:
        return names_its_faults, (self.formula, self.of)


@functools.lru_cache(maxsize=256)
def names_its_faults(formula: Callable, words: str) -> Callable:
    """Return a formula of the user whose faults become an InputError that names it.

    Faults are exceptions, and values that are not one number, such as None of a function without
    `return`. Formulas of this package are returned as they are. Cached, so that a formula has one
    such object: compiled code is cached by it.

    Parameters
    ----------
    formula
        A function.
    words
        Its name: "the event `mine`".
    """
    module = str(getattr(formula, "__module__", ""))
    if module.startswith("tippetop.") or isinstance(formula, NamedFormula):
        return formula
    return NamedFormula(formula, words)


def owner(formula: Any) -> str:
    """Return the owner of a formula of the user, "the column `mine`"; empty for others."""
    return getattr(formula, "of", "")
