"""MuJoCo's soft contact as a viscous friction [s/m]: `python -m bench.simulators.soft_contact`.

Within the friction cone MuJoCo solves F = -(B v + J dw/dt)/R for the force on a contact that slips
with v. B = 2/(dmax timeconst); R = (1 - d)/(d m) of an elliptic cone, divided by impratio; that of
a pyramid is 1 + mu^2 times larger. d is the impedance at the depth where the contact carries the
weight. Where the slip turns with Omega, the work of F is that of a viscous friction
k = (B^2 + Omega^2)/(B R).
"""

import argparse
import itertools
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

import tippetop as tt
from tippetop.columns import flagged
from tippetop.exchange.simulators import start_of
from tippetop.figures.style import LIGHT
from tippetop.mechanics.operand import Vector
from tippetop.mechanics.rotation import Quaternion, rotated

from .case import Ball, Case


D_MIN, D_MAX, WIDTH = 0.9, 0.95, 1e-3
"""solimp by default; midpoint 0.5 and power 2."""
GRAVITY = 9.81


def impedance(depth: float) -> float:
    """Return d at a depth [m], for the default solimp."""
    x = min(depth / WIDTH, 1.0)
    return D_MIN + (D_MAX - D_MIN) * (2 * x * x if x < 0.5 else 1 - 2 * (1 - x) ** 2)


class SoftContact(NamedTuple):
    """One contact that carries a free body."""

    timeconst: float = 0.02
    impratio: float = 1.0
    cone: str = "pyramidal"
    mu: float = 1.0

    @property
    def depth(self) -> float:
        """How far the body sinks in [m]: R_n N = K d depth."""
        stiffness = 1 / (D_MAX * self.timeconst) ** 2
        edges = 1.0
        if self.cone == "pyramidal":
            edges = self.mu**2 * (1 + self.mu**2) / (2 * self.impratio)

        def excess(depth: float) -> float:
            d = impedance(depth)
            return depth - edges * (1 - d) * GRAVITY / (d * d * stiffness)

        return brentq(excess, 0.0, 1.0)

    @property
    def damping(self) -> float:
        """B [1/s]."""
        return 2 / (D_MAX * self.timeconst)

    @property
    def inertance(self) -> float:
        """1/R over the mass of the body."""
        d = impedance(self.depth)
        pyramid = 1 + self.mu**2 if self.cone == "pyramidal" else 1.0
        return d * self.impratio / ((1 - d) * pyramid)

    def viscous(self, turning: float = 0.0) -> float:
        """Return mu of F = -mu N v [s/m] where the slip turns with Omega [rad/s]."""
        B = self.damping
        return (B * B + turning * turning) / B * self.inertance / GRAVITY


def growth(damping: float, inertance: float = 0.0, frame: float = 0.0) -> complex:
    """Return the rate of the growing mode of the tutorial's top while it is upright [1/s].

    The force over the mass is -(damping v + inertance J dw/dt). frame is the share of the change
    of J that this leaves out: 1 with the body frame at the centre of mass, 0 at that of the ball.
    """
    p = tt.load("mujoco-tutorial").parameters
    spin, s = 200.0, Polynomial([0, 1])
    arm = (1 - p["alpha"]) * p["R"]
    friction = damping + inertance * s
    slip = friction * (1j * spin * p["R"] - arm * s)
    slip = slip - frame * inertance * 1j * spin * p["alpha"] * p["R"] * s
    tilt = p["I1"] * s * s - 1j * p["I3"] * spin * s + p["alpha"] * p["R"] * p["m"] * p["g"]
    determinant = tilt * (s + friction) - arm * p["m"] * s * slip
    return max(determinant.roots(), key=lambda root: root.real)


def effective(contact: SoftContact) -> float:
    """Return the mu [s/m] of the viscous law under which the tutorial's top rises as fast."""
    rate = growth(contact.damping * contact.inertance, contact.inertance).real
    return brentq(lambda mu: growth(mu * GRAVITY).real - rate, 30.0, 1e6)


def equator(mu: float) -> float:
    """Return when the tutorial's top passes theta = pi/2 under a creep of mu [s]."""
    law = tt.friction.Coulomb(mu=1.0, eps=1.0 / mu)
    events = tt.run("mujoco-tutorial", law, until=12.0).events
    return float(events["time"].values[flagged(events["kind"], "equator")][0])


