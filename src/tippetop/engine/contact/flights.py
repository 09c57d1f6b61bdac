"""When the flight of a body ends, in the numbers of its run: compiled for doubles."""

from functools import partial
from typing import Any

import numpy as np

from tippetop_kernels.compilation import entry

from ...mechanics.contact.body import Touch
from ...mechanics.contact.flight import hop
from ...mechanics.contact.landing import landing_within
from ...mechanics.operand import Vector


ROUNDING = {np.float64: 2.0**-52, np.longdouble: float(np.finfo(np.longdouble).eps)}
"""Of doubles, and of numbers of 80 bits; of quadruple 2^-112."""


@entry
def land(numbers, zeros):
    """Puts in place of the first number when a ball lands: its place and motion, and what it is, of `landing`."""
    u, L = Vector(numbers[1], numbers[2], numbers[3]), Vector(numbers[4], numbers[5], numbers[6])
    b = Touch(numbers[9], numbers[10], numbers[11], numbers[12], numbers[13], numbers[14], (), (), ())
    numbers[0] = landing_within(hop(u, L, numbers[7], numbers[8], b, zeros), 2.0**-52)


class Landings:
    """When balls land.

    Parameters
    ----------
    number
        The type of numbers of the run.
    """

    def __init__(self, number: Any):
        self.rounding = ROUNDING.get(number, 2.0**-112)
        self.compiled = number is np.float64
        self.numbers = np.zeros(15)
        self.land = partial(land, self.numbers)

    def of(self, u: Vector, L: Vector, V_z: Any, gap: Any, b: Touch, zeros: int) -> Any:
        """The time from now to the landing of a ball, as `flight.hop` takes it."""
        if not self.compiled:
            return landing_within(hop(u, L, V_z, gap, b, zeros), self.rounding)
        self.numbers[1:] = (*u, *L, V_z, gap, *b[:6])
        self.land(zeros)
        return float(self.numbers[0])
