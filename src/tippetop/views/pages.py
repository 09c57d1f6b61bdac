"""HTML files with their style, one script and data; they fetch nothing.

The modules of `page/` and plain data go in; the text of one HTML file comes out.
"""

import html
import json
import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..arguments import in_python, path_of
from ..store.files import write_text
from .javascript import rotations


IMPORT = re.compile(r'^import\s+\{([^}]*)\}\s+from\s+"\./([\w.]+)";\n', re.MULTILINE)
EXPORT = re.compile(
    r"^export\s+(?=(?:async\s+)?(?:const|let|function|class)\s+(\w+))", re.MULTILINE
)


@cache
def source(name: str) -> str:
    """Return the text of a file of the folder `page`."""
    return files(__package__).joinpath("page", name).read_text(encoding="utf-8")


def script(entry: str, written: Mapping[str, str]) -> str:
    """Return a module of the page and its imports as one script.

    Parameters
    ----------
    entry
        The name of a file.
    written
        Modules other than files and `rotation.js`: name -> text.

    Returns
    -------
    str
        Every module is a function that returns its exports, after the modules that it imports.
        Comments that begin a line, and indentation, are left out.
    """
    parts: dict[str, str] = {}
    written = {"rotation.js": rotations(), **written}

    def take(name: str) -> None:
        """Append the text of a module to `parts`, after those that it imports, once.

        It becomes a constant: the result of a function that returns the exports. `IMPORT` and
        `EXPORT` know only the forms of both statements that the modules of `page/` have.
        """
        text = written[name] if name in written else source(name)
        imports = IMPORT.findall(text)
        for _, other in imports:
            if other not in parts:
                take(other)
        imports = [(" ".join(names.split()), other) for names, other in imports]
        lines = [f"const {{{names}}} = {_module(other)};" for names, other in imports]
        exported = ", ".join(EXPORT.findall(text))
        body = EXPORT.sub("", IMPORT.sub("", text))
        parts[name] = (
            f"const {_module(name)} = (() => {{\n{chr(10).join(lines)}\n{body}\n"
            f"return {{{exported}}};\n}})();\n"
        )

    take(entry)
    text = '"use strict";\n' + "".join(parts.values())
    text = re.sub(r"^\s*(?:/\*\*.*?\*/\s*?\n|//[^\n]*\n)", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub("^ +", "", text, flags=re.MULTILINE)


def _module(name: str) -> str:
    """Return the name of the JavaScript constant that has the exports of a module."""
    return f"module_{name.partition('.')[0]}"


def page(
    title: str,
    entry: str,
    data: Any,
    written: Mapping[str, str],
    *,
    aside: str = "",
    about: str = "",
) -> str:
    """Return the text of an HTML file.

    Parameters
    ----------
    title
        Of the window.
    entry
        The module that starts it.
    data
        Plain data, stored as JSON, which the module `entry` reads.
    written
        Modules for this page alone: name -> text.
    aside
        A fragment of HTML before the picture.
    about
        The line below the title.
    """
    # no tag may end the elements that contain data and script
    text = json.dumps(data, allow_nan=False, ensure_ascii=False).replace("<", "\\u003c")
    parts = {
        "title": html.escape(title),
        "style": source("page.css"),
        "aside": aside,
        "about": html.escape(about),
        "data": text,
        "script": script(entry, written).replace("</script", "<\\/script"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda field: parts[field[1]], source("page.html"))


class Page:
    """An HTML file that needs no network; a notebook shows it.

    Attributes
    ----------
    text : str
        All of it.

    Examples
    --------
    >>> import tippetop as tt
    >>> tt.run("inverting", until=8.0).view().save("inverting.html")
    """

    def __init__(self, text: str):
        self.text = text

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write it to a file.

        Parameters
        ----------
        path : path-like
            Usually it ends with `.html`.
        overwrite : bool
            Whether an existing file is replaced.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        StoreError
            If it exists, or cannot be written.
        """
        place = path_of("path", path)
        with in_python():
            write_text(place, self.text, overwrite=overwrite)
        return place

    def _repr_html_(self) -> str:
        """Return the page in a frame, for notebooks."""
        frame = 'style="width:100%;height:720px;border:0" title="tippetop" allowfullscreen'
        return f'<iframe loading="lazy" srcdoc="{html.escape(self.text)}" {frame}></iframe>'
