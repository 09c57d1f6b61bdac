"""Where tops end: spinning and tumbling states, thresholds, stability, linear modes, and the regime of a start.

Bodies are `gliding.Body` records of floats, SI; thresholds also take arrays. Theorem 3.3.2 of the source is used as
corrected: below gamma_+ some tumbling states near the upright are unstable, and below gamma_c the upright spin outlives
the inverted one.
"""

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from .friction import slip_coefficient
from .system import JELLETT, ONE, RADIAN_PER_SECOND, System, Unit
from .systems.gliding import Body


class Threshold(NamedTuple):
    """A number that separates regimes: value (SI), unit, and what it means."""

    value: float
    unit: Unit
    long_name: str


class Shape(NamedTuple):
    """alpha, gamma = I1/I3, sigma = m R^2/I3 of a tippe top, and beta = sqrt(m g R^3 alpha I3) [kg m^3/s]."""

    alpha: Any
    gamma: Any
    sigma: Any
    beta: Any


def shape(b: Body) -> Shape:
    """The numbers that decide about a tippe top."""
    alpha = b.c / b.R
    return Shape(alpha, b.I1 / b.I3, b.m * b.R**2 / b.I3, np.sqrt(b.m * b.g * b.R**3 * alpha * b.I3))


# --- spinning states ------------------------------------------------------------------------------------------------


def lambda_u(b: Body) -> Any:
    """The upright spin is stable for |lambda| below it; infinite if always. [T Theorem 3.3.2]"""
    alpha, gamma, _, beta = shape(b)
    return _over_root(beta * (1 - alpha) ** 2, alpha + gamma - 1)


def lambda_s(b: Body) -> Any:
    """The inverted spin is stable for |lambda| above it; infinite if never. [T 4.30]"""
    alpha, gamma, _, beta = shape(b)
    return _over_root(beta * (1 + alpha) ** 2, 1 + alpha - gamma)


def _over_root(number: Any, x: Any) -> Any:
    """number/sqrt(x), infinite where x is not positive."""
    with np.errstate(divide="ignore"):
        return number / np.sqrt(np.maximum(x, 0.0))


def lambda_de(b: Body) -> Any:
    """Above it the inverted spin has less energy E~ than the upright one of the same lambda. [T 4.29]"""
    alpha = b.c / b.R
    return np.sqrt(b.m * b.g * b.R**3 * b.I3) * (1 - alpha**2)


def gamma_c(alpha: float) -> float:
    """lambda_s > lambda_u if and only if gamma is above it. [section 6]"""
    return (1 - alpha**2) * (1 + 3 * alpha**2) / (1 + 6 * alpha**2 + alpha**4)


def gamma_plus(alpha: float) -> float:
    """All tumbling states are stable if and only if gamma is at least this. [section 6]"""
    return (1 - alpha) * (7 + alpha + math.sqrt(1 + 14 * alpha + alpha**2)) / 8


def spin_of(lam: float, b: Body, *, inverted: bool = False) -> float:
    """omega_3 of the upright (or inverted) spin with Jellett's integral lam [rad/s]."""
    return -lam / ((b.R + b.c) * b.I3) if inverted else lam / ((b.R - b.c) * b.I3)


def thresholds(b: Body) -> dict[str, Threshold]:
    """Every threshold of a tippe top."""
    alpha, gamma = b.c / b.R, b.I1 / b.I3
    return {
        "lambda_u": Threshold(lambda_u(b), JELLETT, "upright spin stable below"),
        "lambda_s": Threshold(lambda_s(b), JELLETT, "inverted spin stable above"),
        "lambda_de": Threshold(lambda_de(b), JELLETT, "inverted spin has less energy than upright spin above"),
        "spin_upright": Threshold(spin_of(lambda_u(b), b), RADIAN_PER_SECOND, "upright spin loses stability at"),
        "spin_inverted": Threshold(
            -spin_of(lambda_s(b), b, inverted=True), RADIAN_PER_SECOND, "inverted spin gains stability at"
        ),
        "spin_full": Threshold(
            spin_of(lambda_s(b), b), RADIAN_PER_SECOND, "initial upright spin from which the inverted one is stable"
        ),
        "gamma": Threshold(gamma, ONE, "I1/I3"),
        "gamma_c": Threshold(gamma_c(alpha), ONE, "lambda_s > lambda_u above"),
        "gamma_plus": Threshold(gamma_plus(alpha), ONE, "every tumbling state stable from here on"),
    }


