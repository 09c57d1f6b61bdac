"""Plain English: turns of phrase to avoid, counted in the source and in the manual."""

import re
from collections import Counter
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[1]
PATTERN = re.compile(
    r"\b(what (is|was|are|were|it|comes|happens)|so many|of (one|its)('s)? own"
    r"|nobody|somebody|whoever|(is|are|was) (?-i:none)|beside|alike"
    r"|(a|the|each|every) [a-z]+ (says|tells|asks|knows|wants))\b",
    re.IGNORECASE,
)


def hits(*patterns: str) -> list[str]:
    """Return the lines of all files that match a glob pattern and use such a turn."""
    paths = [path for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    return [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in paths
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if PATTERN.search(line)
    ]


@pytest.mark.parametrize(
    ("patterns", "most"),
    [
        (("src/**/*.py", "kernels/**/*.py"), 40),
        (("docs/**/*.md", "*.md", "bench/README.md"), 20),
    ],
    ids=["source", "manual"],
)
def test_few_lines_use_these_turns(patterns: tuple[str, ...], most: int) -> None:
    found = hits(*patterns)
    assert len(found) <= most, "\n".join(found)


def test_a_file_name_occurs_once() -> None:
    """Public modules aside: they share names with the modules whose content they offer."""
    source = ROOT / "src" / "tippetop"
    public = {path.name for path in source.glob("*.py")}
    names = Counter(p.name for p in source.rglob("*.py") if p.name not in public | {"__init__.py"})
    assert [name for name, count in names.items() if count > 1] == []
