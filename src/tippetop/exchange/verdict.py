"""What a comparison of several files says, as plain data and as text."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..problem import Problem
from .comparison import Compared, compare, orders, verdict
from .motion import Convention


class Verdict:
    """Motions of another program beside the exact one; it prints what it says.

    Attributes
    ----------
    motions : tuple of Compared
        Of each file: `t`, `curves` of differences by name, and `numbers`.
    orders : list of dict
        Orders of convergence between files of different steps.
    title : str
        What the reference is.
    """

    def __init__(self, motions: Sequence[Compared], orders: list[dict[str, Any]], title: str):
        self.motions, self.orders, self.title = tuple(motions), orders, title

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, as `tippetop compare --json` prints it."""
        files = [{"step": m.step, **m.numbers} for m in self.motions]
        return {
            **(files[0] if len(files) == 1 else {"files": files}),
            **({"orders": self.orders} if self.orders else {}),
        }

    def __str__(self) -> str:
        lines = []
        for m in self.motions:
            lines += [f"{m.path}: {sentence}" for sentence in verdict(m)]
            if "suspicion" in m.numbers:
                lines.append(f"{m.path}: {m.numbers['suspicion']}")
        for pair in self.orders:
            values = ", ".join(f"{name} {value:.2f}" for name, value in pair.items() if name != "steps")
            coarse, fine = pair["steps"]
            lines.append(f"order of convergence from step {coarse:g} to {fine:g} s: {values or 'none can be given'}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {', '.join(str(m.path) for m in self.motions)} with {self.title}>"


def judged(problem: Problem, files: Sequence[Path], convention: Convention) -> tuple[list[Compared], list[Any], str]:
    """What a `Verdict` is made of: each file beside the problem, orders of convergence, a title. Raises InputError."""
    motions = [compare(problem, file, convention) for file in files]
    return motions, orders(motions), f"{problem.system.title}, {problem.form.name} form"
