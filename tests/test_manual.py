"""The manual: every public name, every topic and every page is in it.

(`.ci/nightly manual` builds it.)
"""

import pydoc
import re
from pathlib import Path
from types import ModuleType

import tippetop
from tippetop.cli.help_command import topics


DOCS = Path(__file__).parents[1] / "docs"


def test_every_public_name_is_in_the_reference() -> None:
    listed = set()
    for page in (DOCS / "reference" / "python").glob("*.md"):
        module = ""
        for line in page.read_text(encoding="utf-8").splitlines():
            if current := re.match(r"\.\. currentmodule:: (\S+)", line):
                module = current[1]
            elif name := re.match(r"\.\. auto(?:class|function):: (\S+)", line):
                listed.add(name[1] if "." in name[1] else f"{module}.{name[1]}")
            listed |= {
                f"tippetop.{name}" for name in re.findall(r"`tt\.(extending\.[A-Z]+)`", line)
            }
    faces = [
        value for name in dir(tippetop) if isinstance(value := getattr(tippetop, name), ModuleType)
    ]
    inner = {f"{face.__name__}.{name}" for face in faces for name in face.__all__}
    calls = {
        f"tippetop.{name}"
        for name in dir(tippetop)
        if not isinstance(getattr(tippetop, name), ModuleType)
    }
    errors = {"tippetop.InputError", "tippetop.StoreError", "tippetop.Interrupted"}
    assert inner - listed == {"tippetop.extending.units"}
    assert calls - listed == errors | {"tippetop.__version__"}
    assert [name for name in sorted(listed) if pydoc.locate(name) is None] == []


def test_every_topic_has_a_page() -> None:
    pages = "\n".join(
        page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md")
    )
    assert all(f'topics()["{topic}"]' in pages for topic in topics())


def test_every_page_is_in_the_table_of_contents() -> None:
    lists = "\n".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("index.md"))
    inner = {line.strip().rpartition("<")[2].rstrip(">") for line in lists.splitlines()}
    for page in DOCS.rglob("*.md"):
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert name == "index" or name in inner or name.rpartition("/")[2] in inner, name
