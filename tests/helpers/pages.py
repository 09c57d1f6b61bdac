"""The Python of a how-to page."""

import re
from pathlib import Path
from typing import Any


HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"


def names_of(page: str) -> dict[str, Any]:
    """Return what the Python of a page defines."""
    names: dict[str, Any] = {}
    text = (HOW_TO / page).read_text(encoding="utf-8")
    for block in re.findall(r"```python\n(.*?)```", text, flags=re.S):
        exec(compile(block, page, "exec"), names)
    return names
