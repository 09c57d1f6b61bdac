"""`tippetop surface, potential`: the minimal surface and the effective potential of a body."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..arguments import PlainData, measured
from ..awaiting import awaited
from ..errors import InputError
from ..figures.catalogue import PLAIN, Look
from ..mechanics.units import ANGULAR_MOMENTUM, JELLETT, Unit
from .streams import print_json, visible
from .values import Jellett, Place, Routh, Whole


if TYPE_CHECKING:
    from ..landscape.landscape_body import Top


COMPILING = "the formulas are being compiled"
MOST_POINTS = 10**7  # of an axis, which memory contains as a whole
SHOWN = 401  # points of an axis in a figure, or by default
Axis = Annotated[str | None, Parameter(allow_leading_hyphen=True)]


def surface(
    scenario: str,
    *,
    D: Axis = None,
    lambda_: Axis = None,
    out: Place | None = None,
    figure: Place | None = None,
    overwrite: bool = False,
    threads: Whole | None = None,
) -> int:
    """Compute the minimal surface F(D, lambda) of a tippe top.

    Parameters
    ----------
    scenario
        TOML file, or preset: its body is used.
    D
        min:max:n of Routh's function [kg m^2/s, or with units]; by default across both spinning
        states, 401 points.
    lambda_
        min:max:n of Jellett's integral [kg m^3/s, or with units]; by default 0 to 4.5 lambda_pi,
        401 points.
    out
        Store to write, a zarr folder; must not exist yet (or use --overwrite).
    figure
        Draw the surface and the lines of both spinning states on it to this PNG, SVG or PDF.
    overwrite
        Replace an existing store and an existing picture.
    threads
        How many threads compute; by default as many as usable cores.
    """
    import numpy as np

    from ..figures import drawing
    from ..landscape import marked_lines, surface, surface_recording
    from ..progress import Bar
    from ..sampling import spread
    from ..store import files
    from .targets import check_picture

    top = _tippe_top(scenario)
    if out is None and figure is None:
        raise InputError("nothing to do: give --out F.zarr, --figure F.png, or both.")
    check_picture(figure, overwrite)
    if out is not None:  # now rather than after formulas are compiled
        files.refuse_existing(out, overwrite)
    lambda_pi = marked_lines.marked_lines(top, 0.0).attrs["lambda_pi"]
    default = np.linspace(0, 4.5 * lambda_pi, SHOWN)
    lambdas = _axis("--lambda", lambda_, JELLETT) if lambda_ else default
    ends = marked_lines.marked_lines(top, lambdas)["D"].values
    default = np.linspace(1.1 * min(ends.min(), -1e-9), 1.1 * max(ends.max(), 1e-9), SHOWN)
    Ds = _axis("--D", D, ANGULAR_MOMENTUM) if D else default
    minimal = partial(surface.minimal_surface, top, gradient=False, threads=threads)
    if out is not None:
        # V overflows first at the largest momenta; formulas are compiled before the bar is shown
        corners = [axis[[0, -1]] for axis in (Ds, lambdas)]
        if not np.isfinite(awaited(lambda: minimal(*corners), COMPILING)["F"].values).all():
            raise InputError("`--D` and `--lambda` must keep V finite, but at their ends do not.")
        with Bar("chunks") as bar:
            surface_recording.write(
                out,
                top,
                Ds,
                lambdas,
                threads=threads,
                progress=bar.update,
                overwrite=overwrite,
            )
    if figure is not None:
        few = [axis[spread(axis.size, SHOWN)] for axis in (Ds, lambdas)]
        grid = awaited(lambda: minimal(*few), COMPILING)
        drawing.write(_surface(grid, top), figure, overwrite=overwrite)
    print(
        f"F(D, lambda) at {Ds.size} x {lambdas.size} points; lambda_pi = {lambda_pi:.6g} kg m^3/s"
    )
    return 0


def potential(
    scenario: str,
    *,
    D: Routh,
    lambda_: Jellett,
    n: Whole = 1001,
    out: Place | None = None,
    figure: Place | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Compute the effective potential V(z; D, lambda) of a tippe top, and its minimum.

    Parameters
    ----------
    scenario
        TOML file, or preset: its body is used.
    D
        Routh's function [kg m^2/s, or with a unit].
    lambda_
        Jellett's integral [kg m^3/s, or with a unit].
    n
        Number of points, evenly spread in theta, poles excluded.
    out
        Store to write, a zarr folder; must not exist yet (or use --overwrite).
    figure
        Draw V(z) to this PNG, SVG or PDF.
    overwrite
        Replace an existing store and an existing picture.
    as_json
        Print the minimum as one JSON object.
    """
    import numpy as np

    from ..columns import flag_words
    from ..figures import drawing
    from ..landscape import potential, surface, surface_recording
    from .targets import check_picture

    top = _tippe_top(scenario)
    if not 2 <= n <= MOST_POINTS:
        raise InputError(f"--n must be at least 2 and at most {MOST_POINTS}, but is {n}.")
    check_picture(figure, overwrite)
    z = np.cos(np.linspace(np.pi, 0, n + 2)[1:-1])
    V = awaited(lambda: potential.potential(top, z, D, lambda_), COMPILING)
    least = awaited(lambda: surface.minimal_surface(top, D, lambda_), COMPILING)
    minimum = {name: least[name].item() for name in ("F", "theta", "F_D", "F_lambda")}
    minimum["status"] = flag_words(least["status"]).item()
    if not math.isfinite(minimum["F"]):
        raise InputError(
            f"`--D` and `--lambda` must keep V finite, but D = {D:g}, lambda = {lambda_:g} do not."
        )
    if out is not None:
        attrs = {
            "title": "effective potential V(z)",
            "system": top.system.name,
            "parameters": top.parameters,
            "D": D,
            "lambda": lambda_,
            "minimum": minimum,
        }
        surface_recording.write_potential(out, V, attrs, overwrite=overwrite)
    if figure is not None:
        drawing.write(_potential(V, least), figure, overwrite=overwrite)
    if as_json:
        return print_json(minimum)
    print(
        f"F = {minimum['F']:.12g} J at theta = {minimum['theta']:.9g} rad "
        f"({minimum['status'].replace('_', ' ')})"
    )
    return 0


