"""The numbers of a scenario that fit a measured motion best, and what the measurements say of them.

Least squares with exact derivatives: of slow changes first, by means over much time, then over a window that grows. A
motion that oscillates has a best fit in every period, and only near the start of the window is the right one near; the
first window has a few of the oscillations that the data's spectrum shows. So are the best of many other starts.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .observation import Observation


OSCILLATIONS = 3.0  # of the first window
FEWEST = 12  # measurements of the first window, per free number
GROWTH = 2.0  # of a window to the next
SLOW = (0.1, 0.03, 0.01)  # widths over which residuals are averaged at first, in the span of the data
MOST_SMOOTH = 3000  # rows that are averaged: the matrix has their square
SCANNED = 96  # rows that are scanned
CANDIDATES, TRIED = 160, 3  # of a scan; and how many of its minima are followed
PRIOR = 0.5  # how far a number may go, in logarithm or in its size, before the whole of the data is seen
STARTS = 4  # that are followed
SAMPLES = 128  # others, of which the best are followed
AGREE = 1e-3  # by which the costs of starts that led to the same fit differ at most
FAR = 0.35  # how far off other starts are
WIDEST = float(np.log(20))  # how far the logarithm of a number may go from where it starts
MARGIN = 1e-6  # by which a start lies within the bounds, in the size of the number
NOISY = 4.0  # standard errors of a correlation between neighbouring residuals that noise does not have
LOSSES = ("linear", "soft_l1", "huber", "cauchy")
SAME = 0.99  # a correlation of numbers that cannot be distinguished
QUANTILE = 0.975


class Estimate(NamedTuple):
    """A number that was fitted: its value, standard error and 95 % interval, SI."""

    value: float
    sigma: float
    low: float
    high: float


class Fit(NamedTuple):
    """The result of a fit.

    Parameters
    ----------
    estimates
        By dotted name.
    correlations
        (free, free).
    converged
        Whether the numbers are those that fit best, and the data decide them.
    reason
        A sentence for each thing that must be known; the first says how it ended.
    residuals
        Name of each kind of measurement -> (rows, parts), measured less predicted, SI.
    noise
        Name -> its standard deviation.
    t
        (rows,).
    evaluations
        How many motions with derivatives were computed.
    """

    estimates: dict[str, Estimate]
    correlations: np.ndarray
    converged: bool
    reason: list[str]
    residuals: dict[str, np.ndarray]
    noise: dict[str, float]
    t: np.ndarray
    evaluations: int


class _Scale(NamedTuple):
    """How a free number is searched: its logarithm where it must be positive, else itself in units of `size`."""

    logarithmic: bool
    size: float
    low: float
    high: float

    def inside(self, value: float) -> float:
        """What is searched, of a value."""
        return float(np.log(value)) if self.logarithmic else value / self.size

    def outside(self, inside: float) -> float:
        """The value of what is searched."""
        return float(np.exp(np.clip(inside, -600, 600))) if self.logarithmic else inside * self.size

    def slope(self, value: float) -> float:
        """d value/d inside."""
        return value if self.logarithmic else self.size


def _scale(observation: Observation, name: str, value: float) -> _Scale:
    rule = observation.rule(name)
    low = max((b for b in (rule.above, rule.least) if b is not None), default=-np.inf)
    high = min((b for b in (rule.below, rule.most) if b is not None), default=np.inf)
    if low == 0 and not np.isfinite(high) and value > 0:
        return _Scale(True, 1.0, float(np.log(value)) - WIDEST, float(np.log(value)) + WIDEST)
    size = abs(value) or 1.0
    return _Scale(False, size, low / size, high / size)


def fit(observation: Observation, loss: str = "linear", starts: int = STARTS, seed: int = 0) -> Fit:
    """Fits the free numbers of an observation.

    Parameters
    ----------
    observation
        Measurements and the scenario.
    loss
        linear, or soft_l1, huber, cauchy, which outliers hardly move.
    starts
        How many starts are followed.
    seed
        Of the other starts.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        If there are fewer measurements than numbers, or a number does nothing.
    """
    if loss not in LOSSES:
        raise InputError([f"the loss must be one of {', '.join(LOSSES)}, but is {loss!r:.40}."])
    return _Search(observation, loss).best(starts, np.random.default_rng(seed))


class _Search:
    def __init__(self, observation: Observation, loss: str):
        self.observation, self.loss, self.evaluations = observation, loss, 0
        self.begin = observation.start()
        self.scales = [_scale(observation, name, value) for name, value in self.begin.items()]
        self.count = sum(int(np.isfinite(rows).sum()) for rows in observation.groups.values())
        if self.count <= len(self.begin):
            raise InputError(
                [f"more measurements than free numbers must be there, but are {self.count} for {len(self.begin)}."]
            )
        self.weights = {group: 1.0 for group in observation.groups}
        self._known: tuple[bytes, int, Any] | None = None
        self._smooth = 0.0  # the width [s] over which residuals are averaged
        self._refuse_idle()

    def _refuse_idle(self) -> None:
        """A free number that does nothing to what was measured cannot be fitted."""
        inside = self._inside(self.begin)
        residual, jacobian = self._at(inside, len(self.observation.t))
        if not np.isfinite(residual).any():
            raise InputError(["the scenario must move over the time of the table, but cannot."])
        sizes = np.sqrt((jacobian**2).sum(axis=0))
        idle = [name for name, size in zip(self.begin, sizes, strict=True) if size <= 1e-12 * max(sizes.max(), 1e-300)]
        if idle:
            raise InputError([f"`{name}` must change what was measured, but does nothing to it." for name in idle])

    # --- one window ---------------------------------------------------------------------------------------------------

    def _inside(self, values: dict[str, float]) -> np.ndarray:
        return np.array([scale.inside(v) for scale, v in zip(self.scales, values.values(), strict=True)])

    def _outside(self, inside: np.ndarray) -> dict[str, float]:
        return {name: s.outside(u) for name, s, u in zip(self.begin, self.scales, inside, strict=True)}

    def _at(self, inside: np.ndarray, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Weighted residuals of the first rows and their Jacobian; where nothing was measured they are left out, and
        where the motion cannot be computed they are as large as can be."""
        key = inside.tobytes() + np.float64(self._smooth).tobytes()
        if self._known is not None and self._known[:2] == (key, rows):
            return self._known[2]
        values = self._outside(inside)
        self.evaluations += 1
        parts = self.observation.predicted(values, slice(0, rows))
        slopes = np.array([s.slope(v) for s, v in zip(self.scales, values.values(), strict=True)])
        residuals, jacobians = [], []
        smooth = self._smooth
        for group, (off, moves) in parts.items():
            given = np.isfinite(self.observation.groups[group][:rows]).all(axis=1)
            r = (off[given] * self.weights[group]).ravel()
            j = (-moves[given] * self.weights[group]).reshape(len(r), -1) * slopes
            broken = ~np.isfinite(r) | ~np.isfinite(j).all(axis=1)
            r[broken], j[broken] = 10.0 * self.weights[group], 0.0
            if smooth:
                means = self._means(np.repeat(self.observation.t[:rows][given], off.shape[1]), off.shape[1], smooth)
                r, j = means @ r, means @ j
            residuals.append(r)
            jacobians.append(j)
        result = np.concatenate(residuals), np.concatenate(jacobians)
        self._known = key, rows, result
        return result

    def _solved(self, start: np.ndarray, rows: int, prior: np.ndarray | None, most: int) -> np.ndarray:
        """The best numbers over the first rows; `prior`: near which they are kept."""
        from scipy.optimize import least_squares

        spread = self._noise_guess(start, rows) / PRIOR if prior is not None else 0.0

        def residual(inside: np.ndarray) -> np.ndarray:
            own = self._at(inside, rows)[0]
            return own if prior is None else np.concatenate([own, spread * (inside - prior)])

        def jacobian(inside: np.ndarray) -> np.ndarray:
            own = self._at(inside, rows)[1]
            return own if prior is None else np.concatenate([own, spread * np.eye(len(inside))])

        low, high = (np.array([getattr(s, side) for s in self.scales]) for side in ("low", "high"))
        start = np.clip(start, low + MARGIN, high - MARGIN)
        scale = max(float(np.median(np.abs(residual(start)))), 1e-12)
        result = least_squares(
            residual, start, jacobian, bounds=(low, high), method="trf", x_scale="jac", loss=self.loss, f_scale=scale,
            xtol=1e-10, ftol=1e-10, gtol=1e-10, max_nfev=most,
        )  # fmt: skip
        return result.x

    def _noise_guess(self, inside: np.ndarray, rows: int) -> float:
        """The size of a residual, weighted: a number may then go as far as `PRIOR` for the price of one residual."""
        return max(float(np.median(np.abs(self._at(inside, rows)[0]))), 1e-6)

    # --- the whole ----------------------------------------------------------------------------------------------------

    def _windows(self) -> list[int]:
        """Rows of each window, growing to all."""
        t = self.observation.t
        total = len(t)
        per_row = self.count / total
        fewest = int(np.ceil(FEWEST * len(self.begin) / per_row))
        first = int(np.searchsorted(t - t[0], OSCILLATIONS * self._period(2 * fewest), side="right"))
        rows, windows = max(fewest, first), []
        while rows < total / 1.3:
            windows.append(rows)
            rows = int(np.ceil(rows * GROWTH))
        return [*windows, total]

    def _period(self, rows: int) -> float:
        """The period of the strongest oscillation in the first rows [s]; a Lomb periodogram bears gaps."""
        from scipy.signal import lombscargle

        t = self.observation.t[:rows]
        y = next(iter(self.observation.groups.values()))[:rows, -1]
        given = np.isfinite(y)
        t, y = t[given], y[given]
        if len(t) < 8:
            return float(t[-1] - t[0])
        smooth = np.polynomial.Polynomial.fit(t, y, min(5, len(t) // 4))(t)
        step = float(np.median(np.diff(t)))
        frequencies = np.linspace(2 / (t[-1] - t[0]), 0.5 / step, 4 * len(t))
        power = lombscargle(t, y - smooth, 2 * np.pi * frequencies)
        return float(1 / frequencies[int(np.argmax(power))])

    def _followed(self, start: np.ndarray) -> np.ndarray:
        """The best numbers from a start: slow changes first, then a scan along what these leave open, and from the best
        of it window by window."""
        inside, windows = start, self._windows()
        span = float(self.observation.t[-1] - self.observation.t[0])
        if windows[-1] <= MOST_SMOOTH:
            for part in SLOW:
                self._smooth = part * span
                inside = self._solved(inside, windows[-1], start, 15)
            way = self._open(inside, windows[-1])
            self._smooth = 0.0
            rows = min(windows[-1], max(SCANNED, windows[0]))
            begins = self._scanned(inside, way, rows)
        else:
            begins, rows = [inside], 0
        best, cost = inside, np.inf
        for begin in begins:
            point = begin
            for window in [rows, *(w for w in windows[:-1] if w > rows)] if rows else windows[:-1]:
                point = self._solved(point, window, None if rows else start, 12)
            point = self._solved(point, windows[-1], None, 40)
            size = self._cost(self._at(point, windows[-1])[0])
            if size < cost:
                best, cost = point, size
        return best

    def _cost(self, residual: np.ndarray) -> float:
        """The sum of squares, or of what a robust loss makes of them, in units of a common noise."""
        if self.loss == "linear":
            return float((residual**2).sum())
        return float(np.abs(residual).sum())

    def _open(self, inside: np.ndarray, rows: int) -> np.ndarray:
        """The step along which slow changes say least; the largest change of a number in it is `PRIOR`."""
        _, jacobian = self._at(inside, rows)
        noise = self._noise_guess(inside, rows)
        _, ways = np.linalg.eigh(jacobian.T @ jacobian / noise**2 + np.eye(len(inside)) / PRIOR**2)
        return ways[:, 0] * PRIOR / np.abs(ways[:, 0]).max()

    def _costs(self, points: list[np.ndarray], rows: int) -> np.ndarray:
        """What each of many points leaves of the first rows, (points,)."""
        costs = []
        for off in self.observation.residuals([self._outside(p) for p in points], rows):
            parts = []
            for group, values in off.items():
                given = np.isfinite(self.observation.groups[group][:rows])
                parts.append(np.nan_to_num(values[given] * self.weights[group], nan=10.0))
            costs.append(self._cost(np.concatenate(parts)))
        return np.array(costs)

    def _scanned(self, inside: np.ndarray, way: np.ndarray, rows: int) -> list[np.ndarray]:
        """The best of many numbers along a step, the lowest minima first."""
        low, high = (np.array([getattr(s, side) for s in self.scales]) for side in ("low", "high"))
        points = [np.clip(inside + s * way, low + MARGIN, high - MARGIN) for s in np.linspace(-1.0, 1.0, CANDIDATES)]
        value = self._costs(points, rows)
        inner = np.concatenate([[np.inf], value, [np.inf]])
        minima = np.flatnonzero((inner[1:-1] <= inner[:-2]) & (inner[1:-1] <= inner[2:]))
        return [points[k] for k in minima[np.argsort(value[minima])][:TRIED]]

    def _means(self, t: np.ndarray, parts: int, width: float) -> np.ndarray:
        """The matrix that averages residuals over a width of time, each part by itself."""
        same = np.arange(len(t)) % parts
        weight = np.exp(-(((t[:, None] - t[None, :]) / width) ** 2) / 2) * (same[:, None] == same[None, :])
        return weight / weight.sum(axis=1, keepdims=True)

    def best(self, starts: int, random: np.random.Generator) -> Fit:
        """The best fit of several starts: the scenario's own, and the lowest of many others, computed in lanes."""
        begin, whole = self._inside(self.begin), len(self.observation.t)
        ends = [self._followed(begin)]
        if starts > 1:
            others = [begin + self._steps(random) for _ in range(SAMPLES)]
            ends += [self._followed(point) for point in self._lowest(others, min(whole, SCANNED), starts - 1)]
        costs = np.array([self._cost(self._at(end, whole)[0]) for end in ends])
        chosen = ends[int(np.argmin(costs))]
        agreed = int((costs <= costs.min() * (1 + AGREE)).sum())
        self._weigh(chosen)
        chosen = self._solved(chosen, whole, None, 40)
        return self._judged(chosen, agreed, len(ends))

    def _lowest(self, points: list[np.ndarray], rows: int, count: int) -> list[np.ndarray]:
        """Of many points those that fit the first rows best."""
        value = self._costs(points, rows)
        return [points[k] for k in np.argsort(value)[:count]]

    def _steps(self, random: np.random.Generator) -> np.ndarray:
        """A step to another start."""
        return FAR * (2 * random.random(len(self.scales)) - 1)

    def _weigh(self, inside: np.ndarray) -> None:
        """Weighs each kind of measurement by its own noise."""
        if len(self.weights) > 1:
            for group, (off, _) in self.observation.predicted(self._outside(inside)).items():
                given = off[np.isfinite(off)]
                self.weights[group] = 1 / max(float(np.sqrt(np.mean(given**2))), 1e-12)
            self._known = None

    def _neighbours(self, inside: np.ndarray) -> float:
        """The largest correlation between neighbouring residuals, in standard errors of that of noise."""
        worst = 0.0
        for off, _ in self.observation.predicted(self._outside(inside)).values():
            for part in off.T:
                r = part[np.isfinite(part)]
                if len(r) > 10 and (r**2).sum() > 0:
                    worst = max(worst, float((r[1:] * r[:-1]).sum() / (r**2).sum() * np.sqrt(len(r))))
        return worst

    def _is_noise(self, inside: np.ndarray) -> bool:
        return self._neighbours(inside) < NOISY

    # --- what it says -------------------------------------------------------------------------------------------------

    def _judged(self, inside: np.ndarray, agreed: int, tried: int) -> Fit:
        from scipy.stats import t as student

        whole = len(self.observation.t)
        residual, jacobian = self._at(inside, whole)
        weight = _weight(self.loss, residual)
        free = len(inside)
        values = self._outside(inside)
        variance = float((weight * residual**2).sum() / max(weight.sum() - free, 1))
        sizes = np.sqrt((jacobian**2 * weight[:, None]).sum(axis=0))
        scaled = jacobian * np.sqrt(weight)[:, None] / np.where(sizes > 0, sizes, 1)
        _, singular, ways = np.linalg.svd(scaled, full_matrices=False)
        safe = np.maximum(singular, 1e-12)
        covariance = (ways.T / safe**2) @ ways * variance / np.outer(sizes, sizes)
        sigma = np.sqrt(np.diag(covariance))
        correlations = covariance / np.outer(sigma, sigma)
        quantile = float(student.ppf(QUANTILE, max(len(residual) - free, 1)))
        estimates = {}
        for name, scale, u, s in zip(self.begin, self.scales, inside, sigma, strict=True):
            value = scale.outside(u)
            low, high = (scale.outside(u + sign * quantile * s) for sign in (-1, 1))
            estimates[name] = Estimate(value, float(s * scale.slope(value)), low, high)
        parts = {group: off for group, (off, _) in self.observation.predicted(values).items()}
        noise = {group: float(np.sqrt(np.nanmean(off**2))) for group, off in parts.items()}
        reasons = self._reasons(inside, estimates, sigma, correlations)
        if tried > 1 and agreed < 2:
            reasons.append(f"only one of {tried} starts led here: a better fit may be elsewhere.")
        converged = not reasons
        reasons.insert(0, "the numbers fit: what is left is noise." if converged else "the fit must be read with care:")
        return Fit(estimates, correlations, converged, reasons, parts, noise, self.observation.t, self.evaluations)

    def _reasons(self, inside: np.ndarray, estimates: dict, sigma: np.ndarray, correlations: np.ndarray) -> list[str]:
        """Sentences on what keeps the numbers from being decided."""
        reasons, names = [], list(estimates)
        for name, scale, u, s in zip(names, self.scales, inside, sigma, strict=True):
            for side, limit in (("lowest", scale.low), ("highest", scale.high)):
                if np.isfinite(limit) and abs(u - limit) <= 1e-6 * max(1.0, abs(limit)):
                    reasons.append(f"`{name}` ran into its {side} value, {scale.outside(limit):.6g}.")
            if (scale.logarithmic and s > 1) or (not scale.logarithmic and s > max(1.0, abs(u))):
                reasons.append(f"the data cannot decide `{name}`: its standard error is as large as itself.")
        for i in range(len(names)):
            for j in range(i):
                if abs(correlations[i, j]) > SAME:
                    reasons.append(
                        f"`{names[j]}` and `{names[i]}` cannot be distinguished: correlation {correlations[i, j]:.4f}."
                    )
        excess = self._neighbours(inside)
        if excess >= NOISY:
            reasons.append(
                f"the residuals are no noise (neighbours agree, {excess:.0f} standard errors): the model, or a start, "
                "is missing something."
            )
        return reasons


def _weight(loss: str, residual: np.ndarray) -> np.ndarray:
    """The weight of each residual in a robust fit."""
    scale = max(float(np.median(np.abs(residual))), 1e-300)
    z = (residual / scale) ** 2
    weights: dict[str, Callable[[], np.ndarray]] = {
        "linear": lambda: np.ones_like(z),
        "soft_l1": lambda: 1 / np.sqrt(1 + z),
        "huber": lambda: np.where(z <= 1, 1.0, 1 / np.sqrt(np.maximum(z, 1))),
        "cauchy": lambda: 1 / (1 + z),
    }
    return weights[loss]()


def names_of(text: str | Sequence[str]) -> tuple[str, ...]:
    """Names of free numbers, of a text with commas or a list. Raises InputError."""
    names = [part.strip() for part in text.split(",")] if isinstance(text, str) else list(text)
    if not names or not all(isinstance(name, str) and name for name in names):
        raise InputError(["the free numbers must be names such as friction.mu, parameters.I1, but none is given."])
    return tuple(names)
