"""Generated plans of sweeps: what can be runs to its end with a row for every top, what cannot is
refused in sentences.

A plan varies a random scenario along random axes (listed, spaced, drawn; keys of the scenario and
derived ones), with random chunks, kept columns and tops that are run alone; of two in five tippe
tops the contact opens and closes; two in three plans are then distorted or garbled as in
`scenarios`. `check --json` and `sweep` must agree. A sweep that ends with 0 must hold as many rows
as the plan has tops, none to be done, and in every row of a valid top an end within its time; the
same command again must change no byte; one valid top is run alone, and must end as its row says:
the same status, its last theta within its own measured sensitivity.

What it cannot see: sweeps of more than some dozen tops, of many machines, and what both the lanes
and the single run have in common.
"""

import json
import os
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import bodies
import nonsense
import numpy as np
from forking import command, forked
from verdict import Verdict, difference, files


COUNT = 500
PAIRS = (
    *(
        ("tippe-top", "viscous"),
        ("tippe-top", "coulomb"),
        ("rolling-tippe-top", ""),
        ("heavy-top", ""),
    ),
    ("gliding-heavy-top", "viscous"),
)  # lanes of each compile for half a minute
MOST = 48  # tops
VARIED = ("e_n", "r", "h")  # of a contact
OPENING = 0.4  # of the plans of tippe tops: their contact may open
ROUNDING = 1e-15  # relative: of a lane's rounding a step
NUDGES = (
    1e-15,
    1e-10,
)  # relative: of the start, whose effect is measured: of rounding itself, and of the flow


def prepare(folder: Path, count: int, first: int) -> dict[str, Any]:
    """Compiles the lanes of each system and law, two at a time, so that no case waits for that."""
    pairs = PAIRS if count > 20 or first else PAIRS[3:4]
    warm(
        pairs[0], folder
    )  # what the others share is compiled here, what is their own is found on the disk
    begun = [forked(partial(warm, pair, folder)) for pair in pairs[1:]]
    for pid, result in begun:
        result.recv()
        os.waitpid(pid, 0)
    return {"pairs": pairs}


def warm(pair: tuple[str, str], folder: Path) -> None:
    """Runs a sweep of two tops."""
    tables = plan(np.random.default_rng(1), pair) | {
        "axis": [{"of": "initial.theta", "values": [0.3, 0.4]}]
    }
    place = folder / f"{'-'.join(pair)}.toml"
    tables.pop("sample", None)
    place.write_text(nonsense.text_of(tables))
    done = command("sweep", place, "--out", place.with_suffix(".zarr"), "--workers", 1)
    assert done.code == 0, done.err


def plan(rng: np.random.Generator, pair: tuple[str, str]) -> dict[str, Any]:
    """The tables of a plan that should be right."""
    from tippetop.mechanics.systems import SYSTEMS as RECORDS

    fastest = bodies.spread(rng, 10.0, 600.0)
    base = bodies.scenario(rng, pair, scale=5.0, fastest=fastest) | {"form": "vector"}
    if pair[0] == "tippe-top" and rng.random() < OPENING:
        base = bodies.opening(base, rng)
    rates = [abs(v) for name, v in base["initial"].items() if name.endswith(("dot", "omega3"))]
    base["run"] = {"until": 150.0 / max([30.0, *rates]) * float(rng.uniform(0.1, 1.0))}
    numbers = {
        f"{table}.{k}": v for table in ("parameters", "initial") for k, v in base[table].items()
    }
    numbers |= {f"friction.{k}": v for k, v in base.get("friction", {}).items() if k != "law"}
    numbers |= {
        f"{table}.{k}": v
        for table in ("contact", "stem")
        for k, v in base.get(table, {}).items()
        if k in VARIED
    }
    keys = list(rng.choice(sorted(numbers), size=int(rng.integers(1, 4)), replace=False))
    if (
        rng.random() < 0.15
        and "inverts" in dir(RECORDS[base["system"]])
        and RECORDS[base["system"]].inverts
    ):
        keys.append(str(rng.choice(["sigma", "gamma", "lambda"])))
    sampled, axes = rng.random() < 0.3, []
    for key in map(str, keys):
        middle = numbers.get(key, 1.0)
        low, high = sorted((0.8 * middle, 1.2 * middle))
        ways = [{"between": [low, high]}] if sampled else []
        ways += [
            {"values": [low, middle, high]},
            {"linspace": [low, high], "n": int(rng.integers(1, 5))},
        ]
        ways += (
            [{"geomspace": [low, high] if low > 0 else [high, low], "n": 3}]
            if low * high > 0
            else []
        )
        axes.append({"of": key, **(ways[0] if sampled else ways[int(rng.integers(len(ways)))])})
    tables: dict[str, Any] = {"scenario": base, "axis": axes}
    if sampled:
        method = str(rng.choice(["random", "sobol", "latin-hypercube"]))
        tables["sample"] = {
            "method": method,
            "n": int(2 ** rng.integers(0, 5)),
            "seed": int(rng.integers(100)),
        }
    if rng.random() < 0.5:
        tables["chunk"] = int(rng.integers(1, 20))
    if rng.random() < 0.2:
        tables["keep"] = [["t_end", "theta_min"], ["final_state"], ["drift", "t_end"], []][
            int(rng.integers(4))
        ]
    if rng.random() < 0.15:
        tables["runs"] = [0]
    return tables


