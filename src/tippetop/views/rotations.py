"""The rotations of the pages as JavaScript, written down by the symbols that they are fed."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, axes, between, outer
from ..mechanics.writing import JAVASCRIPT, function


@cache
def module() -> str:
    """The module `rotation.js` of every page; as `rotation.d.ts` says."""
    q, v = Quaternion, Vector
    return "\n".join(
        [
            _exported("axes", axes, {"q": q}, 3),
            _exported("outer", outer, {"first": v, "third": v}, 4),
            _exported(
                "between", between, {"p": q, "wp": v, "q": q, "wq": v, "h": None, "s": None}, 1
            ),
        ]
    )


def _exported(name: str, formula: Callable, inputs: dict[str, Any], rows: int) -> str:
    """A function of numbers and lists of them, which gives so many rows of numbers; one row as a
    list.
    """
    counts = [len(record._fields) if record else 1 for record in inputs.values()]
    texts = [
        f"{n}[{i}]" if r else n
        for n, r in inputs.items()
        for i in range(len(r._fields) if r else 1)
    ]

    def flat(symbols: Sequence[Any]) -> list:
        rest = iter(symbols)
        taken = [[next(rest) for _ in range(count)] for count in counts]
        given = [
            record(*part) if record else part[0]
            for record, part in zip(inputs.values(), taken, strict=True)
        ]
        result = formula(*given)
        return [number for row in (result if rows > 1 else [result]) for number in row]

    lines, results = function(JAVASCRIPT, texts, flat)
    width = len(results) // rows
    parts = [f"[{', '.join(results[k * width : (k + 1) * width])}]" for k in range(rows)]
    value = f"[{', '.join(parts)}]" if rows > 1 else parts[0]
    return (
        f"export const {name} = ({', '.join(inputs)}) => {{\n{chr(10).join(lines)}\nreturn "
        f"{value};\n}};\n"
    )
