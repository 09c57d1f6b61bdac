"""The page of thresholds lists the constants of contact with their values."""

import re
from pathlib import Path

from tippetop.engine.jump_programs import CHATTER
from tippetop.mechanics import disc_friction, event
from tippetop.mechanics.contact import (
    contact_phases,
    exits,
    first_slip,
    impact_motion,
    surroundings,
)


PAGE = Path(__file__).parents[2] / "docs/reference/thresholds.md"
MODULES = exits, contact_phases, first_slip, impact_motion, surroundings, disc_friction, event


def test_the_page_has_every_threshold_with_its_value() -> None:
    known = {name: value for module in MODULES for name, value in vars(module).items()}
    known |= {"CHATTER": CHATTER}
    rows = re.findall(r"^\| \**(`[A-Z_`, ]+`)\** \| ([^|]+) \|", PAGE.read_text(), re.MULTILINE)
    assert len(rows) == 18
    for names, values in rows:
        for name, text in zip(re.findall("[A-Z_]+", names), values.split(", "), strict=True):
            *whole, last = re.findall(r"[0-9.]+(?:e-\d+)?", text.split(" = ")[-1])
            value = (
                float(last) + sum(map(float, whole)) if "+" in text else float((*whole, last)[0])
            )
            assert abs(known[name] / value - 1) < 0.05, name
