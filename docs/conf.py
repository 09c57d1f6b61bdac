"""How Sphinx makes the manual: python -m sphinx -W -b html docs build/manual."""

import os
from pathlib import Path
from typing import Any

from docutils import nodes

import tippetop


os.environ["TIPPETOP_QUIET"] = "1"  # no progress bars in the cells of pages
project = "tippetop"
author = "tippetop developers"
copyright = "2026, tippetop developers"
version = release = tippetop.__version__

extensions = [
    "myst_nb",  # pages are notebooks: every number and picture is computed while the manual is made
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx-mathjax-offline",  # formulas without a network
]
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parents[1] / "build" / "manual-cache")
nb_execution_raise_on_error = True
nb_execution_timeout = 900
nb_merge_streams = True
nb_render_markdown_format = "gfm"
default_role = "code"  # of `names` in docstrings
numpydoc_show_class_members = False
autodoc_typehints = "none"
autosummary_generate = True

html_theme = "furo"
html_title = f"tippetop {version}"
html_extra_path = ["playground.html"]
html_static_path = ["static"]
html_css_files = ["tables.css"]
smartquotes = False  # --overwrite is not an en dash
html_show_sourcelink = False
exclude_patterns = ["_build"]


def _formulas_as_text(
    app: object, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """|v_A| in a docstring is a formula, not a substitution of reStructuredText."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def _describe_figures(app: object, doctree: nodes.document) -> None:
    """Give each computed figure the title of its section as alternative text."""
    for image in doctree.findall(nodes.image):
        section = image.parent
        while not isinstance(section, nodes.section):
            section = section.parent
        image.setdefault("alt", f"Figure: {section.next_node(nodes.title).astext()}")


def _keep_names_whole(app: object, doctree: nodes.document) -> None:
    """Mark code without blanks in tables, which a browser would break after a hyphen."""
    for entry in doctree.findall(nodes.entry):
        for literal in entry.findall(nodes.literal):
            if len(literal.astext()) <= 30 and " " not in literal.astext():
                literal["classes"].append("name")


def _link_pages(app: Any, error: Exception | None) -> None:
    """Let each copy of the playground link to the page of the manual instead of its source."""
    for copy in Path(app.outdir).rglob("playground.html"):
        page = os.path.relpath(Path(app.outdir) / "why.html", copy.parent)
        text = copy.read_text(encoding="utf-8")
        copy.write_text(text.replace('href="why.md"', f'href="{page}"'), encoding="utf-8")


def setup(app: Any) -> None:
    """Connect the functions above to Sphinx."""
    app.connect("autodoc-process-docstring", _formulas_as_text, priority=100)
    app.connect("doctree-read", _describe_figures)
    app.connect("doctree-read", _keep_names_whole)
    app.connect("build-finished", _link_pages)
