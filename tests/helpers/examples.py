"""Problems for tests: named bodies, reference cases, and a short way to run them."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tippetop.engine.observables import Observables
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import Frictionless, Viscous
from tippetop.mechanics.systems import SYSTEMS
from tippetop.problem import Problem
from tippetop.runs.run import Solution, solve


CANONICAL = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 131 / 350 * 8e-6, "I3": 3.2e-6, "g": 9.82}
"""S. Rauch-Wojciechowski and N. Rutstam, Regul. Chaotic Dyn. 18 (2013)."""
LATE = {
    "theta": 0.1930406939565264,
    "phi_dot": 213.19654689741958,
    "omega3": 147.31406907076985,
    "nu_x": -0.036966204229469724,
    "nu_y": 0.16341042960004895,
}
"""The canonical inversion at its 233rd turning, 4.354 s; two turnings later both curvatures of a
turning cross, p = 2."""
HEAVY = {"m": 0.1, "l": 0.04, "I1": 8e-5, "I3": 5e-5, "g": 9.82}
"""A heavy top; its moment about the tip is 2.4e-4 kg m^2."""
GLIDING = Touch(0.02, 0.02, 0.006, 131 / 350 * 8e-6, 3.2e-6, 9.82, Viscous(0.3))
"""CANONICAL as a ball that glides."""
OUTLINES = {"a": 0.03, "b": 0.02, "c": 1e-3, "ring": 0.02, "tube": 2e-3}
OUTLINES |= dict.fromkeys(("delta", "x", "y", "h"), 1e-4) | {"I2": 3.1e-6}
"""Outlines of other bodies, of CANONICAL's size."""
PRESETS = {
    "tippe-top": "inverting",
    "rolling-tippe-top": "rolling",
    "gliding-heavy-top": "gliding-heavy-top",
    "heavy-top": "heavy-top",
    "gliding-cylinder": "gliding-cylinder",
    "rolling-cylinder": "rolling-cylinder",
    "spheroid": "spinning-egg",
    "rolling-spheroid": "rolling-egg",
    "disc": "spinning-coin",
    "rolling-disc": "rolling-coin",
    "ellipsoid": "off-axis-top",
    "rolling-ellipsoid": "rattleback",
}
"""A preset of each system."""


def numbers_of(system: str) -> dict[str, float]:
    """Return usual parameters of a system."""
    numbers = HEAVY if "heavy" in system else {**CANONICAL, "I": 4e-6, **OUTLINES}
    return {name: numbers[name] for name in SYSTEMS[system].parameters}


def problem(
    system: str,
    parameters: dict[str, float],
    initial: dict[str, float],
    until: float,
    friction: tuple[str, dict[str, float]] = ("none", {}),
    **options: Any,
) -> Problem:
    """A problem without validation."""
    used = SYSTEMS[system]
    law = used.laws.get(friction[0])
    record = law._make(friction[1][name] for name in law._fields) if law else Frictionless()
    form = used.forms[options.pop("form", next(iter(used.forms)))]
    options = {
        "times": np.linspace(0, until, 101),
        "events": tuple(e.name for e in used.events),
        **options,
    }
    given = {"parameters": parameters, "friction": record, "initial": initial, "until": until}
    return Problem(system=used, form=form, **given, **options)


def run(*arguments: Any, **options: Any) -> Solution:
    """The run of `problem(...)`."""
    return solve(problem(*arguments, **options))


def with_gamma(gamma: float) -> Touch:
    """GLIDING with another I1/I3."""
    return GLIDING._replace(I1=gamma * GLIDING.I3)


def columns(made: Solution) -> dict[str, np.ndarray]:
    """The columns of a run, by name."""
    return {name: column.values for name, column in made.columns().items()}


def si(made: Problem) -> Any:
    """The body in SI units, floats."""
    return made.body(float)


def at_start(made: Problem) -> dict[str, float]:
    """Quantities at t = 0, in SI units."""
    view = Observables(made)
    values = view.evaluate(made.start()[None, :])
    return {
        q.name: float(values[q.name][0]) * float(made.scales.of(q.unit))
        for q in made.system.quantities
    }


class Case(NamedTuple):
    """A multi-precision trajectory and the problem that it solves."""

    problem: Problem
    times: np.ndarray
    values: dict[str, np.ndarray]
    turnings: np.ndarray
    turning_angles: np.ndarray
    crossings: list[tuple[str, float]]


ANGLES = {"thetadot": "theta_dot", "phidot": "phi_dot"}
"""Names of the references, and ours."""
COLUMNS = {
    "theta": "theta",
    "lambda": "jellett",
    "D": "routh",
    "E": "energy",
    "Etilde": "modified_energy",
    "g_n": "normal_force",
    "L3": "L3",
    "LAz": "Lz",
    "omega3": "omega3",
}


def stored_reference(name: str) -> dict[str, Any]:
    """Return the document of a reference."""
    return json.loads((Path(__file__).parents[1] / "reference" / f"{name}.json").read_text())


def reference(name: str, system: str, form: str, precision: str = "double") -> Case:
    """A reference case as a problem of a system in a form."""
    stored = stored_reference(name)
    given = {k: float(v) for k, v in stored["parameters"].items()}
    given["I"] = given["I1"]
    initial = {ANGLES.get(k, k): float(Fraction(v)) for k, v in stored["initial_exact"].items()}
    used = SYSTEMS[system]
    times = np.array(stored["t"], dtype=float)
    made = problem(
        system,
        {k: given[k] for k in used.parameters},
        {k: v for k, v in initial.items() if k in used.initial},
        times[-1],
        ("viscous", {"mu": given["mu"]}),
        form=form,
        times=times,
        precision=precision,
    )
    values = {
        mine: np.array(stored[his], dtype=float) for his, mine in COLUMNS.items() if his in stored
    }
    if "theta_unwrapped" in stored:
        values["theta"] = np.array(stored["theta_unwrapped"], dtype=float)
    values["horizontal_force"] = np.hypot(
        np.array(stored["Fx"], float), np.array(stored["Fy"], float)
    )
    values["x"] = np.array(stored["r"], dtype=float)[:, 0]
    values["axis"] = np.array(stored["u"], dtype=float)
    turnings = [
        (float(p["t"]), float(p["theta"]))
        for p in stored["turning_points"]
        if 0 < float(p["t"]) <= times[-1]
    ]
    t, theta = np.array(turnings).T if turnings else (np.zeros(0), np.zeros(0))
    crossings = [(c["level"], float(c["t"])) for c in stored["crossings"]]
    return Case(made, times, values, t, theta, crossings)


def turned(quaternions: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Turn attitudes about the vertical."""
    c, s = np.cos(angles / 2), np.sin(angles / 2)
    w, x, y, z = quaternions.T
    return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=1)
