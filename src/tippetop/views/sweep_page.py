"""The page of a sweep: the map of its tops, and their motions, integrated in the page.

The path of a store goes in; the text of an HTML file comes out.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..columns import greek, units_text
from ..errors import InputError
from ..runs.shape import shape
from ..scenario import build
from ..sweeps import maps
from ..sweeps.design import Axis
from ..sweeps.plan import Plan
from ..sweeps.sweep_summary import open_sweep, plan_of
from . import pages
from .borders import borders
from .encoding import encode
from .phase_formulas import NO_PHASES, NO_POTENTIAL, contacts, is_movable, numbers_for_page


MOST = 100_000  # tops of a page
LINE = (
    "class",
    "theta_end",
    "t_end",
    "inverted_at",
    "first_equator",
    "lifted_at",
    "settled_at",
    "turnings",
    "theta_min",
    "theta_max",
    "normal_force_min",
    "normal_force_max",
    "drift_jellett",
    "drift_energy_balance",
)
"""Columns of a page, if the sweep kept them; the class first, by which the map is coloured."""


def page_of_sweep(path: Path) -> str:
    """Return the text of the HTML file of a stored sweep. Raises InputError, StoreError.

    sweep.js reads the names of its data.
    """
    table = open_sweep(path)
    plan = plan_of(table)
    if plan.n > MOST:
        raise InputError(
            f"a page must have at most {MOST} tops, but this sweep has {plan.n}: tippetop "
            "plot draws it."
        )
    tops = np.arange(plan.n)
    numbers = plan.design.numbers(tops)
    names = [name for name in LINE if name in table]
    if not names:
        raise InputError(
            f"a page must have one of {', '.join(LINE)}, but the plan kept none of them."
        )
    axes = sorted(plan.design.axes, key=lambda axis: not axis.varies)
    movable = is_movable(plan.base)
    about = f"{plan.n} tops; point at one for its line"
    notes = []
    if movable:
        about += ", click it for its motion"
    else:
        notes.append(
            "The page integrates tippe tops that slide; of these bodies it shows their map alone."
        )
    if table.attrs["status"] != "finished":
        notes.append("This sweep is not finished.")
    data = {
        "given": numbers_for_page(plan.base) | {"stops": plan.base.contact is None}
        if movable
        else None,
        "body": shape(build.resolved(plan.base)),
        "axes": [_axis(axis, numbers[axis.of], table[axis.of].attrs) for axis in axes],
        "columns": [
            _column(name, maps.values_of(path, table, name), table[name].attrs) for name in names
        ],
        "borders": borders(plan, axes, table),
        "changes": {key: encode(values, "<f8") for key, values in changes(plan, tops).items()},
        "notes": notes,
    }
    law = {plan.base.law.key: type(plan.base.friction)}
    scripts = NO_POTENTIAL | (contacts(law) if movable else NO_PHASES)
    heading = f"A sweep: {plan.base.system.title}"
    return pages.page(
        heading, "page_sweep.js", data, scripts, aside=pages.source("sweep.html"), about=about
    )


def changes(plan: Plan, tops: np.ndarray) -> dict[str, np.ndarray]:
    """Return the numbers in which tops differ, by dotted key, (tops,) each.

    They replace those of `numbers_for_page`, which has no psi': it becomes omega_3, as in
    `gliding.start_of`; a change of one is a change of both.
    """
    columns = {
        key: np.broadcast_to(values, tops.shape) for key, values in plan.columns(tops).items()
    }

    def number(name: str) -> Any:
        """Return a number of the start, SI: the varied one of each top (n,), or that of all."""
        return columns.get(f"initial.{name}", plan.base.initial.get(name, 0.0))

    if "initial.psi_dot" in columns or (
        "psi_dot" in plan.base.initial and "initial.omega3" not in columns
    ):
        spin = number("psi_dot") + number("phi_dot") * np.cos(number("theta"))
        columns["initial.omega3"] = np.broadcast_to(spin, tops.shape)
        columns.pop("initial.psi_dot", None)
    return columns


def _axis(axis: Axis, numbers: np.ndarray, attrs: dict[str, Any]) -> dict[str, Any]:
    """Return an axis of the sweep as map.js takes it; `numbers`: its value per top, (n,)."""
    log = axis.is_log and bool(np.nanmin(numbers) > 0)
    return {
        "key": axis.of,
        "label": maps.labelled(attrs),
        "log": log,
        "sampled": axis.sampled,
        "numbers": encode(numbers, "<f8"),
    }


def _column(name: str, values: np.ndarray, attrs: dict[str, Any]) -> dict[str, Any]:
    """Return a column as the page takes it: name, words, unit, and values in base64."""
    about: dict[str, Any] = {"name": name, "words": greek(attrs["long_name"]).partition(";")[0]}
    about["unit"] = "" if attrs["units"] == "1" else units_text(attrs["units"])
    if name == "class":
        about |= {"words": "class", "names": list(maps.SHOWN)}
    elif "flag_meanings" in attrs:
        about["names"] = attrs["flag_meanings"].split()
    return about | {"values": encode(values, "<f4")}
