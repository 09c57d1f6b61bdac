"""Generated scenarios: what can be runs as it says, what cannot is refused in sentences, and
`check` knows which.

A scenario is made of a random system, form, body, law, start and [run], two in five of them with a
contact that sticks, opens and closes; two in three are then distorted (numbers at the ends of the
doubles, other types, missing and unknown keys) or garbled as text. `check --json` and a short `run
--json` must agree: both refuse with the same sentences and 2, or the run ends with 0, 3 or 4. Of a
run that ends with 0, the JSON must be whole, its times and numbers finite and in their ranges, and
every drift within the contract; one in four is stored, and `info --json` must say the same.

What it cannot see: whether a finished run is right beyond its own invariants (see the campaign
`extremes`), long runs, the wider precisions but for a few, input through Python instead of TOML,
and terminals.
"""

import json
import math
from pathlib import Path
from typing import Any

import bodies
import nonsense
import numpy as np
from forking import Done, command
from verdict import Verdict


COUNT = 2000
SECONDS = 20.0  # that a run may take, by `check`
STEPS = 400.0  # of the integrator that a run may take, roughly
OPENING = 0.4  # of the scenarios: their contact may open
STATUSES = {"finished", "liftoff", "fallen", "settled", "ended", "non-finite", "stalled"}


def prepare(_: Path, count: int, first: int) -> dict[str, Any]:
    """The systems that are drawn from; a few tries draw from those that compile in a second."""
    from tippetop.mechanics.systems import SYSTEMS

    return {
        "systems": sorted(SYSTEMS)
        if count > 20 or first
        else ["gliding-cylinder", "rolling-cylinder"]
    }


def run_table(rng: np.random.Generator, fastest: float) -> dict[str, Any]:
    """A [run] of some hundred steps; seldom with other options."""
    until = STEPS / max(fastest, 30.0) * float(rng.uniform(0.05, 1.0))
    table: dict[str, Any] = {"until": until}
    ways = rng.random(5)
    if ways[0] < 0.3:
        table["output_step"] = until / float(rng.integers(1, 400))
    elif ways[0] < 0.4:
        table["output_times"] = sorted(rng.uniform(0, until, 5).tolist())
    elif ways[0] < 0.5:
        table["output"] = str(rng.choice(["events", "steps"]))
    if ways[1] < 0.1:
        table["on_liftoff"] = "continue"
    if ways[2] < 0.03:
        table["stop_when"] = "settled"
    if ways[3] < 0.2:
        table["orientation"] = False
    if ways[4] < 0.02:
        table["tolerance"] = float(rng.choice([1e-12, 1e-9]))
    return table


def attack(
    number: int, rng: np.random.Generator, folder: Path, prepared: dict[str, Any]
) -> Verdict:
    """Checks and runs one scenario."""
    fastest = bodies.spread(rng, 1.0, 2000.0)
    tables = bodies.scenario(rng, (str(rng.choice(prepared["systems"])), ""), fastest=fastest)
    opens = rng.random() < OPENING
    if opens:
        tables = bodies.opening(tables, rng)
    rates = [abs(v) for name, v in tables["initial"].items() if name.endswith(("dot", "omega3"))]
    tables["run"] = run_table(rng, max([1.0, *rates]))
    if opens and tables["run"].get("on_liftoff") == "continue":
        tables["run"]["on_liftoff"] = str(rng.choice(["fly", "stop", "continue"]))
    way = int(rng.integers(3))
    said = nonsense.distort(tables, rng) if way == 1 else []
    text = nonsense.text_of(tables)
    content = nonsense.garbled(text, rng) if way == 2 else text.encode(errors="replace")
    place = folder / "scenario.toml"
    place.write_bytes(content)
    verdict = _judged(place, folder, stored=number % 4 == 0)
    verdict.repeat = {"scenario": content.decode(errors="replace")[:6000], "said": said}
    return verdict


