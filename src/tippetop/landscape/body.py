"""The body whose potential is evaluated, the compiled kernels, and how results are labelled."""

import decimal
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.contact import body as contact
from ..mechanics.friction import Frictionless
from ..mechanics.operand import refill
from ..mechanics.systems import spinning, tippe_top
from . import formulas
from .formulas import SHAPES


NAMES = {
    "D": ("kg m2 s-1", "Routh's function D"),
    "lambda": ("kg m3 s-1", "Jellett's integral lambda"),
    "L3": ("kg m2 s-1", "angular momentum L_3 about the axis"),
    "Lz": ("kg m2 s-1", "angular momentum L_z about the vertical, at the tip"),
    "z": ("1", "z = cos(theta)"),
    "theta": ("rad", "inclination theta of the axis"),
    "V": ("J", "effective potential V"),
    "F": ("J", "minimal surface F, infimum of V over z"),
    "time": ("s", "time"),
}


@dataclass(frozen=True)
class Top:
    """A body as the kernels take it."""

    system: str
    parameters: dict[str, float]
    relief: formulas.Relief
    body: contact.Body
    upright: int
    several: bool  # V can have two minima

    @property
    def momenta(self) -> tuple[str, str]:
        """The names of the two momenta."""
        return SHAPES[self.system].momenta


def top(parameters: Mapping[str, float], system: str = "tippe-top") -> Top:
    """The body of `system` with `parameters` in SI; its constants are taken with 50 digits, then rounded once.

    Raises ValueError for an unknown system, a missing parameter, or one that is not a finite number.
    """
    if system not in SHAPES:
        raise ValueError(f"Argument `system` must be one of {', '.join(SHAPES)}, but is {system!r}.")
    shape, given = SHAPES[system], {}
    for name, value in parameters.items():
        given[name] = float(value)
        if not np.isfinite(given[name]):
            raise ValueError(f"Argument `parameters.{name}` must be finite, but is {value}.")
    with decimal.localcontext(prec=50):
        try:
            body = shape.body({name: decimal.Decimal(x) for name, x in given.items()}, Frictionless())
        except KeyError as missing:
            raise ValueError(f"Argument `parameters` must have {missing}, but has {', '.join(given)}.") from None
        for name in ("m", "I1", "I3", "g", "l"):
            if not given.get(name, 1.0) > 0:
                raise ValueError(f"Argument `parameters.{name}` must be positive, but is {given[name]}.")
        if shape.upright == 1 and not (0 < given["alpha"] < 1 and given["R"] > 0):
            raise ValueError(
                "Argument `parameters` must have R > 0 and alpha in (0, 1), "
                f"but has R = {given['R']}, alpha = {given['alpha']}."
            )
        relief = formulas.rounded(shape.relief(body))
        several = shape.upright == 1 and spinning.two_minima(body) < 0
    return Top(system, given, relief, refill(body, (float(x) for x in body[:-1])), shape.upright, several)


class Kernels(NamedTuple):
    """The kernels and the formulas that they are given, compiled at first use."""

    minima: Any
    heights: Any
    gradients: Any
    potentials: Any
    turnings: Any
    periods: Any
    problem: tuple  # prepare, guess, slopes, value, ends
    formulas: dict[str, Any]


@cache
def kernels() -> Kernels:
    """The kernels of this house; numba is imported here, and only here."""
    from tippetop_kernels import grid
    from tippetop_kernels.jit import inlined, kernel
    from tippetop_kernels.staging import in_stages

    inner = {
        name: inlined(getattr(formulas, name)) for name in ("lean", "guess", "slopes", "value", "ends", "gradient")
    }
    for name, stages in formulas.STAGES.items():
        in_stages(inner[name], *(inlined(stage) for stage in stages))
    # not inlined where it is called from many places: a third of the compilation
    inner |= {name: kernel(getattr(formulas, name)) for name in ("bend", "excess")}
    inner["inertia"] = inlined(tippe_top.theta_inertia)
    return Kernels(
        grid.minima,
        grid.heights,
        grid.gradients,
        grid.potentials,
        grid.turnings,
        grid.periods,
        tuple(inner[name] for name in ("lean", "guess", "slopes", "value", "ends")),
        inner,
    )


# --- what comes in --------------------------------------------------------------------------------------------------


def axis(name: str, values: Any) -> np.ndarray:
    """A grid axis: one-dimensional, not empty, ascending; NaN and infinities are let through, as points without answer.

    Raises ValueError with one sentence.
    """
    x = np.atleast_1d(np.asarray(values, dtype=float))
    if x.ndim != 1 or x.size == 0:
        raise ValueError(f"Argument `{name}` must be a number or a one-dimensional array, but has shape {x.shape}.")
    known = x[np.isfinite(x)]
    if np.any(np.diff(known) <= 0):
        raise ValueError(f"Argument `{name}` must ascend, but does not.")
    return x


def attributes(t: Top, **more: Any) -> dict[str, Any]:
    """What a Dataset says of itself."""
    return {"system": t.system, **{f"parameter_{k}": v for k, v in t.parameters.items()}, **more}


def labelled(name: str, dims: Any, values: Any, units: str | None = None, long_name: str | None = None) -> tuple:
    """A variable with its unit and meaning."""
    known = NAMES.get(name, ("1", name))
    return dims, values, {"units": units or known[0], "long_name": long_name or known[1]}


def flags(kind: Any, long_name: str) -> dict[str, Any]:
    """The CF attributes of an enumeration."""
    return {
        "long_name": long_name,
        "flag_values": np.array([int(k) for k in kind], dtype=np.int8),
        "flag_meanings": " ".join(k.name.lower() for k in kind),
    }


def cosine(q: np.ndarray, upright: int) -> np.ndarray:
    """z = cos(theta) of q; an end of the range of q is the pole itself."""
    return upright * ((1 - q) / (1 + q))


def inclination(q: np.ndarray, upright: int) -> np.ndarray:
    """Theta of q [rad], with all digits near theta = 0 too."""
    return 2 * np.arctan(np.sqrt(q) if upright == 1 else 1 / np.sqrt(q))
