"""What theory says of a start: thresholds, regime, fate."""

import math
from typing import Any

import numpy as np

from ..mechanics.contact.body import Body
from ..mechanics.system import System
from ..mechanics.theory.modes import linear_modes
from ..mechanics.theory.regimes import Regime, regime
from ..mechanics.theory.thresholds import Threshold, sleeping_spin, thresholds
from ..mechanics.units import RADIAN_PER_SECOND


def assessment(system: System, b: Body, initial: dict[str, Any]) -> dict[str, Any]:
    """What `check` says of a start: thresholds, the regime in a sentence, the predicted fate. Empty lists if nothing is
    known of the system. `initial` is the person's data, SI."""
    start = _start(system, b, initial)
    if system.name in ("tippe-top", "rolling-tippe-top"):
        lam = start["jellett"]
        found = thresholds(b)
        if system.name == "rolling-tippe-top":
            kept = {name: found[name] for name in ("gamma",)}
            sentence = "pure rolling conserves E, D and lambda: theta nutates for ever"
            return {"thresholds": kept, "regime": sentence, "fate": "nutation between two angles", "lambda": lam}
        now = regime(lam, b)
        return {"thresholds": found, "regime": now.sentence(), "fate": _fate(now, system, b), "lambda": lam}
    if system.name in ("heavy-top", "gliding-heavy-top"):
        sleeping, spin = sleeping_spin(b), abs(start["L3"]) / b.I3
        limits = {"spin_sleeping": Threshold(sleeping, RADIAN_PER_SECOND, "upright spin of a fixed tip stable above")}
        return {"thresholds": limits, **_heavy(system, b, start, spin > sleeping)}
    return {"thresholds": {}, "regime": _planar(system, b), "fate": ""}


def _fate(now: Regime, system: System, b: Body) -> str:
    if type(b.friction).__name__ == "Frictionless":
        return "no friction: no inversion, theta nutates for ever"
    if len(now.attractors) == 1:
        return f"ends in {now.attractors[0]}"
    return "depends on the start: " + ", or ".join(now.attractors)


def _heavy(system: System, b: Body, start: dict[str, float], fast: bool) -> dict[str, str]:
    if system.name == "heavy-top":
        from ..mechanics.theory.heavy_top_motion import heavy_top_motion

        inertia, weight = b.I1 + b.m * b.c**2, -(b.m * b.g * b.c)
        name = heavy_top_motion(start["energy"], start["Lz"], start["L3"], inertia, b.I3, weight)
        upright = "stable" if fast else "unstable"
        return {"regime": f"the sleeping top of this spin is {upright}", "fate": name}
    growth = float(linear_modes(start["L3"] / b.I3, b)[0].real)
    if type(b.friction).__name__ == "Frictionless":
        return {"regime": f"without friction the upright spin is {'un' if growth > 1e-6 else ''}stable", "fate": ""}
    how = "spirals out slowly" if fast else "topples"
    rate = f"upright spin unstable at every speed (growth rate {growth:.3g} per second): the top {how}"
    return {"regime": rate, "fate": "falls to the plane in the end, unless it lifts off"}


def _planar(system: System, b: Body) -> str:
    if b.c == 0:
        return "a round cylinder: gliding decays exponentially to rolling"
    omega = math.sqrt(b.m * b.g * b.c / (b.I1 + b.m * (b.R - b.c) ** 2))
    return f"small oscillations in rolling have angular frequency {omega:.6g} rad/s"


def _start(system: System, b: Body, initial: dict[str, Any]) -> dict[str, float]:
    """The quantities of a start, SI."""
    theta = np.array([float(initial.get("theta", 0.0))])
    s, z = np.sin(theta), np.cos(theta)
    form = next(iter(system.forms.values()))
    state = form.of_angles(system.start(initial, s, z, b), s, z, b)
    scalars = form.scalars(state, b)
    return {q.name: float(np.asarray(q.formula(scalars, b)).flat[0]) for q in system.quantities}
