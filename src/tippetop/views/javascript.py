"""Functions of JavaScript, written from the formulas of this package.

A formula goes in; the text of an arrow function comes out, by `mechanics.writing`.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from ..mechanics.operand import Vector, leaves, refill
from ..mechanics.rotation import Quaternion, axes, between, outer
from ..mechanics.writing import JAVASCRIPT, function


def arrow(inputs: dict[str, Any], formula: Callable, *, fills: bool = False, rows: int = 1) -> str:
    """Write a formula as an arrow function.

    Parameters
    ----------
    inputs
        Name of each argument -> a record of the same shape, or None for a number.
    formula
        Takes numbers and records, and returns numbers.
    fills
        Whether the results fill a further argument `out`.
    rows
        The number of lists in which several results are returned; one result is a number.
    """
    texts = [
        name if record is None else f"{name}[{i}]"
        for name, record in inputs.items()
        for i in range(1 if record is None else len(leaves(record)))
    ]

    def flat(symbols: list) -> list:
        """Return the results of the formula as a flat list, for symbols instead of numbers.

        `symbols` are those of all inputs, record after record, in the order of `inputs`.
        """
        rest = iter(symbols)
        given = [next(rest) if r is None else refill(r, rest) for r in inputs.values()]
        return leaves(formula(*given))

    lines, results = function(JAVASCRIPT, texts, flat)
    if fills:
        lines += [f"out[{i}] = {result};" for i, result in enumerate(results)]
    else:
        width = len(results) // rows
        parts = [f"[{', '.join(results[k * width : (k + 1) * width])}]" for k in range(rows)]
        value = f"[{', '.join(parts)}]" if rows > 1 else parts[0]
        lines.append(f"return {value if len(results) > 1 else results[0]};")
    return f"({', '.join([*inputs, *['out'] * fills])}) => {{\n{chr(10).join(lines)}\n}}"


@cache
def rotations() -> str:
    """Return the module `rotation.js` of every page; see `rotation.d.ts`."""
    q = Quaternion(1, 0, 0, 0)
    v = Vector(0, 0, 0)
    functions = {
        "axes": arrow({"q": q}, axes, rows=3),
        "outer": arrow({"first": v, "third": v}, outer, rows=4),
        "between": arrow({"p": q, "wp": v, "q": q, "wq": v, "h": None, "s": None}, between),
    }
    return "\n".join(f"export const {name} = {text};\n" for name, text in functions.items())