def picture(store: Path, attrs: PlainData, look: Look) -> Any:
    """Draw the store of `surface` or `potential`, whose root attributes are `attrs`; return Axes.

    `plot` calls it. The momenta of a potential are among the attributes.
    """
    from ..landscape import landscape_body, surface
    from ..sampling import spread
    from ..store import root

    group = root.open_group(store, attrs["content"])
    top = landscape_body.top(attrs["parameters"], attrs["system"])
    if attrs["content"] == "potential":
        least = surface.minimal_surface(top, attrs["D"], attrs["lambda"])
        return _potential(root.loaded(group, store), least, look)
    some = {dim: spread(group.sizes[dim], SHOWN) for dim in group["F"].dims}
    return _surface(root.loaded(group.isel(some), store), top, look)


def describe(attrs: PlainData, as_json: bool) -> int:
    """Print the content of the store of `surface` or `potential`; return the exit code.

    `info` calls it; `attrs` are the root attributes of the store.
    """
    if as_json:
        return print_json(attrs)
    from .text import plain, table

    print(visible(attrs["title"]))
    names = ("status", "system", "parameters", "D", "lambda", "minimum", "versions")
    table((name, plain(attrs[name], {})) for name in names if name in attrs)
    return 0


def _surface(grid: Any, top: Top, look: Look = PLAIN) -> Any:
    """Draw a surface, a Dataset of `surface.minimal_surface`, with lines of both spinning states.

    Return its Axes.
    """
    from ..figures import drawing, landscape_figures
    from ..landscape import marked_lines

    lines = marked_lines.marked_lines(top, grid["lambda"].values)
    return drawing.drawn(lambda: landscape_figures.surface(grid, lines), look)


def _potential(V: Any, least: Any, look: Look = PLAIN) -> Any:
    """Draw a potential with its minimum; return its Axes.

    `V` is a Dataset of `potential.potential`, `least` one of `surface.minimal_surface` for the same
    D and lambda.
    """
    from ..figures import drawing, well

    D = float(least["D"])
    lam = float(least["lambda"])
    title = (
        f"Effective potential V(z)\nD = {D * 1e6:.5g} × 10⁻⁶ kg m² s⁻¹, λ = {lam * 1e6:.5g} "
        "× 10⁻⁶ kg m³ s⁻¹"
    )
    # as `turning_angles` names it, without a level: `well.potential` reads these names
    at = least.squeeze(drop=True).rename(theta="theta_star")
    return drawing.drawn(lambda: well.potential([("", V, at)], title), look)


def _tippe_top(scenario: str) -> Top:
    """Return the body of a scenario. Raises InputError if it has no (D, lambda)."""
    from ..landscape.landscape_body import top
    from ..mechanics.contact.surroundings import require_still
    from ..runs.starting import load

    problem = load(scenario)
    require_still(problem.tables, "a top in a landscape")
    body = top(problem.parameters, problem.system)  # of the sphere, whatever its contact does
    body.require_spinning()
    return body


def _axis(name: str, text: str, unit: Unit) -> Any:
    """Return the text min:max:n as n evenly spaced numbers, ascending, SI, (n,). Raises InputError.

    `name` is the option, for messages. min and max are SI numbers, or texts with a unit that
    converts to `unit`.
    """
    import numpy as np

    wrong = InputError(
        f"{name} must be min:max:n with min < max and n at least 2, but is `{text}`."
    )
    parts = re.fullmatch(r"([^:]+):([^:]+):\s*(\d+)\s*", text)
    if parts is None:
        raise wrong
    low = measured(name, parts[1], unit)
    high = measured(name, parts[2], unit)
    count = int(parts[3])
    if low >= high or count < 2:
        raise wrong
    if count > MOST_POINTS:
        raise InputError(f"{name} must have at most {MOST_POINTS} points, but has {count}.")
    return np.linspace(low, high, count)
