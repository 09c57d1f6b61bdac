"""Which form `form = "auto"` takes."""

from typing import NamedTuple

from ..mechanics.form import Form
from ..mechanics.system import System


AUTO = "auto"


class Choice(NamedTuple):
    """A form and why it is taken."""

    form: Form
    because: str  # the end of a sentence


def choice(system: System) -> Choice:
    """The first form of a system: of those that are regular everywhere and keep every column exact,
    the cheapest.

    Parameters
    ----------
    system
        A system.

    Returns
    -------
    Choice
        The same for every start, so many tops share it, and nothing has to take over in mid-run.

    Notes
    -----
    The motion alone is a tenth cheaper in the reduced form of a rolling top. But phi' has poles
    where z = cos(theta) is 1 or -1, nearer in complex time than those of z, which controls the
    step: after 4 s phi is wrong by 2e-12 where theta stays above 0.51 rad, and by 1.5e-8 above 0.15
    rad; about the contact by 1e-14.
    """
    form, *others = system.forms.values()
    regular = "it is regular everywhere, and the cheapest such form of this system"
    return Choice(form, regular if others else "the system has no other")
