"""On which side of their zeros the event functions of a phase begin."""

from collections.abc import Callable

from ...mechanics.contact.phases.drilling import RESTS
from ...mechanics.events import ON_ZERO
from ..tallies import ON_ZERO as BEGINS_ON_ZERO
from ..tallies import SIGN
from .legs import Followed
from .transitions import BACK, WITHIN, Change


def expect(phase: Followed, change: Change, functions: Callable[[], dict[str, float]]) -> None:
    """Tells the observer of a phase that begins on which side of its zeros each event function is.

    Parameters
    ----------
    phase
        What begins.
    change
        How it begins.
    functions
        Gives the event functions there, by name; asked only where they are not known.
    """
    signs, at, on_zero = change.signs, [], []
    known = change.functions
    if known is None:
        new = any(name not in signs for name in phase.names)
        known = functions() if new else {}
    for name, event in zip(phase.names, phase.events, strict=True):
        if name in signs:  # it continues from the phase before
            sign, zero = signs[name], False
        else:
            value = known[name]
            sign, zero = 1.0 if value > 0 else -1.0, abs(value) < ON_ZERO
            if name in ("stick", "slip"):
                sign, zero = sign if event.direction == 0 else 1.0, False
            elif name in BACK:  # by the region that was chosen: as small as U, they are not zero
                sign, zero = -float(event.direction), name == change.passed
            elif name == RESTS.name or name in WITHIN:  # as small as U too
                sign, zero = (-1.0, True) if name == change.passed else (sign, False)
            elif name == "touch" and zero:
                sign = 1.0
        at.append(sign)
        on_zero.append(zero)
    tallies = phase.driver.tallies
    for array, fresh in zip(tallies, phase.fresh, strict=True):
        array[...] = fresh
    tallies.functions[SIGN, :, 0], tallies.functions[BEGINS_ON_ZERO, :, 0] = at, on_zero
