"""Write the stubs of `tippetop` and of modules of it, which type checkers and editors read.

Usage: ``python .ci/stub.py``. Functions that take the options of a run get their full signature,
the rest is imported.
"""

import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import tippetop
from tippetop.library import scenarios
from tippetop.problem import options


MODULES = {
    "__init__": tippetop,
    "derivatives": tippetop.derivatives,
    "friction": tippetop.friction,
}
HEAD = """from collections.abc import Iterable, Sequence

import numpy as _np
import xarray as _xr

from .mechanics.event import Event
from .mechanics.form import Quantity
"""
"""Imports of the annotations of run options, of which their module has no names."""
NAMED = re.compile(r"(?<![\w.'\"])[A-Z]\w*")
"""A name in an annotation that its module imports."""


def written(annotation: str, imports: set[str], home: Any, space: dict[str, Any]) -> str:
    """Return an annotation as a stub has it; its names are imported from where `space` has them."""
    for name in set(NAMED.findall(annotation)) & {*space} - {*home.__all__}:
        module = space[name].__module__.partition("._")[0]  # pathlib._local
        imports.add(f"from {module.removeprefix('tippetop')} import {name}")
    if "threading." in annotation:  # `Event` is another
        imports.add("import threading")
    return re.sub(r"\b(np|xr)\.", r"_\1.", annotation)  # np would be offered as a name


def signature(function: Any, imports: set[str], home: Any) -> str:
    """Return a function as a stub has it."""
    lines: list[str] = []
    found = inspect.signature(function)
    space = {**vars(options), **vars(scenarios), **inspect.unwrap(function).__globals__}
    for parameter in found.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in lines:
            lines.append("*")
        default = "" if parameter.default is parameter.empty else " = ..."
        kind = written(parameter.annotation, imports, home, space)
        lines.append(f"{parameter.name}: {kind}{default}")
    arguments = "".join(f"    {line},\n" for line in lines)
    return (
        f"def {function.__name__}(\n{arguments}) -> "
        f"{written(found.return_annotation, imports, home, space)}: ..."
    )


def stub(home: Any) -> str:
    """Return the text of the stub of a module."""
    imports: set[str] = set()
    functions = []
    for name in home.__all__:
        public = getattr(home, name)
        if inspect.isfunction(public) and hasattr(public, "__signature__"):
            functions.append(signature(public, imports, home))
        elif inspect.ismodule(public):
            imports.add(f"from . import {name} as {name}")
        elif name != "__version__":
            imports.add(
                f"from {public.__module__.removeprefix('tippetop')} import {name} as {name}"
            )
    version = ["__version__: str"] if "__version__" in home.__all__ else []
    head = HEAD if functions else ""
    text = "\n\n".join([head + "\n".join(sorted(imports)), *version, *functions]) + "\n"
    command = [sys.executable, "-m", "ruff", "format", "--stdin-filename", "stub.pyi", "-"]
    ordered = [
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--select",
        "I",
        "--fix",
        "--quiet",
        "--stdin-filename",
        "stub.pyi",
        "-",
    ]
    for line in (ordered, command):
        text = subprocess.run(line, input=text, capture_output=True, text=True, check=True).stdout
    return text


if __name__ == "__main__":
    for name, module in MODULES.items():
        Path(tippetop.__file__).with_name(f"{name}.pyi").write_text(stub(module), encoding="utf-8")
