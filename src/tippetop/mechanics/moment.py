"""The state that formulas of events and columns read, in any form: scalars, place and axis.

q, carried and the body b go in, as formulas take them; a `Moment` comes out, whose attributes
formulas of the user read.
"""

from typing import TYPE_CHECKING, Any

from .operand import atan2, cos, sin, sqrt


if TYPE_CHECKING:
    from .system import Form


PLACE = ("phi", "x", "y", "ux", "uy", "uz")
"""Variables of a form that formulas read too."""


class Moment(tuple):
    """A state for formulas: its scalars, with an attribute for each of them.

    phi, x, y, ux, uy and uz are attributes too, if the form has them.

    Parameters
    ----------
    known
        Scalars and variables by name.
    """

    def __new__(cls, known: dict[str, Any]) -> "Moment":
        self = super().__new__(cls, known.values())
        vars(self).update(known)
        return self

    def __getattr__(self, name: str) -> Any:
        """Compute phi of 3hat, or 3hat of phi, where a formula reads one."""
        known = vars(self)
        if name == "phi" and "uy" in known:
            return atan2(self.uy, self.ux)
        if name == "uz" and "phi" in known:
            return self.z
        if name in ("ux", "uy") and "phi" in known:
            return sqrt(self.s2) * (cos if name == "ux" else sin)(self.phi)
        raise AttributeError(f"a state of this form has no `{name}`; it has {', '.join(known)}")


def moment(form: "Form", q: Any, carried: Any, b: Any) -> Moment:
    """Return the moment of a state: of numbers, arrays or expressions.

    Parameters
    ----------
    form
        The form of the state.
    q, carried, b
        The state, its integrals and the body.

    Returns
    -------
    Moment
        phi is atan2(uy, ux) where the form does not integrate it, and then undefined at a pole.
    """
    values = {**q._asdict(), **carried._asdict()}
    place = {name: values[name] for name in PLACE if name in values}
    return Moment(place | form.scalars(q, b)._asdict())
