"""The effective potential V, its minimal surface F = inf V, turning angles and nutation, as labelled arrays.

Every function takes the parameters of a body in SI (as a scenario's [parameters]), arrays or numbers in SI, and the
name of the system: tippe tops, with momenta (D, lambda), or heavy tops, with momenta (L3, Lz). Grids do not raise: what
has no answer is NaN, and a Status of the same shape says why.
"""

import decimal
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from .friction import Frictionless
from .operand import refill
from .systems import gliding, spinning, surface, tippe_top
from .systems.surface import SHAPES


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
ALLOWANCE = 1e-12  # relative: an energy this close to the minimum touches it (the drift of a good run stays below)


@dataclass(frozen=True)
class Top:
    """A body as the kernels take it."""

    system: str
    parameters: dict[str, float]
    relief: surface.Relief
    body: gliding.Body
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
        relief = surface.rounded(shape.relief(body))
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
    from tippetop_kernels.lanes import in_stages

    formulas = {
        name: inlined(getattr(surface, name)) for name in ("lean", "guess", "slopes", "value", "ends", "gradient")
    }
    for name, stages in surface.STAGES.items():
        in_stages(formulas[name], *(inlined(stage) for stage in stages))
    # not inlined where it is called from many places: a third of the compilation
    formulas |= {name: kernel(getattr(surface, name)) for name in ("bend", "excess")}
    formulas["inertia"] = inlined(tippe_top.theta_inertia)
    return Kernels(
        grid.minima,
        grid.heights,
        grid.gradients,
        grid.potentials,
        grid.turnings,
        grid.periods,
        tuple(formulas[name] for name in ("lean", "guess", "slopes", "value", "ends")),
        formulas,
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


def argmin(q: np.ndarray, status: np.ndarray, upright: int) -> np.ndarray:
    """z where V is least: the pole itself where the infimum is approached there."""
    from tippetop_kernels.minimise import Status

    z = cosine(q, upright)
    z[status == Status.AT_LOWER_END] = upright
    z[status == Status.AT_UPPER_END] = -upright
    return z


# --- the potential --------------------------------------------------------------------------------------------------


def potential(
    parameters: Mapping[str, float], z: Any, first: Any, second: Any, system: str = "tippe-top"
) -> xr.Dataset:
    """V [J] and its derivatives by z over the grid z x first x second, dimensions of length one dropped.

    `z` = cos(theta) in (-1, 1), ascending; first and second momentum are D [kg m^2/s] and lambda [kg m^3/s] for tippe
    tops, L3 and Lz [kg m^2/s] for heavy tops. No digits are lost near the poles: 1 - z is exact there, and X is formed
    without cancellation. Outside (-1, 1), at z = +-1 too, and for infinite arguments V is NaN: it is +oo at a pole off
    the marked line; the end values on it are those of `marked_lines`. [T 4.12, 2.38, 5.26]
    """
    t, k = top(parameters, system), kernels()
    z, x, y = axis("z", z), axis(t.momenta[0], first), axis(t.momenta[1], second)
    V, V_z, V_zz = (np.empty((z.size, x.size, y.size)) for _ in range(3))
    f = k.formulas
    with np.errstate(invalid="ignore"):
        k.potentials(f["lean"], f["slopes"], f["value"], t.upright * z, x, y, t.relief, V, V_z, V_zz)
    dims = ("z", *t.momenta)
    scale = 1 / t.relief.gamma.head
    return xr.Dataset(
        {
            "V": labelled("V", dims, V),
            "V_z": labelled("V_z", dims, V_z * (t.upright * scale), "J", "dV/dz"),
            "V_zz": labelled("V_zz", dims, V_zz * scale, "J", "d2V/dz2"),
        },
        {
            "z": labelled("z", "z", z),
            t.momenta[0]: labelled(t.momenta[0], t.momenta[0], x),
            t.momenta[1]: labelled(t.momenta[1], t.momenta[1], y),
            "theta": labelled("theta", "z", np.arccos(np.clip(z, -1, 1))),
        },
        attributes(t),
    ).squeeze([d for d in t.momenta if {t.momenta[0]: x, t.momenta[1]: y}[d].size == 1])


# --- the minimal surface --------------------------------------------------------------------------------------------


def minima(t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None) -> tuple[np.ndarray, ...]:
    """F [J], q of the minimum and Status over x x y, each (x.size, y.size)."""
    from tippetop_kernels.grid import on_threads

    k = kernels()
    F, q = np.empty((x.size, y.size)), np.empty((x.size, y.size))
    status = np.empty((x.size, y.size), np.int8)
    on_threads(lambda s: k.minima(*k.problem, t.several, x[s], y, t.relief, F[s], q[s], status[s]), x.size, threads)
    return F, q, status


def heights(t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """F [J] and Status alone over x x y, in four fifths of the time; F is as good as that of `minima`."""
    from tippetop_kernels.grid import on_threads

    k, F, status = kernels(), np.empty((x.size, y.size)), np.empty((x.size, y.size), np.int8)
    on_threads(lambda s: k.heights(*k.problem, t.several, x[s], y, t.relief, F[s], status[s]), x.size, threads)
    return F, status


def minimal_surface(
    parameters: Mapping[str, float],
    first: Any,
    second: Any,
    system: str = "tippe-top",
    *,
    gradient: bool = True,
    threads: int | None = None,
) -> xr.Dataset:
    """F = inf V [J] over the grid first x second (D x lambda, or L3 x Lz), with where and how it is taken.

    F is good to 1 ulp (tested: 4). The minimiser, z = cos(theta) and theta [rad], is good to the rounding of dV/dln(q)
    over d2V/dln(q)^2, q = tan(theta/2)^2: some 1e-15 relative in q, hence in theta and in 1 - |z|, except next to the
    points where the minimum flattens (lambda = lambda_pi on the line theta = pi), where the cube root of that is left.
    With `gradient`, F_D and F_lambda by the envelope theorem, to 1e-13 of the larger of |F_D|, F/|D| (likewise lambda).

    `status`: attained; at_lower_end, at_upper_end: an infimum that is approached at theta = 0, pi (exchanged for heavy
    tops), D and lambda being on a marked line to within four roundings; lower_of_two; unsettled; undefined (an argument
    is not finite: NaN). D = lambda = 0 is on the line theta = 0. Raises ValueError for axes that are empty or do not
    ascend. [T 4.13 with section 5]
    """
    from tippetop_kernels.minimise import Status

    t = top(parameters, system)
    x, y = axis(t.momenta[0], first), axis(t.momenta[1], second)
    F, q, status = minima(t, x, y, threads)
    dims = t.momenta
    z, theta = argmin(q, status, t.upright), inclination(q, t.upright)
    theta[status == Status.AT_LOWER_END] = 0.0 if t.upright == 1 else np.pi
    theta[status == Status.AT_UPPER_END] = np.pi if t.upright == 1 else 0.0
    data = {
        "F": labelled("F", dims, F),
        "z": labelled("z", dims, z, long_name="z = cos(theta) where V is least"),
        "theta": labelled("theta", dims, theta, long_name="theta where V is least"),
        "status": (dims, status, flags(Status, "how F is taken")),
    }
    if gradient:
        from tippetop_kernels.grid import on_threads

        k, by_x, by_y = kernels(), np.empty_like(F), np.empty_like(F)
        f = k.formulas
        on_threads(
            lambda s: k.gradients(f["lean"], f["gradient"], x[s], y, t.relief, q[s], by_x[s], by_y[s]), x.size, threads
        )
        units = {"D": "s-1", "lambda": "m-1 s-1", "L3": "s-1", "Lz": "s-1"}
        for name, by in zip(dims, (by_x, by_y), strict=True):
            data[f"F_{name}"] = labelled("", dims, by, units[name], f"dF/d{name}")
    coords = {name: labelled(name, name, v) for name, v in zip(dims, (x, y), strict=True)}
    return xr.Dataset(data, coords, attributes(t))


# --- turning angles and nutation ------------------------------------------------------------------------------------


def turning_angles(
    parameters: Mapping[str, float], first: Any, second: Any, energy: Any, system: str = "tippe-top"
) -> xr.Dataset:
    """The two angles where V = E~ [J], the period of nutation between them, and that of small nutations.

    The arguments are broadcast against one another, with any shape; DataArrays keep their dimensions and coordinates.
    theta_min <= theta_star <= theta_max [rad]; theta_star is where V is least (the lower of two minima). `period` [s]
    is the quadrature of the separated equation, NaN where it does not settle to 11 digits (nutations of some 1e-5 rad
    or less, and next to a separatrix); `small_period` [s] is 2 pi sqrt(2 g/V''), exact for vanishing amplitude.
    `level`: above; touching: E~ is the minimum to 1e-12, both angles are theta_star; below; undefined. [T 4.12, 4.21]
    """
    from tippetop_kernels.roots import Level

    t, k = top(parameters, system), kernels()
    arrays: list[Any] = [
        a if isinstance(a, xr.DataArray) else np.asarray(a, dtype=float) for a in (first, second, energy)
    ]
    if any(isinstance(a, xr.DataArray) for a in arrays):
        arrays = list(xr.broadcast(*(a if isinstance(a, xr.DataArray) else xr.DataArray(a) for a in arrays)))
        dims, coords = arrays[0].dims, dict(arrays[0].coords)
    else:
        arrays = list(np.broadcast_arrays(*arrays))
        dims, coords = tuple(f"dim_{i}" for i in range(arrays[0].ndim)), {}
    shape = arrays[0].shape
    x, y, E = (np.ascontiguousarray(np.asarray(a, dtype=float).ravel()) for a in arrays)
    low, high, q, F, V_ss = (np.empty(x.size) for _ in range(5))
    level = np.empty(x.size, np.int8)
    f = k.formulas
    k.turnings(
        *k.problem, f["excess"], f["bend"], t.several, ALLOWANCE, x, y, E, t.relief, low, high, q, F, V_ss, level
    )
    period = np.empty(x.size)
    k.periods(f["lean"], f["excess"], f["inertia"], low, high, x, y, E, t.relief, t.body, period)
    z = cosine(q, t.upright)
    small = np.pi * np.sqrt(2 * tippe_top.theta_inertia(z, t.body) * (4 * q / (1 + q) ** 2) / V_ss)
    inner, outer = (low, high) if t.upright == 1 else (high, low)
    angles = "inclination theta [rad] where V = E~"
    data = {
        "theta_min": labelled("theta", dims, inclination(inner, t.upright).reshape(shape), long_name="least " + angles),
        "theta_max": labelled(
            "theta", dims, inclination(outer, t.upright).reshape(shape), long_name="largest " + angles
        ),
        "theta_star": labelled("theta", dims, inclination(q, t.upright).reshape(shape), long_name="theta of least V"),
        "F": labelled("F", dims, F.reshape(shape)),
        "period": labelled("", dims, period.reshape(shape), "s", "period of nutation"),
        "small_period": labelled("", dims, small.reshape(shape), "s", "period of small nutations"),
        "level": (dims, level.reshape(shape), flags(Level, "how E~ lies to the minimum of V")),
    }
    return xr.Dataset(data, coords, attributes(t))


def band(parameters: Mapping[str, float], run: xr.Dataset, system: str = "tippe-top") -> xr.Dataset:
    """The nutational band along a run, as the main equation predicts it: theta_min(t), theta_max(t), F(t), periods.

    `run` has the momenta (routh and jellett, or L3 and Lz) and modified_energy [J] along `time`. [T 4.21, 5.26]
    """
    names = run_names(system)
    first, second, energy = (run[name] for name in names)
    found = turning_angles(parameters, first, second, energy, system)
    for name in (*names, "theta"):
        if name in run:
            found[name] = run[name]
    return found


def run_names(system: str) -> tuple[str, str, str]:
    """The variables of a run that place it in its landscape: two momenta and the energy."""
    return ("routh", "jellett", "modified_energy") if SHAPES[system].upright == 1 else ("L3", "Lz", "modified_energy")


# --- the spinning states --------------------------------------------------------------------------------------------


def marked_lines(parameters: Mapping[str, float], lam: Any) -> xr.Dataset:
    """The spinning states theta = 0, pi of a tippe top with Jellett's integral `lam` [kg m^3/s]: boundary values.

    D [kg m^2/s], E~ [J], omega_3 [rad/s] of each `end`, and whether it lies on the minimal surface: theta = 0 always,
    theta = pi iff |lambda| >= lambda_pi (an attribute). [T 4.23-4.28; 5.1]
    """
    t = top(parameters)
    lam, z = axis("lambda", lam), np.array([1.0, -1.0])
    lam_pi = float(spinning.lambda_pi(t.body))
    Z, Lam = z[:, None], lam[None, :]
    dims = ("end", "lambda")
    return xr.Dataset(
        {
            "D": labelled("D", dims, spinning.momentum(Z, Lam, t.body)),
            "E": labelled("E", dims, spinning.energy(Z, Lam, t.body), "J", "modified energy E~ of the spinning state"),
            "omega3": labelled("omega3", dims, spinning.spin(Z, Lam, t.body), "rad s-1", "spin omega_3"),
            "on_surface": (dims, (Z > 0) | (np.abs(Lam) >= lam_pi), {"long_name": "E~ = F there"}),
        },
        {"end": ["theta = 0", "theta = pi"], "lambda": labelled("lambda", "lambda", lam)},
        attributes(t, lambda_pi=lam_pi),
    )
