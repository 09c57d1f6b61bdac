"""Compute columns of many tops at given times.

`exchange.predictions` calls it for the motions of a fit.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from ..columns import Arrays
from ..engine.instruments import INSTRUMENTS, instruments_of
from ..engine.observables import orientations_of, sources, values_of
from ..mechanics.units import SECOND
from ..problem import Problems
from .ensemble import measure
from .lanes import MOST_STEPS
from .outcomes import QUIET


@QUIET
def rows_at_times(
    tops: Problems,
    times: np.ndarray,
    names: Collection[str],
    *,
    threads: int | None = None,
    most: int = MOST_STEPS,
) -> Arrays:
    """Return columns of tops at given times.

    Parameters
    ----------
    tops
        The tops, made by `vary`, with orientation if `psi` or `orientation` is wanted.
    times
        [s], ascending, common to all tops (k,) or those of each (n, k). A top runs until the last
        of them; if no time is positive, until the end in its scenario.
    names
        Of columns of runs, such as `theta` and `axis`, and of INSTRUMENTS in smooth motion, with
        orientation.
    threads, most
        As for `measure`.

    Returns
    -------
    dict
        name -> (n, k) or (n, k, parts), SI; NaN before the start, after the end of a top that ended
        earlier, and of an invalid top.
    """
    times = np.broadcast_to(np.asarray(times, float), (tops.n, np.shape(times)[-1]))
    last = times[:, -1]
    until = np.where(last > 0, last, tops.given("run")["until"])
    tops = replace(tops, columns={**tops.columns, "run.until": until})
    internal = times / tops.unit(SECOND)[:, None]
    measured = measure(tops, threads=threads, wanted=(), times=internal, most=most)

    # formulas take one state for each top and time; other rows stay NaN
    top, row = np.nonzero(np.isfinite(measured.rows).all(axis=2))
    states = measured.rows[top, row].T
    values = values_of(tops, states, top)
    if tops.orientation:
        values |= orientations_of(tops, states, top)
    columns = {}
    known = sources(replace(tops.base, columns=tuple(names)))
    if further := {name: INSTRUMENTS[name] for name in names if name in INSTRUMENTS.keys() - known}:
        values |= instruments_of(tops, states, top)
    for name, source in (known | further).items():
        parts = np.stack([values[part] for part in source.parts], axis=1)
        whole = np.full((*times.shape, len(source.parts)), np.nan)
        whole[top, row] = parts * tops.unit(source.unit)[top, None]
        columns[name] = whole if source.dims else whole[..., 0]
    return columns
