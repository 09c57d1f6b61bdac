"""Write the cases of the committed results: `python -m bench.simulators.export DIR`.

Of each case the scenario, the MJCF, and of the reference the start and the end, as the adapters
read them. `tippetop benchmark export` writes the same names with complete references.
"""

import sys
from pathlib import Path

import numpy as np

import tippetop as tt
from tippetop.exchange.simulators import start_of, text_of
from tippetop.mechanics.operand import Vector
from tippetop.mechanics.rotation import Quaternion, rotated


BODY = """system = "tippe-top"
[parameters]
m = 0.02
R = 0.02
alpha = 0.3
I1 = 2.994285714285714e-6
I3 = 3.2e-6
g = 9.82
[friction]
law = "coulomb"
mu = 0.3
"""
SPUN = "[initial]\ntheta = 0.1\nomega3 = 155.0\ncentre_at_rest = true\n"
CASES = {
    "torque-free": BODY
    + "[contact]\n"
    + SPUN
    + "theta_dot = 20.0\ngap = 0.08\n[run]\nuntil = 0.1\n",
    "slide-to-roll": BODY + "[initial]\nnu_x = 0.5\nnu_y = 0.0\n[run]\nuntil = 0.3\n",
    "frictionless-gliding": BODY.replace('"coulomb"\nmu = 0.3', '"none"')
    + SPUN
    + "[run]\nuntil = 1.0\n",
    "coulomb-sticking": BODY + SPUN + "[run]\nuntil = 2.0\n",
    "bounce": BODY
    + "[contact]\ne_n = 0.5\n[initial]\ntheta = 0.3\nomega3 = 0.0\ngap = 0.01\n"
    + "[run]\nuntil = 0.3\n",
    "spinning-drop": BODY
    + "[contact]\n"
    + SPUN.replace("0.1", "0.5")
    + "gap = 0.01\n[run]\nuntil = 0.3\n",
} | {
    name: tt.presets()[preset]
    for name, preset in (
        ("mujoco-tutorial", "mujoco-tutorial"),
        ("stem-landing", "leine-glocker-stem"),
        ("drilling-friction", "leine-glocker-drilling"),
        ("wooden-toy", "wooden-toy"),
        ("hopping", "flying"),
        ("joint", "exudyn-heavy-top"),
    )
}
HEADER = "t [s],x [m],y [m],z [m],q_w,q_x,q_y,q_z,vx [m/s],vy [m/s],vz [m/s]"
HEADER += "".join(f",omega_{axis} [rad/s]" for axis in "xyz")


def write(folder: Path, name: str, text: str) -> None:
    """Write one case."""
    folder = folder / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scenario.toml").write_text(text, encoding="utf-8")
    problem = tt.load(folder / "scenario.toml")
    (folder / "model.mjcf.xml").write_text(text_of(problem, "mjcf"), encoding="utf-8")
    start = start_of(problem)
    turned = Quaternion(*start.quaternion)
    omega = rotated(turned, Vector(*start.omega))
    state = np.concatenate([start.place, turned, start.velocity, omega])
    rows = [[time, *state] for time in (0.0, problem.until)]
    np.savetxt(folder / "reference.csv", rows, delimiter=",", header=HEADER, comments="")


if __name__ == "__main__":
    for name, text in CASES.items():
        write(Path(sys.argv[1]), name, text)
