"""Words and letters of the figures: numbers with their units, titles of runs, and what tells
several runs apart.
"""

from typing import Any

import numpy as np

from ..columns import SUPERSCRIPTS, units_text
from .style import broken, compact, letters


PRECISIONS = {"double": "64-bit numbers", "longdouble": "80-bit numbers", "quad": "128-bit numbers"}
TABLES = ("parameters", "friction", "contact", "stem", "initial")
MOST_NUMBERS = 2  # of bodies that differ in more, the names are given
RUN_KEYS = ("precision", "tolerance")


def number(value: float, digits: int = 6) -> str:
    """A number as people write it: 0.1, −4.615, 6.894 × 10⁻⁶."""
    mantissa, _, power = f"{value:.{digits}g}".partition("e")
    text = mantissa.replace("-", "−")
    return f"{text} × 10{str(int(power)).translate(SUPERSCRIPTS)}" if power else text


def quantity(value: float, unit: str, digits: int = 6) -> str:
    """A number with its unit."""
    return (
        number(value, digits)
        if unit in ("", "1")
        else f"{number(value, digits)} {units_text(unit)}"
    )


def end_of(values: Any) -> str:
    """What the last known value of a curve along a run is, which is NaN from where the stem takes
    over.
    """
    return "its end" if np.isfinite(values[-1]) else "last on its sphere"


def entries(table: dict[str, Any], attrs: dict[str, Any], at_start: bool = False) -> list[str]:
    """The entries of a table of a run, each as symbol = value unit."""
    words, units, symbols = [], attrs.get("units", {}), attrs.get("symbols", {})
    for key, value in table.items():
        symbol = symbols.get(key, key.replace("_", " "))
        if key == "centre_at_rest":
            words += ["centre of mass at rest"] if value else []
        elif isinstance(value, int | float) and not isinstance(value, bool):
            words.append(
                f"{symbol}{'(0)' if at_start else ''} = {quantity(value, units.get(key, '1'))}"
            )
        elif not isinstance(value, dict | list):
            words.append(f"{symbol} = {value}")
    return words


def friction(table: dict[str, Any], attrs: dict[str, Any]) -> str:
    """A friction law in words, with its numbers."""
    numbers = entries({key: value for key, value in table.items() if key != "law"}, attrs)
    return ", ".join(
        [attrs.get("law", f"{table['law']} friction"), *numbers] if "law" in table else numbers
    )


def title(attrs: dict[str, Any]) -> str:
    """The system on a line; what makes this run this run on the next."""
    details = entries(attrs.get("initial", {}), attrs, at_start=True)
    if law := friction(attrs.get("friction", {}), attrs):
        details.append(law)
    head = attrs["title"][:1].upper() + attrs["title"][1:]
    most = letters()
    if compact():
        return broken(head, most)
    kept = ", ".join(word.replace(" ", "\N{NO-BREAK SPACE}") for word in details)
    return "\n".join(broken(text, most) for text in (head, kept) if text)


def shared(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The attributes of several runs as far as all have the same, for their common title."""
    first = runs[0]
    common: dict[str, Any] = {
        name: first[name] for name in ("title", "units", "symbols", "law") if name in first
    }
    if any(attrs.get("system") != first.get("system") for attrs in runs):
        common["title"] = f"{len(runs)} runs"
    elif any(attrs["title"] != first["title"] for attrs in runs):
        common["title"] = first["title"].partition(",")[0]
    for name in ("initial", "friction"):
        if name == "friction" and len({str(attrs.get(name, {}).get("law")) for attrs in runs}) > 1:
            continue  # the same letter in another law is another number
        common[name] = {
            key: value
            for key, value in first.get(name, {}).items()
            if all(attrs.get(name, {}).get(key) == value for attrs in runs)
        }
    return common


def differences(runs: list[dict[str, Any]], names: list[str]) -> list[str]:
    """For each run the words that tell it from the others: what its scenario has and theirs have
    not; its name as well, where there is no difference.
    """
    tables = [
        name
        for name in TABLES
        if any(attrs.get(name, {}) != runs[0].get(name, {}) for attrs in runs)
    ]
    if not all("contact" in attrs for attrs in runs):
        tables = [name for name in tables if name != "contact"]  # it follows from the friction law
    words = []
    for attrs, called in zip(runs, names, strict=True):
        parts: list[str] = []
        for key, text in (("system", attrs["title"]), ("form", f"{attrs.get('form')} form")):
            parts += [text] if any(other.get(key) != attrs.get(key) for other in runs) else []
        for name in tables:
            own = {
                key: value
                for key, value in attrs.get(name, {}).items()
                if any(other.get(name, {}).get(key) != value for other in runs)
            }
            if name == "friction" and "law" in own:
                parts.append(friction(attrs[name], attrs))
            elif name == "parameters" and len(own) > MOST_NUMBERS:
                parts.append(called)
            else:
                parts += entries(own, attrs, at_start=name == "initial")
        for key in RUN_KEYS:
            value = attrs.get("run", {}).get(key)
            if any(other.get("run", {}).get(key) != value for other in runs):
                parts.append(PRECISIONS.get(str(value), f"{key.replace('_', ' ')} {value}"))
        if attrs.get("status", "finished") != "finished":
            parts.append(f"ends: {attrs['status']}".replace("-", " "))
        words.append(", ".join(parts))
    return [
        word if word and words.count(word) == 1 else ": ".join(filter(None, [name, word]))
        for word, name in zip(words, names, strict=True)
    ]
