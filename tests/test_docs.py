"""The Python in README and in the how-tos runs as it stands there, and the pages name files that
exist.
"""

import pkgutil
import re
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest
from nightly import at_night


ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
EXECUTED = [
    *(ROOT / "README.md", ROOT / "docs" / "gallery.md", ROOT / "docs" / "tutorials" / "lesson.md"),
    ROOT / "docs" / "related-bodies.md",
    *sorted((ROOT / "docs" / "how-to").glob("*.md")),
]
EXPENSIVE = ["film-a-top.md", "fit-a-film.md", "gallery.md", "posteriors.md", "related-bodies.md"]
SAMPLERS = (
    "emcee",
    "pymc",
)  # installed in the nightly: a block that needs one is left out elsewhere


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize(
    "page", [at_night(page) if page.name in EXPENSIVE else page for page in EXECUTED], ids=name
)
def test_python_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tippetop.mechanics import friction
    from tippetop.mechanics.systems import SYSTEMS

    for registry in (SYSTEMS, friction.LAWS):
        for key in registry:  # what a page registers is forgotten after it
            monkeypatch.setitem(registry, key, registry[key])
    before = [dict(registry) for registry in (SYSTEMS, friction.LAWS)]
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S)
    assert blocks
    try:
        names: dict[str, object] = {}
        for block in blocks:
            if any(f"import {s}" in block and find_spec(s) is None for s in SAMPLERS):
                continue
            block = block.replace("side = 100", "side = 4")  # of a map that takes minutes
            with warnings.catch_warnings():
                if any(f"import {s}" in block for s in SAMPLERS):  # theirs are not ours
                    warnings.simplefilter("ignore")
                exec(compile(block, name(page), "exec"), names)
    finally:
        for registry, old in zip((SYSTEMS, friction.LAWS), before, strict=True):
            for key in set(registry) - set(old):
                del registry[key]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_and_paths_of_a_page_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#\s]+)\)", text) if "://" not in link]
    missing = [link for link in links if not (page.parent / link).exists()]
    paths = re.findall(r"`((?:src|tests|docs|kernels|bench|\.ci)/[\w./-]+)`", text)
    missing += [path for path in paths if not (ROOT / path).exists()]
    assert missing == []


def test_the_architecture_names_objects_that_exist() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    source = ROOT / "src" / "tippetop"
    rooms = "|".join(path.stem for path in source.iterdir() if not path.stem.startswith("_"))
    named = set(re.findall(rf"\b(?:{rooms})(?:[./][a-z_]\w*)+", text))
    assert len(named) > 15
    for name in named:
        pkgutil.resolve_name("tippetop." + name.removesuffix(".py").replace("/", "."))
    steps = re.findall(r"`([\w/]+)\.(py|c)` `([\w.]+)`", text)
    assert len(steps) > 30
    for file, kind, name in steps:
        if kind == "c":
            assert f" {name}(" in (ROOT / f"{file}.c").read_text(encoding="utf-8")
        else:
            module = file.removesuffix("/__init__").replace("/", ".")
            pkgutil.resolve_name(f"tippetop.{module}:{name}")
