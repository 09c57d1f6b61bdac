"""Tops that can be: random systems, bodies, friction laws, contacts and starts, as the tables of a
scenario.
"""

from typing import Any

import numpy as np


ENDS = {
    **{"theta": (0.0, np.pi), "mu": (1e-3, 1.0), "eps": (1e-4, 0.1), "alpha": (0.02, 0.95)},
    **{"patch": (1e-5, 2e-3), "mu_r": (1e-7, 1e-4)},
}
SMALL = {"nu_x", "nu_y", "x", "y"}


def spread(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two positive ones, evenly in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def parameters(system: Any, rng: np.random.Generator, scale: float) -> dict[str, float]:
    """A body that can be: a ball or a bar of a size within a factor `scale` of centimetres, of any
    of its shapes.
    """
    m, R, g = 0.02 * spread(rng, 1 / scale, scale), 0.02 * spread(rng, 1 / scale, scale), 9.82
    if rng.random() < 0.3:
        g *= spread(rng, 1 / scale, scale)
    numbers = {
        "m": m,
        "R": R,
        "l": R * spread(rng, 0.3, 3.0),
        "g": g,
        "alpha": float(rng.uniform(0.02, 0.9)),
    }
    if "alpha" in system.parameters and system.parameters["alpha"].nonzero:
        numbers["alpha"] *= float(rng.choice([-1, 1]))  # a peg as often as a top
    numbers["I3"] = m * R * R * spread(rng, 0.2, 1.0)
    numbers["I1"] = numbers["I3"] * float(rng.uniform(0.55, 3.0))  # I3 <= 2 I1 holds of every body
    numbers["I"] = m * R * R * float(rng.uniform(0.2, 0.9))
    return {
        name: numbers[name] if name in numbers else spread(rng, 0.1, 10.0)
        for name in system.parameters
    }


def friction(system: Any, rng: np.random.Generator, law: str = "") -> dict[str, Any]:
    """A law that the system takes, and its numbers."""
    law = law or str(
        rng.choice(sorted(name for name, rules in system.laws.items() if not rules.regions))
    )
    return {"law": law} | {
        name: spread(rng, *ENDS.get(name, (0.01, 1.0))) for name in system.laws[law].parameters
    }


def initial(system: Any, rng: np.random.Generator, fastest: float) -> dict[str, float]:
    """A start: any inclination, spins up to `fastest` of either sign."""
    numbers = {"theta": float(rng.uniform(0.002, np.pi - 0.002))}
    for name in system.initial:
        if (
            name == "theta"
            or rng.random() < 0.5
            or any(name in a.others or name == a.name for a in system.alternatives)
        ):
            continue
        largest = 1.0 if name in SMALL else fastest
        numbers[name] = float(rng.choice([-1, 1])) * spread(rng, 1e-3 * largest, largest)
    if "omega3" in system.initial and rng.random() < 0.8:
        numbers["omega3"] = float(rng.choice([-1, 1])) * spread(rng, 1e-2 * fastest, fastest)
    return {name: value for name, value in numbers.items() if name in system.initial}


def scenario(
    rng: np.random.Generator, pair: tuple[str, str], scale: float = 30.0, fastest: float = 400.0
) -> dict[str, Any]:
    """The tables of a scenario of a system and a law (empty: any), without [run]."""
    from tippetop.mechanics.systems import SYSTEMS

    system = SYSTEMS[pair[0]]
    tables: dict[str, Any] = {
        "system": system.name,
        "form": str(rng.choice(sorted(system.forms))),
        "parameters": parameters(system, rng, scale),
        "initial": initial(system, rng, fastest),
    }
    if system.frictional:
        tables["friction"] = friction(system, rng, pair[1])
    return tables


def opening(tables: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """The tables of a scenario with a contact that sticks, opens and closes: by an exact or a
    drilling law, [contact], [stem], or on_liftoff, one at least; in its default form. As they are
    where the system has no such contact.
    """
    from tippetop.mechanics.friction import LAWS
    from tippetop.mechanics.systems import opening_systems

    if tables["system"] not in opening_systems():
        return tables
    round_body = tables["system"] == "tippe-top"
    opened = {key: value for key, value in tables.items() if key != "form"} | {
        "initial": dict(tables["initial"])
    }
    ways = rng.random(6)
    for law, there, share in (("contensou", round_body, 0.2), ("coulomb", True, 0.5)):
        if there and ways[0] < share:
            exact = LAWS[law].given(())
            opened["friction"] = {"law": law} | {
                name: spread(rng, *ENDS[name]) for name in exact.parameters
            }
            break
    if "mu_r" in opened["friction"] and ways[1] < 0.5:
        opened["friction"]["mu_r"] = 0.0
    if ways[2] < 0.7:
        restitution = str(rng.choice(["energetic", "poisson", "newton"]))
        opened["contact"] = {
            "restitution": restitution,
            "e_n": float(rng.choice([0.0, 1.0, rng.uniform(0.0, 0.95)])),
        }
    if round_body and ways[3] < 0.4:
        R = opened["parameters"]["R"]
        opened["stem"] = {
            "r": (r := R * float(rng.uniform(0.1, 0.9))),
            "h": R - r + R * float(rng.uniform(0.01, 1.0)),
        }
    if ways[4] < 0.3:
        opened["initial"] |= {"gap": spread(rng, 1e-7, 1e-2), "nu_z": float(rng.normal(0.0, 0.2))}
    return opened
