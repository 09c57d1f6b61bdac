"""`tippetop reconstruct`: theta(t) of a stored run by the main equation."""

from __future__ import annotations

from .streams import print_json
from .values import Place, Seconds


def reconstruct(
    store: Place,
    *,
    period: Seconds | None = None,
    as_json: bool = False,
) -> int:
    """Solve the main equation for theta(t) by D(t) or L_z(t) and E~(t) of a run; compare with it.

    Parameters
    ----------
    store
        A run of a tippe top or a heavy top that starts at a turning angle, with some hundred rows
        per nutation.
    period
        A guess of the period of nutation [s, or with a unit: 80ms]; by default twice the first
        turning time of the run.
    as_json
        Print the result as one JSON object.
    """
    import numpy as np

    from ..awaiting import awaited
    from ..errors import InputError
    from ..library import running, theory
    from ..library.stored_run import StoredRun
    from . import text

    run = running.open(store)
    if not isinstance(run, StoredRun):
        raise InputError(f"`{store}` must be the store of a run, but is not.")
    # theta is NaN after the time at which the reconstruction ends
    result = awaited(
        lambda: theory.reconstruct(run, period=period),
        "solving the main equation, from one turning to the next",
    )
    difference = np.abs(result["theta"].values - run.trajectory["theta"].values)
    found = difference[np.isfinite(difference)]
    report = {
        "turnings": result.sizes["turning"],
        "rows": found.size,
        "rows_of_run": difference.size,
        "difference": float(found.max()) if found.size else None,
        "mismatch": float(result.attrs["mismatch"]),
    }
    if as_json:
        return print_json(report)
    text.table(
        [
            ("turnings", f"{report['turnings']}"),
            ("rows", f"{found.size} of {difference.size}"),
            ("difference", f"{report['difference'] or 0:.2g} rad at most from theta of the run"),
            ("mismatch", f"{report['mismatch']:.2g} of cos(theta) where pieces meet"),
        ]
    )
    return 0