# --- tumbling states ------------------------------------------------------------------------------------------------


def tumbling_limits(b: Body) -> tuple[float, float]:
    """The open interval of z = cos(theta) in which tumbling states exist. [T 3.62, 3.63]"""
    alpha, gamma, *_ = shape(b)
    low = max(-1.0, -alpha / (gamma - 1)) if gamma > 1 else -1.0
    return low, min(1.0, alpha / (1 - gamma)) if gamma < 1 else 1.0


def tumbling(z: Any, b: Body) -> tuple[Any, Any]:
    """phi' and omega_3 [rad/s] of the tumbling state at z, for phi' > 0; NaN where there is none. [T 3.62]"""
    with np.errstate(invalid="ignore", divide="ignore"):
        phi_dot = np.sqrt(b.m * b.g * b.c / (b.I3 * (b.c / b.R - z) + b.I1 * z))
    return phi_dot, -(b.c / b.R - z) * phi_dot


def tumbling_jellett(z: Any, b: Body) -> Any:
    """lambda of the tumbling state at z, for phi' > 0 [kg m^3/s]; NaN where there is none. [T 3.42, 3.66]"""
    alpha, gamma, _, beta = shape(b)
    with np.errstate(invalid="ignore", divide="ignore"):
        return beta * ((alpha - z) ** 2 + gamma * (1 - z**2)) / np.sqrt(alpha + (gamma - 1) * z)


def lambda_t(b: Body) -> Any:
    """The least lambda of a tumbling state [kg m^3/s]; less than lambda_u where gamma_c < gamma < gamma_plus: there the
    upright spin and tumbling are both stable in between. To about 1e-5."""
    z = np.linspace(-1, 1, 401).reshape(-1, *(1,) * np.ndim(b.I1 + b.I3 + b.c))
    return np.nanmin(tumbling_jellett(z, b), axis=0)


def tumbling_is_stable(z: Any, b: Body) -> Any:
    """Whether the tumbling state at z is stable, which is d|lambda|/dz < 0. [T Theorem 3.3.2, corrected]"""
    alpha, gamma, *_ = shape(b)
    rising = ((1 - gamma) * z - alpha) ** 2 > gamma * (1 - alpha**2 - gamma) / 3
    return rising & np.isfinite(tumbling_jellett(z, b))


def tumbling_states(lam: float, b: Body) -> np.ndarray:
    """Every z at which a tumbling state has Jellett's integral lam, ascending: roots of a quartic."""
    alpha, gamma, _, beta = shape(b)
    h = np.array([1 - gamma, -2 * alpha, alpha**2 + gamma])
    rest = np.polysub(beta**2 * np.polymul(h, h), lam**2 * np.array([gamma - 1, alpha]))
    roots = np.roots(rest)
    z = np.sort(roots[np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots))].real)
    low, high = tumbling_limits(b)
    return z[(z > low) & (z < high)]


class Branch(NamedTuple):
    """A curve of asymptotic states in the plane of lambda [kg m^3/s] and z = cos(theta), all stable or all not."""

    kind: str
    stable: bool
    z: np.ndarray
    lam: np.ndarray


def branches(b: Body, most: float) -> list[Branch]:
    """Every asymptotic state of a tippe top with 0 <= lambda <= most, as curves cut where stability changes.

    The source's figure 3.3."""
    found = []
    for kind, pole, limit, inside in (("upright", 1.0, lambda_u(b), True), ("inverted", -1.0, lambda_s(b), False)):
        for ends, calm in (((0.0, min(limit, most)), inside), ((min(limit, most), most), not inside)):
            if ends[0] < ends[1]:
                found.append(Branch(kind, calm, np.full(2, pole), np.array(ends)))
    low, high = tumbling_limits(b)
    z = low + (high - low) * (1 - np.cos(np.linspace(0, np.pi, 2001)[1:-1])) / 2
    lam: Any = tumbling_jellett(z, b)
    stable: Any = tumbling_is_stable(z, b)
    cuts = [0, *(np.flatnonzero(np.diff(stable)) + 1), len(z)]
    for first, last in itertools.pairwise(cuts):
        piece = slice(first, min(last + 1, len(z)))  # one point on, so that the curve has no gap
        found.append(Branch("tumbling", bool(stable[first]), z[piece], lam[piece]))
    return found


