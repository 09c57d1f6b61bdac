"""Which form `form = "auto"` takes: the cheapest that is regular wherever the motion goes, known before it begins."""

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from ..mechanics.form import Form
from ..mechanics.theory.poles import closest_approach


if TYPE_CHECKING:
    from .one import Problem


AUTO = "auto"
CLEARANCE = 0.1  # [rad] from the poles, above which the form `away_from_poles` of a system is as accurate as its first


class Choice(NamedTuple):
    """A form and why it is taken."""

    form: Form
    because: str  # the end of a sentence


def regular_form(problem: "Problem") -> Form:
    """The first form of the system: regular wherever a motion may go, so for many tops too."""
    return next(iter(problem.system.forms.values()))


def choice(problem: "Problem") -> Choice:
    """The cheapest form that is regular on the whole way of a run.

    Parameters
    ----------
    problem
        A run whose start is free of faults, in any form.

    Returns
    -------
    Choice

    Notes
    -----
    A form that is singular at the poles is taken where nothing dissipates and E~ and the momenta of V are constant:
    the motion then stays for ever where V <= E~ around its start, so that its closest approach to a pole is exact, and
    no other form needs to take over on the way. What the rounding of a run moves, 1e-12 of E~ at most, moves that by
    less than the clearance. Friction may carry a gliding top to either pole: it keeps the first form.
    """
    regular, system = regular_form(problem), problem.system
    if len(system.forms) == 1:
        return Choice(regular, "the system has no other")
    if not system.away_from_poles:
        return Choice(regular, "it is regular everywhere, and the cheapest of this system")
    tops = replace(problem, form=regular).alone  # whatever the form: the same run has the same choice, to the bit
    scalars = regular.scalars(tops.record(tops.start), tops.internal_body)
    distances = closest_approach(system, scalars, tops.internal_body)
    near = {"0": float(distances.upright[0]), "pi": float(distances.inverted[0])}
    pole = min(near, key=lambda name: near[name])
    if near[pole] >= CLEARANCE:
        cheap = system.forms[system.away_from_poles]
        return Choice(cheap, f"what is conserved keeps theta at least {near[pole]:.3g} rad from the poles 0 and pi")
    return Choice(regular, f"it is regular at the poles, and theta comes {_to(near[pole])} {pole}")


def _to(distance: float) -> str:
    return f"within {distance:.3g} rad of" if distance else "to"
