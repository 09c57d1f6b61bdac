"""What a person reads: the summary of a run, and the progress bar in a terminal."""

from __future__ import annotations

import os
import sys
import time
from typing import Any

from rich.console import Console
from rich.table import Table


def console() -> Console:
    """Standard output; no colour when it is not a terminal."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else 160)


class Progress:
    """A bar on stderr while a run lasts longer than half a second; nothing when stderr is not a terminal."""

    def __init__(self, until: float):
        self.until, self.bar, self.task = until, None, None
        self.shown = sys.stderr.isatty() and not os.environ.get("TIPPETOP_QUIET")
        self.began = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, t: float, report: dict[str, Any]) -> None:
        """Called after every slice with the time reached [s]."""
        if not self.shown or time.monotonic() - self.began < 0.5:
            return
        if self.bar is None:
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("t = {task.completed:.4g} s"), BarColumn(), TextColumn("{task.fields[note]}"))
            self.bar = Bar(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task("", total=self.until, note="")
        drift = max(report["drift"].values(), default=0.0)
        note = f"{report['steps']} steps, {report['events']} events, drift {drift:.0e}"
        self.bar.update(self.task, completed=t, note=note)


def summary(headline: str, info: dict[str, Any], seconds: dict[str, float], places: dict[str, Any]) -> None:
    """Prints a run in a few lines."""
    out = console()
    out.print(headline, style="bold")
    table = Table.grid(padding=(0, 2))
    for name, text in lines(info, seconds):
        table.add_row(name, text)
    for name, place in places.items():
        if place is not None:
            table.add_row(name, str(place))
    out.print(table)


def lines(info: dict[str, Any], seconds: dict[str, float] | None = None) -> list[tuple[str, str]]:
    """Name and text of each line of a summary."""
    status = f"{info['reason']}, {info['steps']} steps"
    if seconds is not None:
        status += f"; integrated in {1e3 * seconds['integrate']:.1f} ms, compiled in {seconds['compile']:.2f} s"
    found = [("status", status)]
    if "theta_end" in info:
        found.append(("inversion", _inversion(info)))
    found.append(("turning angles", _turnings(info)))
    others = {k: n for k, n in info["event_counts"].items() if not k.startswith("turning")}
    if others:
        found.append(("other events", ", ".join(f"{n} {kind}" for kind, n in others.items())))
    if "normal_force" in info:
        force, weight = info["normal_force"], info["normal_force"]["weight"]
        low, high = (f if abs(f) > 1e-12 * weight else 0.0 for f in (force["min"], force["max"]))
        found.append(
            ("normal force", f"{low:.5g} to {high:.5g} N, that is {low / weight:.4f} to {high / weight:.4f} m g")
        )
    drift = ", ".join(f"{name.replace('_', ' ')} {value:.1e}" for name, value in info["drift"].items())
    found.append(("drift", f"{drift} (relative, worst of the run)"))
    return found


def _inversion(info: dict[str, Any]) -> str:
    inversion, end = info["inversion"], info["theta_end"]
    if inversion["inverted_at"] is not None:
        equator = f"theta = pi/2 at {inversion['first_equator']:.6f} s" if inversion["first_equator"] else "inverted"
        last = inversion["last_equator"]
        again = f" (last at {last:.6f} s)" if last != inversion["first_equator"] else ""
        return f"{equator}{again}, pi - 0.1 at {inversion['inverted_at']:.6f} s"
    if inversion["first_equator"] is not None:
        return f"theta = pi/2 at {inversion['first_equator']:.6f} s, not beyond pi - 0.1; theta ends at {end:.6g}"
    return f"none; theta ends at {end:.6g} rad"


def _turnings(info: dict[str, Any]) -> str:
    counts, band = info["event_counts"], info["nutational_band"]
    if not counts.get("turning"):
        return "none logged"
    noise = counts["turning"] - counts["turning_significant"]
    text = f"{counts['turning_significant']} logged"
    if band["theta_min"] is not None:
        text += f", theta between {band['theta_min']:.6g} and {band['theta_max']:.6g} rad"
    return text + (f"; {noise} more below the rounding floor" if noise else "")
