"""The bits of a run with changes of phase do not depend on what ran before it in the process."""

import hashlib
import random
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from examples import CANONICAL
from forked import SERVER

import tippetop as tt
from tippetop.mechanics.operand import formula


SEEDS = range(2, 5)


def scenario(seed: int) -> dict:
    """A top that bounces often: any law, restitution, torques, stem or peg."""
    some = random.Random(seed)
    laws = (
        {"law": "viscous", "mu": 0.5, "mu_r": 1e-5},
        {"law": "coulomb", "mu": 0.3, "mu_d": 1e-5},
        {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 1e-5},
        {"law": "viscous", "mu": 0.5},
        {"law": "coulomb", "mu": 0.3, "eps": 0.01},
    )
    made = {
        "system": "tippe-top",
        "parameters": CANONICAL | {"alpha": -0.2} if seed == 4 else CANONICAL,
        "friction": laws[seed % len(laws)],
        "contact": {"e_n": 0.7, "restitution": ("energetic", "poisson")[seed % 2]},
        "initial": {
            "theta": some.uniform(0.2, 0.8),
            "theta_dot": some.uniform(-20, 20),
            "omega3": some.uniform(20, 60),
            "nu_x": some.uniform(-0.2, 0.2),
            "gap": 0.005,
        },
        "run": {"until": 0.3, "output_step": 1e-3},
    }
    return made | ({"stem": {"r": 0.005, "h": 0.025}} if seed == 3 else {})


def digest(seed: int) -> str:
    """The SHA-256 of all tables of a run."""
    found = hashlib.sha256()
    for table in tt.run(scenario(seed)).datasets().values():
        for name, values in sorted(table.variables.items()):
            found.update(name.encode() + np.ascontiguousarray(values.values).tobytes())
    return found.hexdigest()


def test_a_run_has_the_bits_of_a_fresh_process_whatever_ran_before() -> None:
    """Other runs, the same one with other events, and some in other threads."""
    with SERVER.Pool(1, maxtasksperchild=1) as fresh:
        alone = fresh.map(digest, SEEDS, chunksize=1)
    assert [digest(seed) for seed in SEEDS] == alone
    above = tt.extending.Event("above", "z rises", formula(lambda s, b: 0.9 - s.z))
    for seed in SEEDS:
        tt.run(scenario(seed), events=[above], until=0.2)
    assert [digest(seed) for seed in reversed(SEEDS)] == alone[::-1]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(digest, SEEDS)) == alone
