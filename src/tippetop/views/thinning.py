"""Which samples a page keeps: those between which the interpolated attitude stays close to that of
all others.
"""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion
from .samples import OMEGA, ORIENTATION


WITHIN = np.radians(
    0.1
)  # of attitude that leaving out a row may cost; rows themselves add what lies between them
FEW = 20_000  # samples that are kept whatever they are


def attitude(
    p: np.ndarray, wp: np.ndarray, q: np.ndarray, wq: np.ndarray, h: np.ndarray, s: np.ndarray
) -> np.ndarray:
    """Attitudes (n, 4) at the fraction s of intervals of length h, between p and q (n, 4) with the
    angular velocities wp and wq (n, 3).
    """
    first, last = ((Quaternion(*a.T), Vector(*w.T)) for a, w in ((p, wp), (q, wq)))
    return np.stack(rotation.between(*first, *last, h, s), axis=1)


def apart(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The angles (n,) by which attitudes differ [rad]."""
    off = rotation.after(Quaternion(*p.T), rotation.inverse(Quaternion(*q.T)))
    return 2 * np.arctan2(np.sqrt(off.x**2 + off.y**2 + off.z**2), np.abs(off.w))


def kept(times: np.ndarray, samples: np.ndarray, enough: int = FEW) -> np.ndarray:
    """Indices of the samples to keep, ascending, the first and the last among them: all, where they
    are few; else every so manieth, and more where the attitude of the others asks for it.
    """
    n = len(times)
    if n <= enough:
        return np.arange(n)
    keep = np.unique(np.append(np.arange(0, n, max(2, n // enough)), n - 1))
    while True:
        wrong = missed(times, samples, keep) > WITHIN
        more = np.unique((keep[:-1][wrong] + keep[1:][wrong]) // 2)
        if not wrong.any():
            return keep
        keep = np.union1d(keep, more)


def missed(times: np.ndarray, samples: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """The largest angle, in each interval between samples that are kept, by which the attitude of
    another is missed.
    """
    left_out = np.setdiff1d(np.arange(len(times)), keep, assume_unique=True)
    interval = np.searchsorted(keep, left_out) - 1
    a, b = keep[interval], keep[interval + 1]
    h = times[b] - times[a]
    ends = [samples[i][:, part] for i in (a, b) for part in (ORIENTATION, OMEGA)]
    between_ends = attitude(*ends, h, (times[left_out] - times[a]) / h)  # type: ignore[call-arg]
    worst = np.zeros(len(keep) - 1)
    np.maximum.at(worst, interval, apart(between_ends, samples[left_out][:, ORIENTATION]))
    return worst


def between(times: np.ndarray, samples: np.ndarray) -> float:
    """By how much the attitude between the rows themselves may be missed [rad]: an eighth of what
    is missed of every second row, if the others are kept; the cubics' error falls with the third
    power of the step or faster.
    """
    if len(times) < 5:
        return 0.0
    keep = np.unique(np.append(np.arange(0, len(times), 2), len(times) - 1))
    return float(missed(times, samples, keep).max()) / 8