def tutorial() -> Case:
    """Return the top of the tutorial."""
    problem = tt.load("mujoco-tutorial")
    body, start = problem.body(), start_of(problem)
    return Case(
        name="mujoco-tutorial",
        mass=body.m,
        inertia=np.array([body.I1, body.I1, body.I3]),
        gravity=body.g,
        balls=(Ball(body.c, body.R),),
        joint=None,
        mu=1.0,
        torsion=0.0,
        rolling=0.0,
        restitution=0.0,
        position=start.place,
        quaternion=start.quaternion,
        velocity=start.velocity,
        omega=np.array(rotated(Quaternion(*start.quaternion), Vector(*start.omega))),
        until=8.0,
        law="coulomb",
    )


def simulated(cone: str, frame: str = "centre of the ball") -> np.ndarray:
    """Return time, theta and the gap of MuJoCo with the settings of the tutorial."""
    from .mujoco import motion

    case, step = tutorial(), 1e-3
    setting = {"integrator": "RK4", "cone": cone, "frame": frame}
    setting |= {"impratio": 1.0, "timeconst": 0.02}
    rows = itertools.islice(motion(case, setting, step), round(case.until / step))
    height, x, y = np.array([row[[2, 4, 5]] for row in rows]).T
    up = 1 - 2 * (x**2 + y**2)
    gap = height + case.balls[0].offset * up - case.balls[0].radius
    return np.array([step * np.arange(len(up)), np.arccos(np.clip(up, -1, 1)), gap])


def passage(time: np.ndarray, theta: np.ndarray) -> float:
    """Return when theta passes pi/2 [s]; NaN if it does not."""
    over = theta > math.pi / 2
    return float(time[np.argmax(over)]) if over.any() else math.nan


def draw(path: Path) -> None:
    """Draw theta(t) of MuJoCo, of the exact top, and of the top that creeps as derived."""
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    axes = figure.subplots()
    for cone, colour in (("pyramidal", LIGHT.run), ("elliptic", LIGHT.upper)):
        axes.semilogy(*simulated(cone)[:2], color=colour, label=f"MuJoCo, {cone} cone")
        law = tt.friction.Coulomb(mu=1.0, eps=1.0 / effective(SoftContact(cone=cone)))
        run = tt.run("mujoco-tutorial", law)
        label = f"Coulomb with derived creep, {cone}"
        axes.semilogy(
            run.trajectory.time, run.trajectory.theta, "--", color=colour, label=label, lw=1
        )
    run = tt.run("mujoco-tutorial")
    axes.semilogy(
        run.trajectory.time, run.trajectory.theta, color=LIGHT.lower, label="exact Coulomb"
    )
    axes.semilogy(
        *simulated("elliptic", "centre of mass")[:2],
        ":",
        color=LIGHT.quiet,
        label="MuJoCo, body frame at the centre of mass",
    )
    axes.axhline(math.pi / 2, color=LIGHT.quiet, lw=0.5)
    axes.set(xlabel="t [s]", ylabel="theta [rad]", xlim=(0, 8), ylim=(1e-3, 4))
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Print the tables of the page and draw its figure."""
    parser = argparse.ArgumentParser(prog="python -m bench.simulators.soft_contact")
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    print(
        "| solref time constant [s] | impratio | cone | sinks in [mm] | creep at half the weight "
        "[mm/s] | friction [s/m], slip keeps its direction | and where it turns with 200 rad/s |"
    )
    print("|" + " --- |" * 7)
    for timeconst in (0.05, 0.02, 0.01, 0.004, 0.002):
        for impratio, cone in ((1.0, "pyramidal"), (1.0, "elliptic"), (10.0, "elliptic")):
            contact = SoftContact(timeconst, impratio, cone)
            still = contact.viscous()
            print(
                f"| {timeconst} | {impratio:g} | {cone} | {contact.depth * 1e3:.2g} | "
                f"{500 / still:.2g} | {still:.3g} | {contact.viscous(200.0):.3g} |"
            )
    print()
    for cone in ("pyramidal", "elliptic"):
        contact = SoftContact(cone=cone)
        rate = growth(contact.damping * contact.inertance, contact.inertance)
        mu, turned = effective(contact), passage(*simulated(cone)[:2])
        print(
            f"{cone}: growth {rate.real:.4g} 1/s, Omega {rate.imag:.4g} rad/s; mu = "
            f"{contact.viscous():.4g} at rest, {contact.viscous(rate.imag):.4g} leading order, "
            f"{mu:.4g} s/m; pi/2 at {equator(mu):.4g} s, MuJoCo {turned:.4g} s"
        )
    rate = growth(contact.damping * contact.inertance, contact.inertance, 1.0)
    print(
        f"body frame at the centre of mass: growth {rate.real:.4g} 1/s; pi/2 of MuJoCo at "
        f"{passage(*simulated('elliptic', 'centre of mass')[:2]):.4g} s"
    )
    if given.figure:
        draw(given.figure)


if __name__ == "__main__":
    main()
