"""The formulas of a system as JavaScript, written down by the symbols that they are fed."""

from typing import Any

from ..mechanics.contact.body import Body
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.writing import JAVASCRIPT, function


NO_POTENTIAL = "export const potential = null;\n"


def potential(system: System, b: Body) -> str:
    """The module `formulas.js` of the page of a run: V of the system at the momenta that it takes, for this body."""
    if system.potential is None:
        return NO_POTENTIAL
    count, formula = len(system.momenta), system.potential

    def value(z: Any, *momenta: Any) -> list:
        return [formula(z, *momenta, refill(b, map(float, leaves(b))))]

    lines, results = function(JAVASCRIPT, ["z", "first", "second"][: 1 + count], value, lambda symbols: symbols)
    body = "\n  ".join([*lines, f"return {results[0]};"])
    return f"export const potential = (z, first, second) => {{\n  {body}\n}};\n"
