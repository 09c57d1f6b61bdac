"""`tippetop surface, potential`: the minimal surface and the effective potential of a scenario's body."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


Axis = Annotated[str | None, Parameter()]
Json = Annotated[bool, Parameter(name="--json", negative=())]


def surface(
    scenario: str,
    *,
    D: Annotated[str | None, Parameter(name="--D")] = None,
    lambda_: Annotated[str | None, Parameter(name="--lambda")] = None,
    out: Path | None = None,
    figure: Path | None = None,
) -> int:
    """The minimal surface F(D, lambda) over a grid; into a store chunk by chunk, resumable: any size.

    Parameters
    ----------
    scenario
        TOML file, or preset: its body is used.
    D
        min:max:n of Routh's function [kg m^2/s]; by default across both spinning states, 401 points.
    lambda_
        min:max:n of Jellett's integral [kg m^3/s]; by default 0 to 4.5 lambda_pi, 401 points.
    out
        Store to write, a zarr folder; must not exist yet. Interrupted, the same command goes on.
    figure
        Draw the surface with both marked lines to this PNG, SVG or PDF.
    """
    import numpy as np

    from ..landscape import marked_lines, recording, surface
    from ..progress import Bar
    from .run import _check_picture

    parameters, system = _tippe_top(scenario)
    if out is None and figure is None:
        raise _wrong("surface must be given --out or --figure, but has neither.")
    if figure is not None:
        _check_picture(figure)
    lam_pi = marked_lines.marked_lines(parameters, 0.0).attrs["lambda_pi"]
    lambdas = _axis("--lambda", lambda_) if lambda_ else np.linspace(0, 4.5 * lam_pi, 401)
    ends = marked_lines.marked_lines(parameters, lambdas)["D"].values
    Ds = _axis("--D", D) if D else np.linspace(1.1 * min(ends.min(), -1e-9), 1.1 * max(ends.max(), 1e-9), 401)
    if out is not None:
        try:
            with Bar("chunks") as bar:
                wanted = recording.Surface.over(parameters, Ds, lambdas, system)
                recording.write(out, wanted, progress=bar.update)
        except KeyboardInterrupt:
            print("tippetop: interrupted; the same command goes on from here.", file=sys.stderr)
            return 130
    if figure is not None:
        few = [v[np.unique(np.linspace(0, v.size - 1, 401).astype(int))] for v in (Ds, lambdas)]
        _draw_surface(surface.minimal_surface(parameters, few[0], few[1], system, gradient=False), parameters, figure)
    print(f"F(D, lambda) at {Ds.size} x {lambdas.size} points; lambda_pi = {lam_pi:.6g} kg m^3/s")
    return 0


def potential(
    scenario: str,
    *,
    D: Annotated[float, Parameter(name="--D")],
    lambda_: Annotated[float, Parameter(name="--lambda")],
    n: int = 1001,
    out: Path | None = None,
    figure: Path | None = None,
    as_json: Json = False,
) -> int:
    """The effective potential V(z; D, lambda) of a tippe top, and its minimum.

    Parameters
    ----------
    scenario
        TOML file, or preset: its body is used.
    D
        Routh's function [kg m^2/s].
    lambda_
        Jellett's integral [kg m^3/s].
    n
        Number of points, evenly spread in theta, poles excluded.
    out
        Store to write, a zarr folder; must not exist yet.
    figure
        Draw V to this PNG, SVG or PDF.
    as_json
        Print the minimum as one JSON object.
    """
    import numpy as np

    from ..landscape import potential, recording, surface
    from ..store import root
    from .run import _check_picture

    parameters, system = _tippe_top(scenario)
    for name, value in (("--D", D), ("--lambda", lambda_)):
        if not math.isfinite(value):
            raise _wrong(f"{name} must be finite, but is {value}.")
    if n < 2:
        raise _wrong(f"--n must be at least 2, but is {n}.")
    if figure is not None:
        _check_picture(figure)
    z = np.cos(np.linspace(np.pi, 0, n + 2)[1:-1])
    V = potential.potential(parameters, z, D, lambda_, system)
    least = surface.minimal_surface(parameters, D, lambda_, system)
    meanings = least["status"].attrs["flag_meanings"].split()
    found = {
        "F": least["F"].item(),
        "theta": least["theta"].item(),
        "F_D": least["F_D"].item(),
        "F_lambda": least["F_lambda"].item(),
        "status": meanings[least["status"].item()],
    }
    if out is not None:
        attrs = {"title": "effective potential V(z)", "system": system, "parameters": parameters}
        recording.write_potential(out, V, {**attrs, "D": D, "lambda": lambda_, "minimum": found})
    if figure is not None:
        _draw_potential(V, least, figure)
    if as_json:
        print(json.dumps(root.finite(found), allow_nan=False))
    else:
        print(f"F = {found['F']:.12g} J at theta = {found['theta']:.9g} rad ({found['status'].replace('_', ' ')})")
    return 0


def picture(store: Path, attrs: dict[str, Any], out: Path) -> int:
    """Draws the store of `surface` or `potential`."""
    import numpy as np

    from ..landscape import surface
    from ..store import root

    group = root.open_group(store, attrs["content"])
    if attrs["content"] == "potential":
        least = surface.minimal_surface(attrs["parameters"], attrs["D"], attrs["lambda"], attrs["system"])
        _draw_potential(group, least, out)
    else:
        some = {d: np.unique(np.linspace(0, group.sizes[d] - 1, 401).astype(int)) for d in group["F"].dims}
        _draw_surface(group.isel(some), attrs["parameters"], out)
    return 0


def describe(attrs: dict[str, Any], as_json: bool) -> int:
    """Says what the store of `surface` or `potential` holds."""
    if as_json:
        print(json.dumps(attrs, allow_nan=False))
        return 0
    print(attrs["title"])
    for name in ("system", "parameters", "axes", "D", "lambda", "minimum", "versions"):
        if name in attrs:
            value = attrs[name]
            text = ", ".join(f"{k} = {v}" for k, v in value.items()) if isinstance(value, dict) else value
            print(f"{name}  {text}")
    return 0


def _draw_surface(grid: Any, parameters: dict[str, float], path: Path) -> None:
    from ..figures import landscape
    from ..figures.style import save, styled
    from ..landscape import marked_lines

    with styled():
        save(landscape.surface(grid, marked_lines.marked_lines(parameters, grid["lambda"].values)), path)


def _draw_potential(V: Any, least: Any, path: Path) -> None:
    from ..figures import landscape
    from ..figures.style import save, styled

    D, lam = float(least["D"][0]), float(least["lambda"][0])
    title = f"V(z), D = {D:.4g} kg m² s⁻¹, λ = {lam:.4g} kg m³ s⁻¹"
    at = least.squeeze(drop=True).rename(theta="theta_star")
    with styled():
        save(landscape.potential([(title, V, at)]), path)


def _tippe_top(scenario: str) -> tuple[dict[str, float], str]:
    """Parameters and system of a scenario. Raises ScenarioError if it has no (D, lambda)."""
    from ..landscape.along_run import SPINNING
    from ..scenario import build

    problem = build.load(scenario)
    landscape = problem.system.landscape
    if landscape is None or landscape.symbols != SPINNING:
        raise _wrong(f"`system` must be a tippe top to have a potential in D and lambda, but is {problem.system.name}.")
    return {k: float(v) for k, v in problem.parameters.items()}, problem.system.name


def _axis(name: str, text: str) -> Any:
    """min:max:n as an array. Raises ScenarioError."""
    import numpy as np

    try:
        low, high, n = text.split(":")
        limits, count = (float(low), float(high)), int(n)
        if not (all(map(math.isfinite, limits)) and limits[0] < limits[1] and count >= 2):
            raise ValueError
    except ValueError:
        raise _wrong(f"{name} must be min:max:n with min < max and n at least 2, but is `{text}`.") from None
    return np.linspace(*limits, count)


def _wrong(sentence: str) -> Exception:
    from ..errors import InputError

    return InputError([sentence])


COMMANDS: list[Any] = [surface, potential]
