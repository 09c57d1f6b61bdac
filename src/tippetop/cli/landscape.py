"""`tippetop surface, potential`: the minimal surface and the effective potential of a scenario's
body.
"""

from __future__ import annotations

import math
import re
import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..figures import drawing
from ..figures.catalogue import PLAIN, Look
from ..mechanics.units import ANGULAR_MOMENTUM, JELLETT, Unit
from .numbers import Jellett, Routh, Whole, number_in
from .streams import print_json


COMPILING = "the formulas are being compiled"
MOST_POINTS = 10**7  # of an axis, which is held in memory whole
Axis = Annotated[str | None, Parameter(allow_leading_hyphen=True)]


def surface(
    scenario: str,
    *,
    D: Axis = None,
    lambda_: Axis = None,
    out: Path | None = None,
    figure: Path | None = None,
    overwrite: bool = False,
    threads: Whole | None = None,
) -> int:
    """The minimal surface F(D, lambda) of a tippe top over a grid of any size; the same command
    continues an unfinished one.

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
        Store to write or to continue, a zarr folder. Of a finished one there is nothing to do.
    figure
        Draw the surface and the lines of both spinning states on it to this PNG, SVG or PDF.
    overwrite
        Make a store anew that exists, finished or not, and replace an existing picture.
    threads
        How many threads compute; by default as many as usable cores.
    """
    import numpy as np

    from ..awaiting import awaited
    from ..landscape import marked_lines, recording, surface
    from ..progress import Bar
    from ..store import root
    from .overwrite import remove_store
    from .plot import check_picture
    from .text import warn

    parameters, system = _tippe_top(scenario)
    if threads is not None and threads < 1:
        raise _wrong(f"--threads must be at least 1, but is {threads}.")
    if out is None and figure is None:
        raise _wrong("nothing is to be done: give --out F.zarr, --figure F.png, or both.")
    check_picture(figure, "--figure", overwrite)
    lam_pi = marked_lines.marked_lines(parameters, 0.0).attrs["lambda_pi"]
    lambdas = _axis("--lambda", lambda_, JELLETT) if lambda_ else np.linspace(0, 4.5 * lam_pi, 401)
    warn(_far(parameters, float(np.abs(lambdas).max())))
    ends = marked_lines.marked_lines(parameters, lambdas)["D"].values
    low, high = 1.1 * min(ends.min(), -1e-9), 1.1 * max(ends.max(), 1e-9)
    Ds = _axis("--D", D, ANGULAR_MOMENTUM) if D else np.linspace(low, high, 401)
    minimal = partial(
        surface.minimal_surface, parameters, system=system, gradient=False, threads=threads
    )
    if out is not None and overwrite:
        remove_store(out)
    if out is not None:
        finished = out.exists() and root.root_of(out)["status"] == "finished"
        corners = (Ds[:: max(1, Ds.size - 1)], lambdas[:: max(1, lambdas.size - 1)])
        try:
            if not np.isfinite(awaited(lambda: minimal(*corners), COMPILING)["F"].values).all():
                raise _wrong(
                    "`--D` and `--lambda` must leave V within the doubles, but at their ends do "
                    "not."
                )
            with Bar("chunks") as bar:
                wanted = recording.Surface.over(parameters, Ds, lambdas, system)
                recording.write(out, wanted, threads=threads, progress=bar.update)
        except KeyboardInterrupt:
            print("tippetop: interrupted; the same command continues from here.", file=sys.stderr)
            return 130
        if finished:
            print(
                f"tippetop: `{out}` was finished: its chunks are checked (--overwrite makes it "
                "anew).",
                file=sys.stderr,
            )
    if figure is not None:
        few = tuple(
            v[np.unique(np.linspace(0, v.size - 1, 401).astype(int))] for v in (Ds, lambdas)
        )
        grid = awaited(lambda: minimal(*few), COMPILING)
        drawing.write(_surface(grid, parameters), figure, overwrite=overwrite)
    print(f"F(D, lambda) at {Ds.size} x {lambdas.size} points; lambda_pi = {lam_pi:.6g} kg m^3/s")
    return 0


FAR = 1e3  # times lambda_pi: a top that spins so fast is not of this world


def _far(parameters: dict[str, float], lam: float) -> list[str]:
    """A sentence on a lambda that looks as if it were in another unit."""
    from ..landscape import marked_lines

    limit = marked_lines.marked_lines(parameters, 0.0).attrs["lambda_pi"]
    if abs(lam) <= FAR * limit:
        return []
    return [
        f"lambda = {lam:g} kg m^3/s is far from lambda_pi = {limit:.3g} kg m^3/s: it looks like "
        "another unit."
    ]


