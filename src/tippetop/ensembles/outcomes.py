"""What is kept of each top of an ensemble: status, class, times, angles, forces, drift."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..columns import Column, flag_attributes
from ..mechanics.units import NEWTON, ONE, RADIAN, SECOND, Unit
from ..scenario import build
from .tops import Tops, known


if TYPE_CHECKING:
    import xarray as xr


STATUSES = ("todo", "finished", "liftoff", "fallen", "settled", "non-finite", "stalled", "invalid")
CLASSES = ("none", "upright", "tumbling", "inverted", "lifted-off", "under-way")
NEAR = 0.1  # rad from a pole: upright or inverted

TIMES = {
    "first_equator": "first passage of theta = pi/2; NaN: none",
    "last_equator": "last passage of theta = pi/2; NaN: none",
    "inverted_at": "theta first rises through pi - 0.1; NaN: never",
    "lifted_at": "the normal force first falls to zero; NaN: never",
    "settled_at": "sliding last died out; NaN: never",
}
COLUMNS: dict[str, tuple[Any, Unit, str]] = {
    "t_end": (np.float64, SECOND, "end of the run"),
    "theta_end": (np.float64, RADIAN, "inclination at the end"),
    **{name: (np.float64, SECOND, text) for name, text in TIMES.items()},
    "equators": (np.int32, ONE, "passages of theta = pi/2"),
    "turnings": (np.int32, ONE, "turning angles that are more than rounding"),
    "theta_min": (np.float64, RADIAN, "lowest turning angle"),
    "theta_max": (np.float64, RADIAN, "highest turning angle"),
    "normal_force_min": (np.float64, NEWTON, "least normal force"),
    "normal_force_max": (np.float64, NEWTON, "greatest normal force"),
    "steps": (np.int32, ONE, "steps of the integrator"),
}


class Measured:
    """A line per top, as arrays; and what the making took."""

    def __init__(self, tops: Tops):
        self.tops, n = tops, tops.n
        self.status = np.zeros(n, np.int8)
        self.kind = np.zeros(n, np.int8)
        self.columns = {
            name: np.full(n, np.nan) if dtype is np.float64 else np.zeros(n, dtype)
            for name, (dtype, _, _) in COLUMNS.items()
        }
        self.final = np.full((len(tops.start), n), np.nan)
        self.settled = np.zeros(n, bool)
        self.drift: dict[str, np.ndarray] = {}
        self.steps_made = self.steps_possible = 0
        self.seconds = self.processor = 0.0  # by the wall clock, and by the clocks of the threads

    @property
    def occupancy(self) -> float:
        """Steps that tops made, over the steps that the lanes could have made."""
        return self.steps_made / max(1, self.steps_possible)


def _conclude(measured: Measured) -> None:
    """What follows from the ends: SI units, theta at the end, the class."""
    tops, columns = measured.tops, measured.columns
    for name, (_, unit, _) in COLUMNS.items():
        if unit in (SECOND, NEWTON):
            columns[name] *= tops.unit(unit)
    for name in ("normal_force_min", "normal_force_max"):
        columns[name][~np.isfinite(columns[name])] = np.nan
    ended = np.isfinite(measured.final).all(axis=0)
    theta = columns["theta_end"]
    theta[ended] = tops.values(measured.final[:, ended], np.flatnonzero(ended))["theta"]
    kind = np.full(tops.n, CLASSES.index("under-way"))
    ends = {"tumbling": measured.settled, "upright": theta < NEAR, "inverted": theta > np.pi - NEAR}
    for name in tops.base.system.classes:
        kind[ends[name]] = CLASSES.index(name)
    kind[np.isfinite(columns["lifted_at"])] = CLASSES.index("lifted-off")
    sound = np.isin(measured.status, [STATUSES.index(s) for s in ("finished", "liftoff", "fallen", "settled")])
    measured.kind[:] = np.where(sound, kind, CLASSES.index("none"))


def dataset(measured: Measured, faults: list[tuple[int, str]]) -> "xr.Dataset":
    """The lines as a labelled Dataset, dimension `top`."""
    import xarray as xr

    found, tops = table(measured), measured.tops
    rules = known(tops.base)
    coords = {
        key: ("top", column, {"units": rules[key].unit.symbol, "long_name": rules[key].long_name})
        for key, column in tops.columns.items()
    }
    attrs = {
        "title": tops.base.system.title,
        **build.resolved(tops.base),
        "occupancy": measured.occupancy,
        "seconds": measured.seconds,
        "processor_seconds": measured.processor,
        "faults": [f"top {i}: {sentence}" for i, sentence in faults[:20]],
    }
    return xr.Dataset(found, coords, attrs)


def table(measured: Measured) -> dict[str, Column]:
    """The lines as columns along `top`, by name."""
    found: dict[str, Column] = {
        "status": Column(("top",), measured.status, flag_attributes(STATUSES, "how the run ended")),
        "class": Column(("top",), measured.kind, flag_attributes(CLASSES, "what became of the top")),
    }
    for name, (_, unit, text) in COLUMNS.items():
        found[name] = Column(("top",), measured.columns[name], {"units": unit.symbol, "long_name": text})
    for name, worst in measured.drift.items():
        found[f"drift_{name}"] = Column(("top",), worst, {"units": "1", "long_name": f"worst relative drift: {name}"})
    return found
