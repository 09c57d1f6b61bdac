"""User-defined bodies of revolution, by the height of their centre of mass on the plane.

Numbers and a height(z, s2, numbers) go in; `body_by_height` returns a class like `Spheroid`, whose
`shape` is an outline as in `contact.outline`.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ..contact.body import inertia_faults
from ..contact.outline import Series, at, shape_by
from ..form import all_are
from ..friction import checked_name
from ..number import Number, RecordType
from ..units import METRE
from .consistency import allowed, answer
from .revolution import Outlined, Spheroid
from .tippe_top import TippeTop


THETA = np.linspace(0, np.pi, 4001)  # an even number of steps, for Simpson's rule
SMOOTH = 1e-5  # of the greatest value: what a derivative may differ from the integral of the next


@np.errstate(all="ignore")
def outline_faults(shape: Any, lengths: list[int]) -> list[str]:
    """Return a sentence on an outline that is not smooth or not convex; [] without one.

    `shape` is a record of `outline.shape_by`; `lengths` are the powers of the metre in the units of
    its numbers, in their order. As a part of `System.checks` it refuses bodies when they are made.
    """
    s = np.sin(THETA)
    z = np.cos(THETA)
    # the height and its derivatives by z, (n,) each
    f = [part + 0 * z for part in at(z, s * s, shape.height).parts]
    twice = shape._make(x * 2.0**n for x, n in zip(shape, lengths, strict=True))
    if not np.allclose(twice.height(z, s * s), 2 * f[0], rtol=1e-9, atol=0, equal_nan=True):
        return [
            "`height` must be the same in all units, but is not: a length in it must be one of "
            "`numbers`."
        ]
    for values, rates in pairwise(f):
        slopes = -(s * rates)
        # Simpson's rule over two steps, of length THETA[2]
        sums = (slopes[:-2:2] + 4 * slopes[1::2] + slopes[2::2]) * (THETA[2] / 6)
        size = SMOOTH * np.max(np.abs(values)) + 1e-9 * np.max(np.abs(f[0]))
        if (rough := ~(np.abs(np.diff(values[::2]) - sums) <= size)).any():
            return [
                "the outline must be smooth, its height and three derivatives by z finite and "
                f"continuous, but it is not near z = {z[2 * np.argmax(rough)]:.3f}."
            ]
    R = f[0] - z * f[1]
    least = np.min([f[0], R, R + s * s * f[2]], axis=0)
    where = np.argmin(least)
    if least[where] <= 0:
        return [
            "the outline must be convex about the centre of mass, its height and both radii of "
            f"curvature greater than 0, but one is {least[where]:.3g} m at z = {z[where]:.3f}."
        ]
    return []


def body_by_height(numbers: Mapping[str, Number], height: Callable) -> type[Outlined]:
    """Return the class of the bodies with these numbers and this height. Raises InputError.

    Its numbers are m, I1, I3, those given, and g; numbers with a default come last, as a
    signature requires.
    """
    shape = answer(
        "`numbers` must be a dict of Number by their names",
        lambda: shape_by(height, numbers),
        lambda found: all_are(numbers, Mapping, Number),
    )
    of_any = TippeTop.parameters
    fields = {"m": of_any["m"], "I1": of_any["I1"], "I3": of_any["I3"], **numbers}
    fields["g"] = Spheroid.parameters["g"]
    ordered = sorted(fields.items(), key=lambda item: item[1].default is not None)
    lengths = [rule.unit.powers[METRE.powers.index(1)] for rule in numbers.values()]
    values = shape._make(np.float64(allowed(rule)) for rule in numbers.values())
    with np.errstate(all="ignore"):
        answer(
            "`height` must return arithmetic of z, s2 and its numbers, + - * /, whole powers and "
            "tippetop.extending.root",
            lambda: at(0.5, 0.75, values.height),
            lambda found: isinstance(found, Series),
        )

    def faults(parameters: Mapping[str, float]) -> list[str]:
        """Return sentences on parameters of which there is no such body."""
        own = shape._make(parameters[name] for name in numbers)
        return inertia_faults(parameters) + outline_faults(own, lengths)

    name = checked_name(height.__name__.replace("_", "-"), "system")
    return RecordType(
        "".join(word.capitalize() for word in name.split("-")),
        (Outlined,),
        {
            **dict(ordered),
            "__module__": height.__module__,
            "__doc__": height.__doc__,
            "gliding": name,
            "resting": f"rolling-{name}",
            "shape": shape,
            "faults": staticmethod(faults),
        },
    )