def potential(
    scenario: str,
    *,
    D: Routh,
    lambda_: Jellett,
    n: Whole = 1001,
    out: Path | None = None,
    figure: Path | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """The effective potential V(z; D, lambda) of a tippe top, and its minimum.

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
        Store to write, a zarr folder; must not exist yet (or say --overwrite).
    figure
        Draw V(z) to this PNG, SVG or PDF.
    overwrite
        Replace an existing store and an existing picture.
    as_json
        Print the minimum as one JSON object.
    """
    import numpy as np

    from ..awaiting import awaited
    from ..landscape import potential, recording, surface
    from .overwrite import remove_store
    from .plot import check_picture
    from .text import warn

    parameters, system = _tippe_top(scenario)
    for name, value in (("--D", D), ("--lambda", lambda_)):
        if not math.isfinite(value):
            raise _wrong(f"{name} must be finite, but is {value}.")
    if not 2 <= n <= MOST_POINTS:
        raise _wrong(f"--n must be at least 2 and at most {MOST_POINTS}, but is {n}.")
    check_picture(figure, "--figure", overwrite)
    warn(_far(parameters, lambda_))
    z = np.cos(np.linspace(np.pi, 0, n + 2)[1:-1])
    V = awaited(lambda: potential.potential(parameters, z, D, lambda_, system), COMPILING)
    least = awaited(lambda: surface.minimal_surface(parameters, D, lambda_, system), COMPILING)
    meanings = least["status"].attrs["flag_meanings"].split()
    report = {
        "F": least["F"].item(),
        "theta": least["theta"].item(),
        "F_D": least["F_D"].item(),
        "F_lambda": least["F_lambda"].item(),
        "status": meanings[least["status"].item()],
    }
    if not math.isfinite(report["F"]):
        raise _wrong(
            f"`--D` and `--lambda` must leave V within the doubles, but D = {D:g}, lambda = "
            f"{lambda_:g} do not."
        )
    if out is not None:
        if overwrite:
            remove_store(out)
        attrs = {"title": "effective potential V(z)", "system": system, "parameters": parameters}
        recording.write_potential(out, V, {**attrs, "D": D, "lambda": lambda_, "minimum": report})
    if figure is not None:
        drawing.write(_potential(V, least), figure, overwrite=overwrite)
    if as_json:
        print_json(report)
    else:
        print(
            f"F = {report['F']:.12g} J at theta = {report['theta']:.9g} rad "
            f"({report['status'].replace('_', ' ')})"
        )
    return 0


def picture(store: Path, attrs: dict[str, Any], look: Look) -> Any:
    """The figure of the store of `surface` or `potential`."""
    import numpy as np

    from ..landscape import surface
    from ..store import root

    group = root.open_group(store, attrs["content"])
    if attrs["content"] == "potential":
        least = surface.minimal_surface(
            attrs["parameters"], attrs["D"], attrs["lambda"], attrs["system"]
        )
        return _potential(root.loaded(group, store), least, look)
    some = {
        d: np.unique(np.linspace(0, group.sizes[d] - 1, 401).astype(int)) for d in group["F"].dims
    }
    return _surface(root.loaded(group.isel(some), store), attrs["parameters"], look)


def describe(attrs: dict[str, Any], as_json: bool) -> int:
    """Prints what the store of `surface` or `potential` holds."""
    if as_json:
        return print_json(attrs)
    from .show import entries, plain
    from .text import heading, table

    heading(attrs["title"])
    names = ("system", "parameters", "axes", "D", "lambda", "minimum", "versions")
    given = [(name, attrs[name]) for name in names if name in attrs]
    table((name, entries(v, {}) if isinstance(v, dict) else plain(v)) for name, v in given)
    return 0


def _surface(grid: Any, parameters: dict[str, float], look: Look = PLAIN) -> Any:
    """The figure of a surface, with the lines of both spinning states."""
    from ..landscape import marked_lines

    lines = marked_lines.marked_lines(parameters, grid["lambda"].values)
    return drawing.composed("surface", (grid, lines), look)


def _potential(V: Any, least: Any, look: Look = PLAIN) -> Any:
    """The figure of a potential, with its minimum."""
    D, lam = float(least["D"]), float(least["lambda"])
    title = (
        f"Effective potential V(z)\nD = {D * 1e6:.5g} × 10⁻⁶ kg m² s⁻¹, λ = {lam * 1e6:.5g} "
        "× 10⁻⁶ kg m³ s⁻¹"
    )
    at = least.squeeze(drop=True).rename(theta="theta_star")
    return drawing.composed("potential", ([("", V, at)], title), look)


def _tippe_top(scenario: str) -> tuple[dict[str, float], str]:
    """Parameters and system of a scenario. Raises InputError if it has no (D, lambda)."""
    from ..errors import a_system
    from ..landscape.along_run import SPINNING
    from ..scenario import build

    problem = build.load(scenario)
    landscape = problem.system.landscape
    if landscape is None and problem.contact is not None and problem.system.inverts:
        raise _wrong(
            "D and lambda belong to a sphere that stays on the plane; the contact of this top "
            "changes its phase."
        )
    if landscape is None or landscape.symbols != SPINNING:
        raise _wrong(
            f"D and lambda belong to tippe tops only; this is {a_system(problem.system.name)}."
        )
    return {k: float(v) for k, v in problem.parameters.items()}, problem.system.name


def _axis(name: str, text: str, unit: Unit) -> Any:
    """Return min:max:n as an array. Raises InputError."""
    import numpy as np

    ends = re.fullmatch(r"([^:]+):([^:]+):\s*(\d+)\s*", text)
    limits = [number_in(end, name, unit) for end in ends.groups()[:2]] if ends else [math.nan]
    count = int(ends[3]) if ends else 0
    if not (all(map(math.isfinite, limits)) and limits[0] < limits[1] and count >= 2):
        raise _wrong(f"{name} must be min:max:n with min < max and n at least 2, but is `{text}`.")
    if count > MOST_POINTS:
        raise _wrong(f"{name} must have at most {MOST_POINTS} points, but has {count}.")
    return np.linspace(limits[0], limits[1], count)


def _wrong(sentence: str) -> Exception:
    from ..errors import InputError

    return InputError(sentence)
