"""Zeros of event functions, as the integrator finds them."""

from typing import Any, NamedTuple


class Zero(NamedTuple):
    """A zero of an event function: internal time, kind, and the sign of the crossing."""

    time: Any
    kind: str
    sign: int