# --- linear modes ---------------------------------------------------------------------------------------------------


def linear_modes(omega3: float, b: Body, *, inverted: bool = False) -> np.ndarray:
    """The three rates p of u_x + i u_y ~ exp(pt) near a spinning state of a gliding body [1/s], fastest growth first.

    Any friction law counts by its slip coefficient at rest. [section 6; Magnus; Friedl 1997]
    """
    up = -1 if inverted else 1
    slip = slip_coefficient(0.0, float(up), b.friction)
    Lz, h = up * b.I3 * omega3, b.R - up * b.c
    n = np.array([1j * Lz / b.I1, -1j * up / b.I1, 0])
    momentum = np.array([-1j * b.m * b.g * b.c, 0, 1j * h * slip * b.m * b.g])
    twist = h * (1 / b.I3 - 1 / b.I1) * up * Lz + Lz / b.I3 * b.c
    v = np.array([0, 0, -slip * b.g]) + 1j * h / b.I1 * momentum + 1j * twist * n
    modes = np.linalg.eigvals(np.array([n, momentum, v]))
    return modes[np.argsort(-modes.real)]


LINEAR = 1e-2  # rad from a pole within which the modes tell what becomes of a motion


def will_leave(theta: float, omega3: float, b: Body) -> bool:
    """Whether a gliding body at theta [rad] with spin omega3 [rad/s] is about to leave the pole: it is so near that its
    motion is linear, and a mode grows there. [section 6]"""
    inverted = theta > math.pi / 2
    near = min(theta, math.pi - theta) < LINEAR
    return near and bool(linear_modes(omega3, b, inverted=inverted)[0].real > 0)


def rolling_modes(omega3: float, b: Body, *, inverted: bool = False) -> np.ndarray:
    """The two rates p near a spinning state of a body whose contact is at rest (rolling, or a fixed tip) [1/s]."""
    up = -1 if inverted else 1
    h = b.R - up * b.c
    p = np.roots([b.I1 + b.m * h**2, -1j * omega3 * up * (b.I3 + b.m * h * b.R), up * b.m * b.g * b.c])
    return p[np.argsort(-p.real)]


def sleeping_spin(b: Body) -> float:
    """|omega_3| above which the upright heavy top with a fixed tip is stable, 2 sqrt(m g l I1*)/I3 [rad/s]. [T 5.54]"""
    return 2 * math.sqrt(b.m * b.g * -b.c * (b.I1 + b.m * b.c**2)) / b.I3


# --- regimes --------------------------------------------------------------------------------------------------------


class Regime(NamedTuple):
    """Which asymptotic states are stable for a value of Jellett's integral."""

    upright: bool
    inverted: bool
    tumbling: tuple[float, ...]  # theta of the stable tumbling states [rad], descending z
    unstable: tuple[float, ...]  # theta of the unstable ones

    @property
    def attractors(self) -> list[str]:
        """The stable states in words."""
        names = ["the upright spin"] if self.upright else []
        names += [f"tumbling at theta = {theta:.6g} rad" for theta in self.tumbling]
        return names + (["the inverted spin"] if self.inverted else [])

    def sentence(self) -> str:
        """What is stable."""
        found = self.attractors
        if not found:
            return "no spinning or tumbling state is stable"
        if len(found) == 1:
            return f"only {found[0]} is stable"
        word = "both" if len(found) == 2 else "all"
        return f"{', '.join(found[:-1])} and {found[-1]} are {word} stable"


def regime(lam: float, b: Body) -> Regime:
    """The regime of Jellett's integral lam."""
    states = tumbling_states(lam, b)[::-1] if lam else np.zeros(0)
    stable = [bool(tumbling_is_stable(z, b)) for z in states]
    angles = np.arccos(states)
    return Regime(
        upright=abs(lam) < lambda_u(b),
        inverted=abs(lam) > lambda_s(b),
        tumbling=tuple(float(t) for t, s in zip(angles, stable, strict=True) if s),
        unstable=tuple(float(t) for t, s in zip(angles, stable, strict=True) if not s),
    )


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
        from .nutation import heavy_top_motion

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
