"""Choice of the samples that a page keeps, so that the attitude between them stays accurate.

Times and samples go in; the indices of samples come out.

Symbols
    p, q      quaternions at the ends of an interval of length h; wp, wq: angular velocities there
    s         fraction of an interval, 0 to 1
"""

import numpy as np

from ..exchange.motion import angle_between
from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion
from .samples import OMEGA, ORIENTATION


# Largest error of the attitude by leaving out a row; rows themselves add their own
WITHIN = np.radians(0.1)
# Samples that are kept if there are as many
FEW = 20_000


def attitude(
    p: np.ndarray, wp: np.ndarray, q: np.ndarray, wq: np.ndarray, h: np.ndarray, s: np.ndarray
) -> np.ndarray:
    """Return attitudes (n, 4) at the fractions s (n,) of intervals of lengths h (n,) [s].

    The ends are unit quaternions p and q (n, 4), with the angular velocities wp and wq (n, 3) in
    space [rad/s].
    """
    first, last = ((Quaternion(*a.T), Vector(*w.T)) for a, w in ((p, wp), (q, wq)))
    return np.stack(rotation.between(*first, *last, h, s), axis=1)


def interpolated(times: np.ndarray, samples: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Return samples (k, channels) at the times `shown` (k,), from those at `times` (n,).

    `times` ascend [s]; attitudes by `attitude`, other channels linearly. motion.js does the same.
    """
    # without the ends, so that i is an interval, 0 to n - 2, for the last time too
    i = np.searchsorted(times[1:-1], shown, side="right")
    p = samples[i]
    q = samples[i + 1]
    h = times[i + 1] - times[i]
    s = (shown - times[i]) / h
    found = p + s[:, None] * (q - p)
    ends = [end[:, part] for end in (p, q) for part in (ORIENTATION, OMEGA)]
    found[:, ORIENTATION] = attitude(*ends, h, s)  # type: ignore[call-arg]
    return found


def chosen(times: np.ndarray, samples: np.ndarray, enough: int = FEW) -> np.ndarray:
    """Return the indices of evenly spaced samples, and of the last one.

    At least `enough`, and as many as the attitude of the others requires: its error, as the page
    interpolates it, is at most WITHIN.
    """
    n = len(times)
    step = max(1, n // enough)
    while True:
        keep = np.union1d(np.arange(0, n, step), n - 1)
        if step == 1 or missed(times, samples, keep) <= WITHIN:
            return keep
        step = (step + 1) // 2


def missed(times: np.ndarray, samples: np.ndarray, keep: np.ndarray) -> float:
    """Return the largest error of the attitude of the samples that are not kept [rad]."""
    left_out = np.setdiff1d(np.arange(len(times)), keep, assume_unique=True)
    known = interpolated(times[keep], samples[keep], times[left_out])
    angles = angle_between(known[:, ORIENTATION], samples[left_out][:, ORIENTATION])
    return float(angles.max(initial=0.0))


def row_error(times: np.ndarray, samples: np.ndarray) -> float:
    """Estimate the error of the attitude between the rows themselves [rad].

    It is an eighth of that of every second row if only the others were kept: the error of cubics
    falls with the third power of the step or faster.
    """
    if len(times) < 5:
        return 0.0
    return missed(times, samples, np.union1d(np.arange(0, len(times), 2), len(times) - 1)) / 8
