"""The manual: every public name, every topic and every page is in it. (That it builds is tried by docs.yml.)"""

import re
from pathlib import Path

import tippetop
from tippetop.cli.reference import topics


DOCS = Path(__file__).parents[1] / "docs"


def test_every_public_name_is_in_the_reference() -> None:
    pages = (DOCS / "reference" / "python").glob("*.md")
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    listed = set(re.findall(r"^\.\. auto(?:class|function):: (\w+)", text, re.MULTILINE))
    listed |= set(re.findall(r"`tt\.([A-Z]+)`", text))
    assert listed == set(dir(tippetop)) - {"__version__"}


def test_every_topic_has_a_page() -> None:
    pages = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md"))
    assert all(f'topics()["{topic}"]' in pages for topic in topics())


def test_every_page_is_in_the_table_of_contents() -> None:
    lists = "\n".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("index.md"))
    inner = {line.strip().rpartition("<")[2].rstrip(">") for line in lists.splitlines()}
    for page in DOCS.rglob("*.md"):
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert name == "index" or name in inner or name.rpartition("/")[2] in inner, name
