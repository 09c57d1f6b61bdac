"""The atlas of the corrected theory: every correction is evaluated, every page has its entries,
every name exists.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import mpmath as mp
import pytest


ATLAS = Path(__file__).parents[2] / "docs" / "atlas"
DIGITS = mp.mp.dps
sys.path.insert(0, str(ATLAS))

import errata  # noqa: E402
import formulas  # noqa: E402
import holding  # noqa: E402


RECORDS = errata.every()
mp.mp.dps = DIGITS
SAME = 1e-25  # residual of a form that holds; the numbers have 50 digits
OTHER = 1e-6  # residual of one that does not
QUADRATIC = 5  # a slip that changes no number


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mp.workdps(50):
        yield


def test_there_are_the_36_corrections() -> None:
    assert sorted(RECORDS) == list(range(1, 37))


@pytest.mark.parametrize("number", [n for n, record in RECORDS.items() if record.motion])
def test_the_corrected_formula_holds_and_the_printed_one_does_not(number: int) -> None:
    found = errata.residuals(RECORDS[number], states=3)
    assert max(found.correct) < SAME
    assert number == QUADRATIC or min(found.printed) > OTHER


@pytest.mark.parametrize("number", [n for n, record in RECORDS.items() if not record.motion])
def test_the_corrected_statement_is_so_and_the_printed_one_is_not(number: int) -> None:
    findings = RECORDS[number].evidence()
    for finding in findings:
        assert finding.correct is None or finding.found == finding.correct, finding.case
    assert any(
        finding.printed is not None and finding.found != finding.printed for finding in findings
    )
    if number in (19, 20):  # what is said to hold all the same
        assert any(finding.found == finding.correct is not None for finding in findings)


def test_every_entry_can_be_cited_and_shows_its_own_record() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in sorted(ATLAS.glob("*.md")))
    anchors, cells = (
        [int(n) for n in re.findall(pattern, text, flags=re.M)]
        for pattern in (r"^\(erratum-(\d+)\)=$", r"^show\((\d+)\)")
    )
    assert sorted(anchors) == sorted(cells) == list(range(1, 37))
    assert anchors == cells
    assert {int(n) for n in re.findall(r"^\(claim-(\d+)\)=$", text, flags=re.M)} == set(range(1, 9))
    known = {f"erratum-{n}" for n in anchors} | {f"claim-{n}" for n in range(1, 9)}
    assert {target for target in re.findall(r"<((?:erratum|claim)-\d+)>", text)} <= known


def test_the_list_has_every_number_of_the_source_once() -> None:
    numbers = [number for entry in formulas.entries() for number in entry.numbers()]
    assert sorted(numbers) == sorted(formulas.wanted())


@pytest.mark.parametrize(
    "name", sorted({name for entry in formulas.entries() for name in entry.names})
)
def test_the_list_names_what_exists(name: str) -> None:
    assert formulas.exists(name)


def test_the_list_and_the_corrections_agree() -> None:
    """A formula that is listed as wrong names its correction, and each correction is named."""
    named = {
        int(name.split()[1])
        for e in formulas.entries()
        for name in e.names
        if name.startswith("erratum")
    }
    assert named == set(RECORDS)
    for entry in formulas.entries():
        if entry.status != "holds":
            assert any(name.startswith(("erratum", "claim")) for name in entry.names), entry.what
    assert not formulas.exists("tt.nothing")
    assert not formulas.exists("column nothing")


def test_formulas_that_are_listed_as_right_are_right() -> None:
    found = holding.worst(states=2)
    assert max(found.values()) < SAME
    assert len(found) == sum(map(len, holding.HOLDING.values())) >= 50
    status = {number: entry.status for entry in formulas.entries() for number in entry.numbers()}
    assert {status[number] for number in found} <= {"holds", "sign not fixed"}
