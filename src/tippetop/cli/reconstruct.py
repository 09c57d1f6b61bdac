"""`tippetop reconstruct`: theta(t) of a stored run by the main equation."""

from __future__ import annotations

from .streams import print_json
from .values import Place, Seconds


def reconstruct(
    store: Place,
    *,
    period: Seconds | None = None,
    out: Place | None = None,
    overwrite: bool = False,
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
    out
        Write time, theta of the main equation and theta of the run to this CSV file.
    overwrite
        Replace an existing file.
    as_json
        Print the result as one JSON object.
    """
    import numpy as np

    from ..awaiting import awaited
    from ..errors import InputError
    from ..landscape.reconstruction import reconstruction
    from ..scenario import build
    from ..store import files, root
    from . import text

    attrs = root.attributes(store)
    if "content" in attrs:
        raise InputError(f"a run is reconstructed, but `{store}` is a {attrs['content']}.")
    if period is not None and period <= 0:
        raise InputError(f"--period must be positive and finite, but is {period}.")
    rows, events = (
        root.loaded(root.open_group(store, name), store) for name in ("trajectory", "events")
    )
    result = awaited(
        lambda: reconstruction(build.stored(attrs), rows, events, period),
        "solving the main equation, from one turning to the next",
    )
    difference = np.abs(result["theta"].values - rows["theta"].values)
    found = difference[np.isfinite(difference)]
    report = {
        "turnings": int(result.sizes["turning"]),
        "rows": found.size,
        "rows_of_run": int(rows.sizes["time"]),
        "difference": float(found.max()) if found.size else None,
        "mismatch": float(result.attrs["mismatch"]),
    }
    if out is not None:
        table = np.column_stack([rows["time"].values, result["theta"].values, rows["theta"].values])
        with files.writing(out), files.replacing(out, overwrite=overwrite) as scratch:
            header = "time [s],theta by the main equation [rad],theta of the run [rad]"
            np.savetxt(scratch, table, "%.17g", ",", header=header, comments="")
    if as_json:
        return print_json(report)
    lines = [
        ("turnings", f"{report['turnings']}"),
        ("rows", f"{found.size} of {report['rows_of_run']}"),
        ("difference", f"{report['difference'] or 0:.2g} rad at most from theta of the run"),
        ("mismatch", f"{report['mismatch']:.2g} of cos(theta) where pieces meet"),
    ]
    text.table(lines if out is None else [*lines, ("file", str(out))])
    return 0
