"""What has become of a top whose contact changes its phase."""

import numpy as np

from tippetop.engine.settling import CLASSES, with_phases
from tippetop.mechanics.contact.phases.row import BALLS, PHASES


def test_the_phase_and_the_ball_say_what_a_motion_under_way_is() -> None:
    cases = [
        ("under-way", "slip", "body", "under-way"),
        ("under-way", "roll", "body", "rolling"),
        ("upright", "roll", "body", "upright"),
        ("under-way", "flight", "body", "bouncing"),
        ("inverted", "slip", "stem", "on-stem"),
        ("inverted", "flight", "stem", "bouncing"),
    ]
    kinds = np.array([CLASSES.index(kind) for kind, *_ in cases])
    values = {
        "phase": np.array([PHASES.index(phase) for _, phase, *_ in cases]),
        "ball": np.array([BALLS.index(ball) for *_, ball, _ in cases]),
    }
    assert [CLASSES[k] for k in with_phases(kinds, values)] == [expected for *_, expected in cases]


def test_other_systems_have_no_such_classes() -> None:
    kinds = np.array([CLASSES.index("under-way")])
    assert with_phases(kinds, {"theta": np.zeros(1)}) is kinds
