"""The Python of a how-to page."""

import re
from pathlib import Path
from typing import Any

import numpy as np


HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"


def names_of(page: str) -> dict[str, Any]:
    """Return what the Python of a page defines."""
    names: dict[str, Any] = {}
    text = (HOW_TO / page).read_text(encoding="utf-8")
    for block in re.findall(r"```python\n(.*?)```", text, flags=re.S):
        exec(compile(block, page, "exec"), names)
    return names


def stick_slip(b: dict[str, float], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the times at which the block on the belt slips, and those at which it sticks again."""
    frequency = np.sqrt(b["k"] / b["m"])
    torn, middle = (b[name] * b["m"] * b["g"] / b["k"] for name in ("sticks", "mu"))
    slipping = 2 * (np.pi - np.arctan2((torn - middle) * frequency, b["belt"])) / frequency
    period = slipping + 2 * (torn - middle) / b["belt"]
    slips = torn / b["belt"] + period * np.arange(count)
    return slips, slips + slipping
