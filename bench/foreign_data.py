"""A fit of a motion that tippetop did not make: `python -m bench.foreign_data make FOLDER`, then
`... fit FOLDER`.

`make` draws the numbers of a heavy top by chance, lets MuJoCo (tippetop[peers]) step it, and writes
what a camera sees of it, FOLDER/film.csv; the numbers go to FOLDER/hidden.json, which `fit` reads
only after its fit is made, to say how far off that is. The fit begins at the preset, whose numbers
are up to 30 % away. A heavy top on a fixed tip is the one body whose law both programs share
exactly; under friction an engine's soft contact is another law than ours.
"""

from __future__ import annotations

import argparse
import json
import secrets
from pathlib import Path

import numpy as np

import tippetop as tt
from tippetop.exchange.simulators import text_of


FREE = ("parameters.I1", "initial.omega3", "initial.theta", "initial.phi_dot")
PRESET, BEGIN = "heavy-top", ["initial.phi_dot=1.0"]
OFF, UNTIL, STEP, EVERY = (
    0.3,
    5.0,
    1e-4,
    100,
)  # of the numbers; [s]; [s]; steps from one picture to the next
NOISE, MISSING = np.deg2rad(0.5), 0.2


def make(folder: Path) -> None:
    """Writes film.csv and hidden.json."""
    import mujoco

    random = np.random.default_rng(secrets.randbits(128))
    given = tt.load(PRESET, BEGIN)
    start = {**{f"parameters.{k}": v for k, v in given.parameters.items()},
             **{f"initial.{k}": v for k, v in given.initial.items()}}  # fmt: skip
    hidden = {name: float(start[name] * (1 + random.uniform(-OFF, OFF))) for name in FREE}
    problem = tt.load(PRESET, [f"{name}={value!r}" for name, value in hidden.items()])
    model = mujoco.MjModel.from_xml_string(text_of(problem, "mjcf"))
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rows = []
    for k in range(round(UNTIL / STEP)):
        if k % EVERY == 0:
            mujoco.mj_kinematics(model, data)
            rows.append([k * STEP, *data.xmat[1].reshape(3, 3)[:, 2]])
        mujoco.mj_step(model, data)
    t, axis = np.array(rows)[:, 0], np.array(rows)[:, 1:]
    seen = axis + np.cross(NOISE * random.standard_normal(axis.shape), axis)
    seen /= np.linalg.norm(seen, axis=1)[:, None]
    kept = random.random(len(t)) > MISSING
    folder.mkdir(parents=True, exist_ok=True)
    header = "t [s],axis_x,axis_y,axis_z"
    np.savetxt(
        folder / "film.csv",
        np.column_stack([t, seen])[kept],
        delimiter=",",
        header=header,
        comments="",
    )
    (folder / "hidden.json").write_text(json.dumps(hidden), encoding="utf-8")


def fit(folder: Path) -> None:
    """Fits film.csv, draws the figure, and only then looks at hidden.json."""
    result = tt.fit(folder / "film.csv", tt.load(PRESET, BEGIN), FREE)
    print(result)
    result.plot(folder / "fit.png", overwrite=True)
    hidden = json.loads((folder / "hidden.json").read_text(encoding="utf-8"))
    print(
        "\n| number | hidden | fitted | standard error | off, in standard errors |\n|"
        + " --- |" * 5
    )
    for name, e in result.estimates.items():
        off = (e.value - hidden[name]) / e.sigma
        print(f"| `{name}` | {hidden[name]:.6g} | {e.value:.6g} | {e.sigma:.2g} | {off:+.2f} |")


def main() -> None:
    """Makes the film, or fits it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["make", "fit"])
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    (make if given.what == "make" else fit)(given.folder)


if __name__ == "__main__":
    main()
