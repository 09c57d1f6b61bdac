"""Write the stubs of `tippetop` and of modules of it, which type checkers and editors read.

Usage: ``python .ci/stub.py``. Functions that take the options of a run get their full signature,
the rest is imported.
"""

import inspect
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import tippetop


MODULES = {
    "__init__": tippetop,
    "derivatives": tippetop.derivatives,
    "friction": tippetop.friction,
}
HEAD = """from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as _np
import xarray as _xr

from .mechanics.event import Event
from .mechanics.form import Quantity
"""
NAMED = re.compile(r"\b((?:[a-z_]\w*\.)+)([A-Z]\w*)")


def written(annotation: Any, imports: set[str], home: Any) -> str:
    """Return an annotation as source; what it names is added to the imports."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)

    def short(found: re.Match[str]) -> str:
        module, name = found[1].removesuffix(".").partition("._")[0], found[2]  # pathlib._local
        if module in ("np", "xr"):
            return found[0]
        if name in home.__all__ and getattr(home, name) is getattr(import_module(module), name):
            return name
        if module == "threading":  # `Event` is another
            imports.add(f"import {module}")
            return found[0]
        imports.add(f"from {module.removeprefix('tippetop')} import {name}")
        return name

    text = NAMED.sub(short, text).replace("NoneType", "None")
    return re.sub(r"\b(np|xr)\.", r"_\1.", text)  # np would be offered as a name of the module


def signature(function: Any, imports: set[str], home: Any) -> str:
    """Return a function as a stub has it."""
    lines: list[str] = []
    found = inspect.signature(function)
    for parameter in found.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in lines:
            lines.append("*")
        default = "" if parameter.default is parameter.empty else " = ..."
        lines.append(f"{parameter.name}: {written(parameter.annotation, imports, home)}{default}")
    arguments = "".join(f"    {line},\n" for line in lines)
    return (
        f"def {function.__name__}(\n{arguments}) -> "
        f"{written(found.return_annotation, imports, home)}: ..."
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
