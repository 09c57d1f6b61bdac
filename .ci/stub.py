"""Write `src/tippetop/__init__.pyi`: what type checkers and editors read about the public names.

Usage: ``python .ci/stub.py``. Functions that take the options of a run get their full signature, the rest is imported.
"""

import inspect
import re
import subprocess
from importlib import import_module
from pathlib import Path
from typing import Any

import tippetop


STUB = Path(__file__).parents[1] / "src" / "tippetop" / "__init__.pyi"
HEAD = """from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import xarray as xr

"""
NAMED = re.compile(r"\b((?:[a-z_]\w*\.)+)([A-Z]\w*)")


def written(annotation: Any, imports: set[str]) -> str:
    """Return an annotation as source; what it names is added to the imports."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)

    def short(found: re.Match[str]) -> str:
        module, name = found[1].removesuffix("."), found[2]
        if module in ("np", "xr"):
            return found[0]
        if name in tippetop.__all__:
            if getattr(tippetop, name) is getattr(import_module(module), name):
                return name
            imports.add(f"import {module}")
            return found[0]
        imports.add(f"from {module.removeprefix('tippetop')} import {name}")
        return name

    return NAMED.sub(short, text).replace("NoneType", "None")


def signature(function: Any, imports: set[str]) -> str:
    """Return a function as a stub has it."""
    lines: list[str] = []
    found = inspect.signature(function)
    for parameter in found.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in lines:
            lines.append("*")
        default = "" if parameter.default is parameter.empty else " = ..."
        lines.append(f"{parameter.name}: {written(parameter.annotation, imports)}{default}")
    arguments = "".join(f"    {line},\n" for line in lines)
    return f"def {function.__name__}(\n{arguments}) -> {written(found.return_annotation, imports)}: ..."


def stub() -> str:
    """Return the text of the stub."""
    imports: set[str] = set()
    functions = []
    for name, place in tippetop._PLACES.items():
        public = getattr(tippetop, name)
        if inspect.isfunction(public) and hasattr(public, "__signature__"):
            functions.append(signature(public, imports))
        else:
            imports.add(f"from .{place} import {name} as {name}")
    text = "\n\n".join([HEAD + "\n".join(sorted(imports)), "__version__: str", *functions]) + "\n"
    command = ["ruff", "format", "--stdin-filename", str(STUB), "-"]
    ordered = ["ruff", "check", "--select", "I", "--fix", "--quiet", "--stdin-filename", str(STUB), "-"]
    for line in (ordered, command):
        text = subprocess.run(line, input=text, capture_output=True, text=True, check=True).stdout
    return text


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
