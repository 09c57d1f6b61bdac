"""Run exported cases in contact engines: `python -m bench.simulators DIR OUT [--engine NAME]...`.

DIR is a folder of `tippetop benchmark export`. Of each engine its defaults and the best that its
manual offers are run with several steps while the contact model is fixed; `--scan` then varies the
contact model at one small step. OUT/ENGINE/SETTING/CASE/dt=STEP.csv are the results:
`tippetop benchmark score OUT` compares them with the references.
"""

import argparse
import importlib
import itertools
import json
import time
from pathlib import Path

import numpy as np

from .case import Case, read


ENGINES = ("mujoco", "pybullet", "drake", "dart", "newton", "genesis")
STEPS = (1e-3, 5e-4, 2.5e-4)
SCANNED = ("mujoco-tutorial", "coulomb-sticking", "stem-landing", "rocking-cylinder")
LACKS = {"has_viscous_friction": "no viscous friction"}
"""What no engine expresses: a property of a case that is not zero, and the reason."""
ROWS = 2000
HEADER = "t [s],x [m],y [m],z [m],q_w,q_x,q_y,q_z,vx [m/s],vy [m/s],vz [m/s]"
HEADER += "".join(f",omega_{axis} [rad/s]" for axis in "xyz")
HEADER += "".join(f",force_{axis} [N]" for axis in "xyz")


def table(case: Case, rows: np.ndarray, step: float) -> np.ndarray:
    """Return the rows of a result: the force follows from the change of momentum."""
    force = case.mass * np.gradient(rows[:, 7:10], step, axis=0)
    force[:, 2] += case.mass * case.gravity
    times = step * np.arange(len(rows))
    every = max(1, len(rows) // ROWS)
    return np.column_stack([times, rows, force])[::every]


def run(engine, case: Case, setting: dict, step: float, path: Path, limit: float) -> str:
    """Write one result; return a line on how it went."""
    count = round(case.until / step) + 1
    began, rows = time.monotonic(), []
    motion = engine.motion(case, setting, step)
    for row in itertools.islice(motion, count):
        if not np.isfinite(row).all():
            break
        rows.append(row)
        if len(rows) == 2:
            began = time.monotonic()  # the first step may compile
        if time.monotonic() - began > limit:
            break
    motion.close()
    if len(rows) < 3:
        return "not finite"
    start = [case.position, case.quaternion, case.velocity, case.omega]
    np.testing.assert_allclose(rows[0], np.concatenate(start), rtol=1e-5, atol=1e-6)
    path.parent.mkdir(parents=True, exist_ok=True)
    made = table(case, np.array(rows), step)
    np.savetxt(path, made, delimiter=",", header=HEADER, comments="", fmt="%.12g")
    ended = "" if len(rows) == count else f", to t = {len(rows) * step:.4g} s only"
    return f"{time.monotonic() - began:.1f} s{ended}"


def main() -> None:
    """Run the cases in the engines that are installed."""
    parser = argparse.ArgumentParser(prog="python -m bench.simulators", description=__doc__)
    parser.add_argument("exported", type=Path, metavar="DIR")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--engine", action="append", choices=ENGINES)
    parser.add_argument("--case", action="append")
    parser.add_argument(
        "--step", action="append", type=float, help="[s]; by default 1e-3 to 2.5e-4"
    )
    parser.add_argument("--limit", type=float, default=1800.0, help="wall time of one result [s]")
    parser.add_argument("--scan", action="store_true", help="vary the contact model instead")
    given = parser.parse_args()
    cases = [
        read(path.parent)
        for path in sorted(given.exported.glob("*/case.json"))
        if not given.case or path.parent.name in given.case
        if json.loads(path.read_text())["body"]["outline"] is None  # adapters make balls
    ]
    for name in given.engine or ENGINES:
        engine = importlib.import_module(f".{name}", __package__)
        settings, lacks = engine.SETTINGS, LACKS | engine.LACKS
        if given.scan:
            key, values = engine.SCAN
            settings = {f"{key}={value:g}": {**settings["best"], key: value} for value in values}
        reasons = {}
        for setting, case in itertools.product(settings, cases):
            if lacking := [why for quality, why in lacks.items() if getattr(case, quality)]:
                reasons[case.name] = lacking[0]
                continue
            if given.scan and not given.case and case.name not in SCANNED:
                continue
            for step in given.step or (STEPS[-1:] if given.scan else STEPS):
                path = given.out / name / setting / case.name / f"dt={step:g}.csv"
                try:
                    done = run(engine, case, settings[setting], step, path, given.limit)
                except Exception as error:  # of whatever an engine raises the next case is free
                    done = f"{type(error).__name__}: {error}"
                print(f"{path}: {done}", flush=True)
        if reasons:
            print(f"{name} cannot: {json.dumps(reasons)}")


if __name__ == "__main__":
    main()
