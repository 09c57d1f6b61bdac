"""The pictures and numbers of pages that are read as files are those of the code."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tippetop as tt


DOCS = Path(__file__).parents[2] / "docs"
pictures = SimpleNamespace(**runpy.run_path(str(DOCS / "pictures.py")))


def test_each_picture_is_drawn_by_the_code_of_its_page() -> None:
    """Else: python docs/pictures.py."""
    image = pytest.importorskip("PIL.Image")
    drawn = {path.stem: image.open(path).text["Source"] for path in pictures.PICTURES.glob("*.png")}
    assert drawn == pictures.sources()


def test_the_worksheet_is_the_lesson_and_the_handout() -> None:
    """Else: python docs/pictures.py."""
    text = (DOCS / "tutorials" / "worksheet.html").read_text(encoding="utf-8")
    assert text == pictures.worksheet()
    assert "$" not in text.partition("</style>")[2], "formulas are text: nothing renders them"


def test_the_numbers_of_why_are_computed_ones() -> None:
    text = (DOCS / "why.md").read_text(encoding="utf-8")
    run = tt.run("inverting", until=8.0)
    rows, limits = run.trajectory, tt.theory.thresholds("inverting")
    lean = np.degrees(np.arccos(rows.L.sel(xyz="z") / np.sqrt((rows.L**2).sum("xyz"))))
    start, end = (1e3 * float(rows.energy[i]) for i in (0, -1))
    turns = {
        name: f"{limits[name].value:.1f} rad/s ({limits[name].value / 2 / np.pi:.1f} turns"
        for name in ("spin_upright", "spin_full", "spin_inverted")
    }
    said = [
        f"more than {float(lean.max()):.1f} degrees from the vertical",
        f"starts with {start:.1f} mJ and ends with {end:.1f} mJ",
        f"turned {start - end:.1f} mJ into heat",
        f"only {2e3 * 0.02 * 9.82 * 0.3 * 0.02:.1f} mJ went into the height",
        *turns.values(),
        f"first time after **{run.summary.inversion['first_equator']:.2f} s**",
    ]
    for mu in (0.01, 0.03, 0.1, 0.3):
        slow = tt.run("inverting", friction={"mu": mu}, until=2.0 / mu, output_step=0.1)
        when = slow.summary.inversion["first_equator"]
        said.append(f"| {mu} | {when:.2f} | {mu * when:.3f} |")
    assert [words for words in said if words not in text] == []
