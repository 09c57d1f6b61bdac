"""The words of this project are those of the field: retired ones appear nowhere that
people read.
"""

import ast
import re
from pathlib import Path


ROOT = Path(__file__).parents[1]
PLACES = (
    "src/tippetop",
    "kernels",
    "docs",
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "bench/README.md",
)
ENDINGS = (".py", ".pyi", ".toml", ".md")

RETIRED = {  # a pattern of a retired word -> the word to use
    r"books?\b": "tally, tallies",
    r"doors?\b": "validation, scenario",
    r"reliefs?\b": "coefficients",
    r"bow\b": "psi",
    r"skid\b": "slip",
    r"told\b": "summary, printed",
    r"said\b": "sentence, described, given",
    r"course\b": "integration",
    r"house\b": "package, rooms",
    r"(a|the) person('s)?\b": "the user",
    r"tops that cannot be\b": "invalid tops",
    r"absurd tops?\b": "invalid tops",
    r"cannot be cannot be\b": "are invalid",
    r"(goes|go|going|gone) on\b": "continues",
    r"what became of\b": "fate",
    r"sliding died\b": "sliding ended",
    r"(drawn|shown|made|found)\(": "draw_map, reporting: a verb for what acts, a noun for what "
    "it gives",
    r"ScenarioError\b": "InputError",
    r"twofold\b": "doubledouble",
    r"yielding\b": "contact_mobility",
    r"grip2\b": "friction_force2",
    r"(ALONE|FRESH|ENOUGH)\b": "a name that says what it is",
    r"a line (of results )?(per|for each) top\b": "a row",
    r"unfolded\b": "normalised_to",
    r"at_once\b": "SLICES_PER_CHECK",
    r"(Course|Measured|Lean|Relief|Two|Shown|Machine|Sources|Rules)\b": "Integration, "
    "Outcomes, Point, ...",
    r"(remarks|worded|varied|sweep_lines)\b": "a verb for what acts, a noun for what it gives",
    r"(JAMMED|POLE)\b": "Domain: must stay positive",
    r"precession\b(?= *[=:*])": "phi_dot_s2",
    r"(slant|stretch|folded)\b": "normalised_to, length_unit, ...",
    r"who computes\b": "where it is computed",
    r"nobody keeps\b": "that is not kept",
    r"to be looked at together\b": "to be compared",
    r"what \d+ bits can show\b": "the precision of",
}

ALLOWED = {  # (file or folder, what stands in the line) -> why
    ("CHANGELOG.md", "ScenarioError"): "says what the name was",
    ("README.md", "## "): "titles in plain English",
    ("bench/", "## "): "titles in plain English",
    ("docs/", "Measured"): "plain English",
    (
        "src/tippetop/ensembles/outcomes.py",
        '"what became of the top"',
    ): "an attribute of stores, whose bytes stay",
    (
        "src/tippetop/runs/reporting.py",
        "settled: sliding died at",
    ): "an attribute of stores, whose bytes stay",
}


def hits() -> list[tuple[str, int, str, str]]:
    """File, line, retired word and line of each use."""
    files = [
        p
        for place in PLACES
        for p in ([ROOT / place] if (ROOT / place).is_file() else (ROOT / place).rglob("*"))
    ]
    patterns = [
        re.compile(rf"(?<![\w.-]){p}", re.I if p.replace(r"\b", "").islower() else 0)
        for p in RETIRED
    ]
    any_of_them = re.compile(
        rf"(?<![\w.-])(?:{'|'.join(RETIRED)})", re.I
    )  # most lines have none: one look for forty
    found = []
    for path in sorted(p for p in files if p.suffix in ENDINGS):
        name = str(path.relative_to(ROOT))
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if not any_of_them.search(line):
                continue
            if any(name.startswith(file) and part in line for (file, part) in ALLOWED):
                continue
            found += [
                (name, number, m.group(), line.strip()) for p in patterns if (m := p.search(line))
            ]
    return found


def test_retired_words_are_gone() -> None:
    found = hits()
    assert not found, "\n" + "\n".join(
        f"{name}:{number}: {word}: {line}" for name, number, word, line in found
    )


PARTICIPLES = {
    "found",
    "made",
    "said",
    "told",
    "shown",
    "drawn",
    "worded",
    "book",
    "course",
    "door",
    "house",
}


def test_no_name_is_a_participle_or_a_metaphor() -> None:
    """A variable or an argument says what it holds, not that it was found or made."""
    faults = []
    for path in [*(ROOT / "src").rglob("*.py"), *(ROOT / "kernels").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = (
                node.arg
                if isinstance(node, ast.arg)
                else node.id
                if isinstance(node, ast.Name)
                else ""
            )
            if name in PARTICIPLES:
                faults.append(f"{path.relative_to(ROOT)}:{node.lineno}: {name}")
    assert not faults, "\n".join(faults)
