"""A run in its landscape: the data of the figures of band, surface, potential and states.

Tables of a run go in; labelled data of one figure come out: `figures.drawing` passes what each
function returns to the drawing of this name, as its arguments, in this order.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..arguments import PlainData
from ..columns import capitalised, on_sphere, significant_turnings
from ..errors import InputError
from ..mechanics.contact.surroundings import require_still
from ..mechanics.friction import PARTS, Frictionless
from ..mechanics.systems.tippe_top import is_peg
from ..mechanics.theory import thresholds, tumbling
from .landscape_body import Top, top
from .marked_lines import marked_lines
from .potential import potential as potential_over
from .surface import minimal_surface
from .turning import band as band_along
from .turning import turning_angles


TIMES = 6  # panels of the potential
KEPT = 1e-9  # relative change of a quantity that is constant


def band(
    trajectory: xr.Dataset, events: xr.Dataset, attrs: PlainData
) -> tuple[xr.Dataset, xr.Dataset, str]:
    """Return the band along a run, the logged turning angles with the nearer edge, and a title.

    Where the band rises fast, theta can turn at its upper edge only.
    D and E~ at a turning are a cubic through the neighbouring output times: at 40 outputs a
    nutation, that leaves the edge some 1e-6 rad uncertain.
    """
    from scipy.interpolate import CubicSpline

    t = _body_of(attrs)
    angles = band_along(t, trajectory)
    turning = significant_turnings(events)
    times = trajectory["time"].values
    turning &= times.size >= 4
    when = events["time"].values[turning]
    theta = events["theta"].values[turning]
    x, y, E = (
        CubicSpline(times, trajectory[name].values)(when) if when.size else when
        for name in t.landscape.columns
    )
    edges = turning_angles(t, x, y, E, theta=theta)
    low = edges["theta_min"].values
    high = edges["theta_max"].values
    edge = np.where(np.abs(theta - low) < np.abs(theta - high), low, high)
    logged = xr.Dataset({"theta": ("time", theta), "edge": ("time", edge)}, {"time": when})
    return (
        angles,
        logged,
        f"{capitalised(attrs['title'])}: the band that the main equation predicts",
    )


def surface(trajectory: xr.Dataset, events: xr.Dataset, attrs: PlainData) -> tuple[Any, ...]:
    """Return the surface around a run, the marked lines, the run on its sphere, and a title.

    They are the arguments of `landscape_figures.surface`; the first three are Datasets.
    """
    t = _body_of(attrs)
    refuse_parts(attrs.get("friction", {}))
    lam = float(trajectory["jellett"][0])
    if lam == 0:
        raise InputError("the surface is drawn around a run with lambda other than 0, but it is 0.")
    # from 0, where both marked lines begin; sorted, because axes ascend and lam may be negative
    lambdas = np.sort(np.linspace(0, 1.25 * lam, 201))
    lines = marked_lines(t, lambdas)
    seen = _on_sphere(trajectory)
    ends = np.append(lines["D"].values, seen["routh"].values)
    grid = minimal_surface(t, np.linspace(np.nanmin(ends), np.nanmax(ends), 201), lambdas)
    return grid, lines, seen, capitalised(attrs["title"])


def potential(trajectory: xr.Dataset, events: xr.Dataset, attrs: PlainData) -> tuple[Any, ...]:
    """Return V(z), E~ and the turning angles at several times of a run, and a title.

    Each time has a tuple: words on it, the Dataset of `potential_over`, and that of
    `turning_angles` with E~ as `energy`. The times are evenly spread in theta, hence all through an
    inversion. Where D, lambda and E~ are constant, there is one time. `attrs` are those of the run.
    """
    t = _body_of(attrs)
    trajectory = trajectory.isel(time=on_sphere(trajectory))
    theta = trajectory["theta"].values
    if not theta.size:
        raise InputError(
            "the potential is that of a top on its sphere, and this one is on its stem or "
            "in the air."
        )
    risen = -theta if is_peg(t.parameters) else theta
    reached = np.maximum.accumulate(risen)
    picks = np.unique(np.searchsorted(reached, np.linspace(risen[0], reached[-1], TIMES)))
    if picks.size < TIMES:  # the top does not rise: evenly spread in time
        picks = np.unique(np.linspace(0, theta.size - 1, TIMES).round().astype(int))
    states = [trajectory[name].values for name in t.landscape.columns]
    constant = all(np.ptp(v) <= KEPT * np.abs(v).max() for v in states)
    z = np.cos(np.linspace(np.pi, 0, 4003)[1:-1])
    curves = []
    for i in picks[:1] if constant else picks:
        x, y, E = (values[i] for values in states)
        at = turning_angles(t, x, y, E, theta=float(theta[i])).assign(energy=E)
        words = "at all times" if constant else f"t = {float(trajectory['time'][i]):.4g} s"
        curves.append((words, potential_over(t, z, x, y), at))
    return curves, f"{capitalised(attrs['title'])}: effective potential V(z)"


def states(
    trajectory: xr.Dataset, events: xr.Dataset, attrs: PlainData
) -> tuple[list[tumbling.Branch], dict[str, float], str, tuple[np.ndarray, np.ndarray]]:
    """Return the asymptotic states of the body of a run; see `diagram`.

    Further a title, and the run as cos(theta) with its lambda [kg m^3/s] while it is on its sphere.
    """
    t = _body_of(attrs)
    refuse_parts(attrs.get("friction", {}))
    seen = _on_sphere(trajectory)
    lam = seen["jellett"].values
    branches, marks = diagram(t, float(np.nanmax(np.abs(lam))))
    return branches, marks, capitalised(attrs["title"]), (np.cos(seen["theta"].values), lam)


def _body_of(attrs: PlainData) -> Top:
    """Return the body of a run with these root attributes.

    Raises InputError if it has no landscape, or a plane or air that changes the potential.
    """
    require_still(attrs, "a run in a landscape")
    return top(attrs["parameters"], attrs["system"])


def diagram(t: Top, lam: float) -> tuple[list[tumbling.Branch], dict[str, float]]:
    """Return the asymptotic states of a body as branches over lambda, and its thresholds.

    `lam` is a value of lambda that the figure must show [kg m^3/s]; the names of the thresholds are
    labels in TeX. The branches of the spinning states reach 1.25 times the largest of |lam| and the
    thresholds; those of tumbling are whole. `tippetop plot SCENARIO states` calls it too.
    """
    t.require_spinning()
    body = t.system.body_of(t.parameters, Frictionless())
    limits = {r"$\lambda_u$": thresholds.lambda_u(body), r"$\lambda_s$": thresholds.lambda_s(body)}
    # one of the two is finite for every c other than 0, so that `max` is not 0 even for lam = 0
    marks = {name: float(value) for name, value in limits.items() if np.isfinite(value)}
    # `stability.states` takes the width of the figure from the spinning branches
    return tumbling.branches(body, 1.25 * max(abs(lam), *marks.values())), marks


def _on_sphere(trajectory: xr.Dataset) -> xr.Dataset:
    """Return the columns that a landscape needs, NaN where the sphere does not touch the plane."""
    names = {"theta", "routh", "jellett", "modified_energy"} & {*trajectory}  # a run may drop some
    return trajectory[sorted(names)].where(xr.DataArray(on_sphere(trajectory), dims="time"))


def refuse_parts(friction: Mapping[str, Any]) -> None:
    """Raise InputError if a friction law has torques under which no spinning state lasts."""
    if acts := [f"friction.{name}" for name in PARTS if friction.get(name)]:
        words = "this figure shows spinning states, which must last, but none does under"
        raise InputError(f"{words} `{acts[0]}`: draw theta or energy.")
