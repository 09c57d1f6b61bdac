"""The state that formulas of events and columns read, in any form: scalars, place and axis."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from .operand import atan2, cos, sin, sqrt


if TYPE_CHECKING:
    from .system import Form, System


AXIS = ("ux", "uy", "uz")


class Moment(tuple):
    """A state for formulas: its scalars, with an attribute for each of them.

    phi, x, y, ux, uy and uz are attributes too, if the form has them.

    Parameters
    ----------
    scalars
        The record of the scalars.
    place
        Returns functions that compute the others, by name; called where a formula reads one.
    """

    _scalars: Any
    _place: Callable[[], Mapping[str, Callable[[], Any]]]

    def __new__(cls, scalars: Any, place: Callable[[], Mapping[str, Callable]]) -> "Moment":
        self = super().__new__(cls, scalars)
        self._scalars, self._place = scalars, place
        vars(self).update(zip(getattr(scalars, "_fields", ()), scalars, strict=False))
        return self

    def __getattr__(self, name: str) -> Any:
        if hasattr(self._scalars, name):
            return getattr(self._scalars, name)
        place = self._place()
        if name in place:
            return place[name]()
        known = ", ".join([*getattr(self._scalars, "_fields", ()), *place])
        raise AttributeError(f"a state of this form has no `{name}`; it has {known}")


def moment(system: "System", form: "Form", q: Any, carried: Any, b: Any) -> Moment:
    """Return the moment of a state: of numbers, arrays or expressions.

    Parameters
    ----------
    system, form
        The system, and the form of its state.
    q, carried, b
        The state, its integrals and the body.

    Returns
    -------
    Moment
        phi is atan2(uy, ux) where the form does not integrate it, and then undefined at a pole.
    """
    scalars = form.scalars(q, b)
    return Moment(scalars, partial(_place, system, scalars, q, carried))


def _place(system: "System", scalars: Any, q: Any, carried: Any) -> dict[str, Callable[[], Any]]:
    """Return the functions of PLACE that a state has."""
    values = {**q._asdict(), **carried._asdict()}
    axis = system.vectors.get("axis", AXIS)
    sources = {"phi": "phi", "x": "x", "y": "y", **dict(zip(AXIS, axis, strict=True))}
    place: dict[str, Callable[[], Any]] = {
        name: partial(values.__getitem__, source)
        for name, source in sources.items()
        if source in values
    }
    if all(name in values for name in axis):
        place.setdefault("phi", lambda: atan2(values[axis[1]], values[axis[0]]))
    elif "phi" in values:
        place |= {
            "ux": lambda: sqrt(scalars.s2) * cos(values["phi"]),
            "uy": lambda: sqrt(scalars.s2) * sin(values["phi"]),
            "uz": lambda: scalars.z,
        }
    return place