def attack(
    number: int, rng: np.random.Generator, folder: Path, prepared: dict[str, Any]
) -> Verdict:
    """Checks and runs one plan."""
    tables = plan(rng, prepared["pairs"][number % len(prepared["pairs"])])
    way = int(rng.integers(3))
    said = nonsense.distort(tables, rng) if way == 1 else []
    text = nonsense.text_of(tables)
    content = nonsense.garbled(text, rng) if way == 2 else text.encode(errors="replace")
    (folder / "PLAN.toml").write_bytes(content)
    verdict = _judged(folder, rng)
    verdict.repeat = {"plan": content.decode(errors="replace")[:6000], "said": said}
    return verdict


def _judged(folder: Path, rng: np.random.Generator) -> Verdict:
    place, store = folder / "PLAN.toml", folder / "S.zarr"
    checked = command("check", place, "--json")
    if fault := checked.fault((0, 2)):
        return fault
    facts = json.loads(checked.out) if checked.code == 0 else {}
    if facts and "tops" not in facts:  # without its axes it is a scenario
        return Verdict("refused", "not a plan any more")
    if facts and (facts["tops"] > MOST or facts["expected"]["core_seconds"] > 5):
        return Verdict("same", f"not run: {facts['tops']} tops, {facts['expected']}")
    words = ["sweep", place, "--out", store, "--workers", 1, "--json"]
    ran = command(*words)
    if fault := ran.fault((0, 2, 6)):
        return fault
    if checked.code == 2 or ran.code == 2:
        if checked.code != ran.code:
            return Verdict(
                "wrong",
                f"check says {checked.code} {checked.err[-400:]}, sweep {ran.code} "
                f"{ran.err[-400:]}",
            )
        return Verdict("refused", checked.err[-300:])
    if ran.code == 6:
        return Verdict("traceback", f"a chunk failed: {ran.err[-600:]}")
    before = files(store)
    again = command(*words)
    if fault := again.fault((0,)):
        return fault
    if differ := difference(files(store), before):
        return Verdict("wrong", f"the same command again: {differ}")
    return _rows(store, place, facts["tops"], rng)


def _rows(store: Path, place: Path, tops: int, rng: np.random.Generator) -> Verdict:
    """Compares the rows with the plan, and one with a run of that top alone."""
    import tippetop
    from tippetop.engine.status import Status
    from tippetop.sweeps.plan import Plan

    table, checked = tippetop.open(store), Plan.from_toml(place)
    status = table["status"].values
    if len(status) != tops or (status == Status.TODO.code).any():
        return Verdict(
            "wrong",
            f"{len(status)} rows for {tops} tops, {(status == Status.TODO.code).sum()} to be done",
        )
    until = np.array(
        [
            checked.columns(np.array([t])).get("run.until", [checked.base.until])[0]
            for t in range(tops)
        ]
    )
    ran = status != Status.INVALID.code
    if "t_end" in table and not np.all(table["t_end"].values[ran] <= until[ran]):
        return Verdict("wrong", "a top ends after its time")
    if not ran.any() or "theta_end" not in table:
        return Verdict("same")
    if "theta" not in checked.base.initial:
        return Verdict("same", "without theta none can be nudged")
    top = int(rng.choice(np.flatnonzero(ran)))
    return _alone(checked, top, float(table["theta_end"][top]), int(status[top]))


def _alone(checked: Any, top: int, theta: float, status: int) -> Verdict:
    """Compares a row with a run of its top alone."""
    import dataclasses

    from tippetop.runs.run import solve

    problem = dataclasses.replace(checked.problem(top), orientation=False)
    theta_0 = problem.initial["theta"]
    starts = [problem.initial | {"theta": theta_0 * (1 + nudge)} for nudge in (0.0, *NUDGES)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        one, *others = (
            solve(dataclasses.replace(problem, initial=start), keep=False) for start in starts
        )
    if one.status.code != status:
        return Verdict("wrong", f"top {top} alone is {one.status.value}, its row says {status}")
    mine = one.report["theta_end"]
    effects = [abs(other.report["theta_end"] - mine) for other in others]
    allowed = 1e-11 + 1e3 * max(effects[0] / 10, ROUNDING / NUDGES[1] * effects[1])
    if not abs(mine - theta) <= allowed:
        return Verdict(
            "wrong",
            f"top {top} alone ends at theta {mine}, its row at {theta}: more than {allowed:.1e} "
            "apart",
        )
    return Verdict("same")
