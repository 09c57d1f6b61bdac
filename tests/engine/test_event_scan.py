"""Events of every system and form are the sign changes of their functions on dense rows: none is
missing, none is there twice.
"""

import dataclasses
from collections import Counter

import numpy as np

from tippetop.engine.observables import Observables
from tippetop.runs import starting
from tippetop.runs.run import solve


ROW = 1e-4  # [s]
CASES = (
    ("inverting", "vector", 1.0, {}),
    ("inverting", "euler", 0.4, {}),
    ("inverting", "vector", 8.0, {"omega3": 155.0}),
    ("inverting", "vector", 6.0, {"omega3": 170.0}),
    ("inverting", "vector", 0.5, {"omega3": 0.0, "theta_dot": 3.0}),
    ("rolling", "contact", 1.0, {}),
    ("gliding-heavy-top", "vector", 1.0, {}),
    ("gliding-heavy-top", "vector", 2.0, {"omega3": 5.0, "theta_dot": 0.1}),
    ("heavy-top", "vector", 1.0, {}),
    ("gliding-cylinder", "angle", 6.0, {}),
    ("rolling-cylinder", "angle", 6.0, {}),
)


def test_events_are_the_zeros_of_a_dense_scan(rng: np.random.Generator) -> None:
    """From random starts, every second one at rest, where theta' begins on its zero."""
    found: Counter[str] = Counter()
    for k, (preset, form, until, given) in enumerate(CASES * 2):
        settings = [f"form={form}", "run.on_liftoff=continue", f"run.output_step={ROW}"]
        base = starting.load(preset, settings, until)
        near = {
            name: x + rng.uniform(-0.3, 0.3) * max(abs(x), 0.4)
            for name, x in base.initial.items()
            if type(x) is float and k >= len(CASES)
        }
        rest = {} if k % 2 else {"theta_dot": rng.uniform(-2.0, 2.0)}
        run = solve(dataclasses.replace(base, initial={**base.initial, **near, **rest, **given}))
        scalars, body = Observables(run.problem).moment(run.rows), run.problem.internal_body
        for event in run.problem.system.events:
            if event.lasting:  # what settles is noise
                continue
            above = np.broadcast_to(event.formula(scalars, body), len(run.times))[1:] > 0
            way = np.diff(above.astype(int))
            passed = run.times[1:-1][(way != 0) & (way * event.direction >= 0)]
            logged = run.events.of(event.name).time
            logged = logged[(logged > run.times[1]) & (logged < run.times[-1])]
            assert len(logged) == len(passed), (preset, form, event.name, k)
            assert ((passed <= logged) & (logged <= passed + 1.01 * ROW)).all(), (k, event.name)
            found[event.name] += len(logged)
    assert {"turning", "liftoff", "equator", "inverted"} <= set(+found)