def _judged(place: Path, folder: Path, *, stored: bool) -> Verdict:
    checked = command("check", place, "--json")
    if fault := checked.fault((0, 2)):
        return fault
    if too_long := _too_long(checked):
        return Verdict("same" if checked.code == 0 else "refused", too_long)
    out = ["--out", folder / "run.zarr"] if stored else []
    ran = command("run", place, "--json", *out)
    if fault := ran.fault((0, 2, 3, 4)):
        return fault
    if checked.code == ran.code == 2 and "is the plan of a sweep" in ran.err:
        return Verdict("refused", "not a scenario any more")
    if checked.code == 2 or ran.code == 2:
        if checked.code != ran.code or checked.sentences != ran.sentences:
            return Verdict(
                "wrong",
                f"check says {checked.code} {checked.err[-400:]}, run {ran.code} {ran.err[-400:]}",
            )
        return Verdict("refused", checked.err[-300:])
    if ran.code == 3:
        return Verdict("refused", ran.err[-300:])
    try:
        said = json.loads(ran.out)
    except ValueError:
        return Verdict("wrong", f"no JSON: {ran.out[:300]}")
    if faults := _faults(said, json.loads(checked.out), ran.code):
        return Verdict("wrong", "; ".join(faults))
    if stored:
        shown = command("info", folder / "run.zarr", "--json")
        if shown.fault((0,)) or (differ := _differ(json.loads(shown.out), said)):
            return shown.fault((0,)) or Verdict("wrong", f"info and run differ in {differ}")
    return Verdict("broken" if ran.code == 4 else "same", ran.err[-300:])


def _too_long(checked: Done) -> str:
    """Why a scenario is not run, if it would take more than seconds: as `check` says itself."""
    if checked.code:
        return ""
    facts = json.loads(checked.out)
    steps, run = facts["expected"]["steps"], facts["run"]
    wide = run["precision"] != "double" or run["tolerance"] not in (0.0, 1e-12, 1e-9)
    rows = run["until"] / run["output_step"] if "output_step" in run else 0.0
    seconds = facts["expected"]["seconds"]
    if steps > 1e5 or rows > 1e5 or wide or seconds > SECONDS:
        given = f"{run['precision']}, tolerance {run['tolerance']}"
        return f"not run: {steps} steps, {rows:.3g} rows, {seconds:.3g} s, {given}"
    return ""


def _faults(said: dict[str, Any], checked: dict[str, Any], code: int) -> list[str]:
    """What cannot be in the JSON of a run that ended with 0 or 4."""
    from tippetop.runs.certificate import MAX_DRIFT, MAX_DRIFT_DEFAULT

    faults = []
    if said["status"] not in STATUSES or said["status"] in ("non-finite", "stalled"):
        faults.append(f"status {said['status']}")
    until = checked["run"]["until"]
    if not 0 <= said["t_end"] <= until or (said["status"] == "finished" and said["t_end"] != until):
        faults.append(f"{said['status']} at {said['t_end']} of {until}")
    theta = said["theta_end"]
    if (
        theta is None
        or not math.isfinite(theta)
        or ("cylinder" not in checked["system"] and not 0 <= theta <= math.pi)
    ):
        faults.append(f"theta ends at {theta}")
    if code == 0 and not checked["run"]["tolerance"]:
        faults += [
            f"{name} drifts by {drift} and nothing is said"
            for name, drift in said["drift"].items()
            if drift is None or not drift <= MAX_DRIFT.get(name, MAX_DRIFT_DEFAULT)
        ]
    for table in ("parameters", "initial", "friction"):
        if said.get(table) != checked.get(table):
            faults.append(f"{table} of the run are not those of the check")
    return faults


def _differ(shown: dict[str, Any], said: dict[str, Any]) -> list[str]:
    return [
        key
        for key in said
        if key in shown and shown[key] != said[key] and key not in ("seconds", "store")
    ]
