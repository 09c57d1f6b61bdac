"""How far MuJoCo's tippe top is from the exact one: `python -m bench.contact_simulators`, with tippetop[peers].

Each scenario is exported as MJCF, stepped by MuJoCo with several steps and integrators, written as a table, and
compared. What MuJoCo is asked is what its own manual advises: elliptic cones, a contact as stiff as the step allows
(solref = 2 steps), impratio 10. It is a fair question for a contact engine, and one that it was not made for.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import tippetop as tt
from tippetop.exchange.simulators import text_of


STEPS = (1e-3, 5e-4, 2.5e-4)
INTEGRATORS = ("implicit", "RK4")
BODY = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 131 / 350 * 8e-6, "I3": 3.2e-6, "g": 9.82}
START = {"theta": 0.1, "omega3": 155.0, "centre_at_rest": True}
HEADER = "t [s]," + ",".join(
    ["q_w", "q_x", "q_y", "q_z", *(f"{c} [m]" for c in "xyz"), *(f"v{c} [m/s]" for c in "xyz")]
    + [f"omega_body_{c} [rad/s]" for c in "xyz"]
)


class Case(NamedTuple):
    """A question: a name, why it is asked, and the scenario's tables."""

    name: str
    why: str
    tables: dict[str, Any]


def _tables(friction: dict[str, Any], until: float, **more: Any) -> dict[str, Any]:
    initial = {**START, **more.pop("initial", {})}
    return {"system": "tippe-top", "parameters": BODY, "friction": friction, "initial": initial,
            "run": {"until": until}, **more}  # fmt: skip


CASES = (
    Case("flight", "no contact: the integrator alone", _tables(
        {"law": "coulomb", "mu": 0.3}, 0.1, initial={"gap": 0.08}, contact={})),
    Case("gliding", "contact without friction: nothing is lost", _tables({"law": "none"}, 1.0)),
    Case("coulomb", "contact with friction, exact Coulomb law", _tables({"law": "coulomb", "mu": 0.3}, 2.0)),
)  # fmt: skip


def stepped(text: str, step: float, integrator: str, until: float) -> np.ndarray:
    """Rows of a motion, (rows, 14): time, quaternion, place, velocity, angular velocity in body axes."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.geom_solref[:, 0], model.geom_solref[:, 1] = 2 * step, 1.0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rows = []
    count = round(until / step)
    for k in range(count + 1):
        if k % max(1, count // 1000) == 0:
            rows.append([k * step, *data.qpos[3:], *data.qpos[:3], *data.qvel])
        mujoco.mj_step(model, data)
    return np.array(rows)


def answers(case: Case, folder: Path) -> dict[str, tt.Comparison]:
    """What MuJoCo makes of a case, by integrator."""
    problem = tt.load(_file(case, folder))
    text = text_of(problem, "mjcf")
    made = {}
    for integrator in INTEGRATORS:
        files = []
        for step in STEPS:
            path = folder / f"{case.name} {integrator} dt={step:g}.csv"
            rows = stepped(text, step, integrator, problem.until)
            np.savetxt(path, rows, delimiter=",", header=HEADER, comments="", fmt="%.17g")
            files.append(path)
        made[integrator] = tt.compare(files, problem)
    return made


def _file(case: Case, folder: Path) -> Path:
    lines = [f'system = "{case.tables["system"]}"']
    for name, table in case.tables.items():
        if isinstance(table, dict):
            lines += [f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    path = folder / f"{case.name}.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(float(value))


def table(made: dict[str, dict[str, tt.Comparison]]) -> str:
    """A Markdown table of all answers."""
    lines = [
        "| case | integrator | step [s] | attitude, largest error [rad] | leaves 1e-3, 1e-2, 1e-1 rad at [s] | "
        "theta, largest error [rad] | order | Jellett drift | energy drift | in the floor [m] |",
        "|" + " --- |" * 10,
    ]
    for name, by in made.items():
        for integrator, comparison in by.items():
            for i, motion in enumerate(comparison.motions):
                n = motion.numbers
                leaves = ", ".join("never" if t is None else f"{t:.3g}" for t in n["attitude"]["leaves"].values())
                order = f"{comparison.orders[i - 1].get('attitude', float('nan')):.2f}" if i else ""
                lines.append(
                    f"| {name} | {integrator} | {motion.step:g} | {n['attitude']['max']:.2g} | {leaves} | "
                    f"{n['theta']['max']:.2g} | {order} | {n['jellett_drift']:.1e} | {n['energy_drift']:.1e} | "
                    f"{n['contact']['penetration']:.1e} |"
                )
    return "\n".join(lines)


def main() -> None:
    """Prints the table; writes the figure of the case with friction."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figure", type=Path)
    figure = parser.parse_args().figure
    with tempfile.TemporaryDirectory() as name:
        made = {case.name: answers(case, Path(name)) for case in CASES}
        print(table(made))
        if figure is not None:
            made["coulomb"]["implicit"].plot(figure)


if __name__ == "__main__":
    main()
