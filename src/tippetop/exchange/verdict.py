"""The result of a comparison of several files, as plain data and as text.

`library.exchanging.Comparison` is a `Verdict` that users see.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..problem import Problem
from .comparison import Compared, compare, orders_of, shown
from .headers import UNITS
from .motion import Convention


class Verdict:
    """Motions of another program compared with the exact one.

    Attributes
    ----------
    motions : tuple of Compared
        Of each file: `t`, `curves` of differences by name, and `numbers`.
    orders : list of dict
        Orders of convergence between files of different steps.
    title : str
        The name of the reference.
    """

    def __init__(self, problem: Problem, files: Sequence[Path], convention: Convention):
        self.motions = tuple(compare(problem, file, convention) for file in files)
        self.orders = orders_of(self.motions)
        self.title = f"{problem.system.title}, {problem.form.name} form"

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, as `tippetop compare --json` prints it."""
        files = [{"step": m.step, **m.numbers} for m in self.motions]
        plain = files[0] if len(files) == 1 else {"files": files}
        return plain | {"orders": self.orders} if self.orders else plain

    def __str__(self) -> str:
        """Return the table of differences, remarks on files, and orders of convergence, as text."""
        lines = _table(self.motions)
        for m in self.motions:
            if "reference_ended" in m.numbers:
                lines.append(f"{m.path}: the reference ended: {m.numbers['reference_ended']}.")
            if "suspicion" in m.numbers:
                lines.append(f"{m.path}: {m.numbers['suspicion']}")
        for pair in self.orders:
            values = ", ".join(
                f"{name} {value:.2f}" for name, value in pair.items() if name != "steps"
            )
            coarse, fine = pair["steps"]
            lines.append(
                f"order of convergence from step {coarse:g} to {fine:g} s: "
                f"{values or 'none can be given'}"
            )
        return "\n".join(lines)

    __repr__ = __str__


def _table(motions: Sequence[Compared]) -> list[str]:
    """Return a table of motions, the best first, as lines; one motion is a column."""
    from pandas import DataFrame

    ordered = sorted(motions, key=lambda m: m.numbers[m.main]["max"])
    rows = DataFrame(map(_row, ordered)).fillna("-")
    one = len(rows) == 1
    text = rows.T.to_string(header=False) if one else rows.to_string(index=False)
    return text.splitlines()


def _row(motion: Compared) -> dict[str, str]:
    """Return the numbers of one motion as text; `-` for what its file lacks."""
    numbers = motion.numbers
    name = motion.main
    errors = {
        quantity: f"{numbers[quantity]['max']:.2g} {UNITS.get(quantity, 'rad')}"
        for quantity in motion.curves.keys() & numbers
    }
    left = numbers[name]["leaves"]["0.1"]
    contact = numbers.get("contact")
    return {
        "file": motion.path.name,
        "largest error": f"{name} {errors.pop(name)}",
        "0.1 exceeded at": "never" if left is None else f"{left:.4g} s",
        "until": f"{numbers['until']:.4g} s",
        "error of energy": shown(numbers.get("energy_error")),
        "error of Jellett": shown(numbers.get("jellett_error")),
        "in the floor": f"{contact['penetration']:.2g} m" if contact else "-",
        **{f"error of {other}": errors[other] for other in sorted(errors)},
    }
