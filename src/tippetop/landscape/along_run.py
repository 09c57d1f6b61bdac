"""A run seen in its landscape: what the figures of the band, the surface, the potential and the
inversion show.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..columns import flagged, on_sphere
from ..errors import InputError, a_system
from ..mechanics.friction import PARTS, Frictionless
from ..mechanics.system import Landscape
from ..mechanics.systems import SYSTEMS, find
from ..mechanics.theory import thresholds, tumbling
from .marked_lines import marked_lines
from .potential import potential as potential_over
from .surface import minimal_surface
from .turning import band as band_along
from .turning import turning_angles


TIMES = 6  # panels of the potential
KEPT = 1e-9  # relative change of what stays as it is
SPINNING = ("D", "lambda")  # the momenta over which spinning states are lines


def table(columns: Any) -> xr.Dataset:
    """Columns of a run as a labelled Dataset; a Dataset as it is."""
    if isinstance(columns, xr.Dataset):
        return columns
    return xr.Dataset(
        {name: (c.dims, c.values, c.attrs) for name, c in columns.items()}
    ).set_coords("time")


def band(
    trajectory: xr.Dataset, events: xr.Dataset, attrs: dict[str, Any]
) -> tuple[xr.Dataset, xr.Dataset, str]:
    """The band along a run, and the logged turning angles with the nearer edge of the band at their
    times: where the band rises fast, theta can turn at its upper edge only.

    D and E~ at a turning are a cubic through the neighbouring output times: at 40 outputs a
    nutation, that leaves the edge some 1e-6 rad uncertain.
    """
    from scipy.interpolate import CubicSpline

    parameters, system, landscape = _body(attrs)
    angles = band_along(parameters, trajectory, system)
    turning = flagged(events["kind"], "turning") & events["significant"].values.astype(bool)
    when, theta = events["time"].values[turning], events["theta"].values[turning]
    if trajectory["time"].size < 4:
        when, theta, turning = when[:0], theta[:0], np.zeros_like(turning)
        states: list[Any] = [np.empty(0)] * 3
    else:
        states = [
            CubicSpline(trajectory["time"].values, trajectory[name].values)(when)
            for name in landscape.columns
        ]
    edges = turning_angles(parameters, states[0], states[1], states[2], system, theta=theta)
    low, high = edges["theta_min"].values, edges["theta_max"].values
    edge = np.where(np.abs(theta - low) < np.abs(theta - high), low, high)
    logged = xr.Dataset({"theta": ("time", theta), "edge": ("time", edge)}, {"time": when})
    return angles, logged, f"{heading(attrs)}: the band that the main equation predicts"


def surface(trajectory: xr.Dataset, events: xr.Dataset, attrs: dict[str, Any]) -> tuple[Any, ...]:
    """The minimal surface around a run, the marked lines, the run while it is on its sphere, and
    its title.
    """
    parameters, *_ = _lasting(attrs)
    lam = float(trajectory["jellett"][0])
    lambdas = (
        np.linspace(0, 1.25 * lam, 201)
        if lam > 0
        else np.linspace(1.25 * lam, 0, 201)
        if lam < 0
        else None
    )
    if lambdas is None:
        raise InputError(
            ["the surface is drawn around a run with lambda other than 0, but it is 0."]
        )
    lines, seen = marked_lines(parameters, lambdas), _on_sphere(trajectory)
    ends = [*lines["D"].values.ravel(), *seen["routh"].values]
    grid = minimal_surface(parameters, np.linspace(np.nanmin(ends), np.nanmax(ends), 201), lambdas)
    return grid, lines, seen, heading(attrs)


def potential(trajectory: xr.Dataset, events: xr.Dataset, attrs: dict[str, Any]) -> tuple[Any, ...]:
    """V(z), E~ and the turning angles at several times, and a title: evenly spread in theta, hence
    all through an inversion; at one time, where D, lambda and E~ stay as they are.
    """
    parameters, system, landscape = _body(attrs)
    trajectory = trajectory.isel(time=on_sphere(trajectory))
    theta = trajectory["theta"].values
    if not theta.size:
        raise InputError(
            [
                "the potential is that of a top on its sphere, and this one is on its stem or "
                "in the air."
            ]
        )
    risen = -theta if parameters.get("alpha", 0) < 0 else theta
    reached = np.maximum.accumulate(risen)
    picks = np.unique(np.searchsorted(reached, np.linspace(risen[0], reached[-1], TIMES)))
    if picks.size < TIMES:  # the top does not rise: evenly spread in time
        picks = np.unique(np.linspace(0, theta.size - 1, TIMES).round().astype(int))
    kept = all(
        np.ptp(v) <= KEPT * np.abs(v).max()
        for v in (trajectory[name].values for name in landscape.columns)
    )
    z = np.cos(np.linspace(np.pi, 0, 4003)[1:-1])
    curves = []
    for i in picks[:1] if kept else picks:
        x, y, E = (float(trajectory[name][i]) for name in landscape.columns)
        at = turning_angles(parameters, x, y, E, system, theta=float(theta[i])).assign(energy=E)
        words = "at all times" if kept else f"t = {float(trajectory['time'][i]):.4g} s"
        curves.append((words, potential_over(parameters, z, x, y, system), at))
    return curves, f"{heading(attrs)}: effective potential V(z)"


def inversion(trajectory: xr.Dataset, events: xr.Dataset, attrs: dict[str, Any]) -> tuple[Any, ...]:
    """The section of the surface at the run's lambda, the spinning states there, and the run.

    Raises InputError where lambda is 0, or does not stay what it is: then there is no such section.
    """
    parameters, *_ = _lasting(attrs)
    lam = float(trajectory["jellett"][0])
    if lam == 0:
        raise InputError(["the inversion is drawn of a run with lambda other than 0, but it is 0."])
    if np.ptp(trajectory["jellett"].values) > KEPT * abs(lam):
        raise InputError(
            [
                "`inversion` is drawn of a run that keeps lambda; this one does not (drilling, "
                "or another ball)."
            ]
        )
    lines = marked_lines(parameters, lam)
    ends = np.array([*lines["D"].values.ravel(), *trajectory["routh"].values])
    margin = 0.12 * np.ptp(ends) or 1e-9
    section = minimal_surface(
        parameters, np.linspace(ends.min() - margin, ends.max() + margin, 801), lam
    )
    return section, lines, trajectory, f"{heading(attrs)}: λ = {lam * 1e6:.6g} × 10⁻⁶ kg m³ s⁻¹"


def states(
    trajectory: xr.Dataset, events: xr.Dataset, attrs: dict[str, Any]
) -> tuple[list[tumbling.Branch], dict[str, float], str, tuple[np.ndarray, np.ndarray]]:
    """The asymptotic states of the body of a run as branches over lambda, values of lambda to be
    marked, a title, and the run as cos(theta) with its lambda [kg m^3/s] while it is on its sphere.
    """
    _lasting(attrs)
    seen = _on_sphere(trajectory)
    lam = seen["jellett"].values
    branches, marks = diagram(attrs["system"], attrs["parameters"], float(np.nanmax(np.abs(lam))))
    return branches, marks, heading(attrs), (np.cos(seen["theta"].values), lam)


def diagram(
    system: str, parameters: dict[str, float], lam: float
) -> tuple[list[tumbling.Branch], dict[str, float]]:
    """The asymptotic states of a body as branches over lambda, to beyond this one [kg m^3/s], and
    its thresholds.
    """
    _body({"system": system, "parameters": parameters}, SPINNING)
    body = SYSTEMS[system].body_of(parameters, Frictionless())
    limits = {r"$\lambda_u$": thresholds.lambda_u(body), r"$\lambda_s$": thresholds.lambda_s(body)}
    marks = {name: float(value) for name, value in limits.items() if np.isfinite(value)}
    return tumbling.branches(body, 1.25 * max(abs(lam), *marks.values())), marks


def heading(attrs: dict[str, Any]) -> str:
    """The title of a run as figures begin with it."""
    return str(attrs["title"][:1].upper() + attrs["title"][1:])


def _on_sphere(trajectory: xr.Dataset) -> xr.Dataset:
    """The run without what it has of a sphere while it stands on its stem: NaN there."""
    if "ball" not in trajectory:
        return trajectory
    names = [
        name for name in ("theta", "routh", "jellett", "modified_energy") if name in trajectory
    ]
    return trajectory[names].where(xr.DataArray(~flagged(trajectory["ball"], "stem"), dims="time"))


def refuse_parts(friction: Mapping[str, Any]) -> None:
    """Raise InputError if numbers of a friction law are those of torques under which no spinning
    state lasts.
    """
    if acts := [f"friction.{name}" for name in PARTS if friction.get(name)]:
        words = "this figure shows spinning states, which must last, but none does under"
        raise InputError([f"{words} `{acts[0]}`: draw theta or energy."])


def _lasting(attrs: dict[str, Any]) -> tuple[dict[str, float], str, Landscape]:
    """Parameters, system and landscape of a run whose spinning states last.

    Raises InputError for another one.
    """
    refuse_parts(attrs.get("friction", {}))
    return _body(attrs, SPINNING)


def _body(
    attrs: dict[str, Any], momenta: tuple[str, str] | None = None
) -> tuple[dict[str, float], str, Landscape]:
    """Parameters, system and landscape of a run.

    Raises InputError where there is none, or none over these momenta.
    """

    def fits(landscape: Landscape | None) -> bool:
        return landscape is not None and momenta in (None, landscape.symbols)

    name = attrs["system"]
    record = find(name)
    landscape = record.landscape if record is not None else None
    if landscape is None or not fits(landscape):
        allowed = [other for other, system in SYSTEMS.items() if fits(system.landscape)]
        raise InputError(
            [f"this figure is drawn for {', '.join(allowed)} only; this is {a_system(name)}."]
        )
    return dict(attrs["parameters"]), name, landscape
