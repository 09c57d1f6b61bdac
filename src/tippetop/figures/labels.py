"""Texts of figures: numbers with their units, titles of runs, labels of several runs.

Attributes of runs go in; texts come out.
"""

from typing import Any

from ..columns import SUPERSCRIPTS, capitalised, units_text
from .style import heading


Attributes = dict[str, Any]
"""The root attributes of the store of a run."""

MEASURED = {
    "theta": ("inclination θ", "rad"),
    "phi": ("angle φ", "rad"),
    "omega3": ("angular velocity ω₃", "rad s⁻¹"),
    "omega": ("angular velocity", "rad s⁻¹"),
    "gyroscope": ("gyroscope", "rad s⁻¹"),
    "accelerometer": ("accelerometer", "m s⁻²"),
    "place": ("place", "m"),
    "marker": ("marker", "m"),
    "axis": ("axis", ""),  # its residual is an angle
    "orientation": ("inclination θ", "rad"),
}
"""Label and unit of each kind of measurement of `exchange.headers`; others are angles."""
TABLES = ("parameters", "friction", "contact", "stem", "air", "plane", "initial", "run")
RUN_KEYS = ("precision", "tolerance")
MOST_NUMBERS = 2  # bodies that differ in more are named


def number(value: float, digits: int = 6) -> str:
    """Return a number as text: 0.1, −4.615, 6.894 × 10⁻⁶."""
    mantissa, _, power = f"{value:.{digits}g}".partition("e")
    text = mantissa.replace("-", "−")
    return f"{text} × 10{str(int(power)).translate(SUPERSCRIPTS)}" if power else text


def quantity(value: float, unit: str) -> str:
    """Return a number with its unit as text; `unit` is in the form "kg m2 s-1"."""
    return number(value) if unit in ("", "1") else f"{number(value)} {units_text(unit)}"


def entries(table: dict[str, Any], attrs: Attributes, at_start: bool = False) -> list[str]:
    """Return the entries of a table of a run, each as symbol = value unit.

    `attrs` are its root attributes, with the `symbols` of `drawing.with_records`; `at_start` marks
    the symbols as those of the start.
    """
    words = []
    units = attrs.get("units", {})
    symbols = attrs.get("symbols", {})
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


def friction(table: dict[str, Any], attrs: Attributes) -> str:
    """Return the name of a friction law with its numbers, without parts that are 0."""
    shown = {
        k: v for k, v in table.items() if k != "law" and (v or k not in attrs.get("parts", ()))
    }
    numbers = entries(shown, attrs)
    return ", ".join(
        [attrs.get("law", f"{table['law']} friction"), *numbers] if "law" in table else numbers
    )


def title(attrs: Attributes) -> str:
    """Return the system on one line, initial numbers and friction law on the next."""
    details = entries(attrs.get("initial", {}), attrs, at_start=True)
    details.append(friction(attrs.get("friction", {}), attrs))
    kept = [word.replace(" ", "\N{NO-BREAK SPACE}") for word in details if word]
    return heading(capitalised(attrs["title"]), ", ".join(kept))


def _differ(runs: list[Attributes], table: str, key: str) -> bool:
    """Return whether runs differ in a number; the same letter in another law is another number."""
    keys = (key, "law") if table == "friction" else (key,)
    values = {str([attrs.get(table, {}).get(name) for name in keys]) for attrs in runs}
    return len(values) > 1


def shared(runs: list[Attributes]) -> Attributes:
    """Return the attributes of the first run; its title keeps only what all runs share.

    `title` draws them. Further attributes, such as units and symbols, are those of the first run.
    """
    first = runs[0]
    common = first.copy()
    if any(attrs["title"] != first["title"] for attrs in runs):
        same = all(attrs.get("system") == first.get("system") for attrs in runs)
        common["title"] = first["title"].partition(",")[0] if same else f"{len(runs)} runs"
    for name in ("initial", "friction"):
        table = first.get(name, {})
        common[name] = {key: table[key] for key in table if not _differ(runs, name, key)}
    return common


def differences(runs: list[Attributes], names: list[str]) -> list[str]:
    """Return a label for each run: the numbers in which it differs, and its name if none do."""
    words = []
    # a contact that only some runs have follows from their friction law
    tables = [name for name in TABLES if name != "contact" or all(name in attrs for attrs in runs)]
    for attrs, called in zip(runs, names, strict=True):
        parts = [attrs["title"]] if len({other.get("system") for other in runs}) > 1 else []
        for name in tables:
            table = attrs.get(name, {})
            own = {
                key: value
                for key, value in table.items()
                if _differ(runs, name, key) and (name != "run" or key in RUN_KEYS)
            }
            if "law" in own:
                parts.append(friction(table, attrs))
            elif name == "parameters" and len(own) > MOST_NUMBERS:
                parts.append(called)
            else:
                parts += entries(own, attrs, at_start=name == "initial")
        if attrs.get("status", "finished") != "finished":
            parts.append(f"ends: {attrs['status']}".replace("-", " "))
        words.append(", ".join(parts))
    return [
        word if word and words.count(word) == 1 else ": ".join(filter(None, [name, word]))
        for word, name in zip(words, names, strict=True)
    ]
