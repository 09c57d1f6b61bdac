"""What has become of a top whose contact changes its phase."""

import numpy as np

from tippetop.engine.settling import CLASSES, with_phases
from tippetop.mechanics.contact.body import BALLS
from tippetop.mechanics.contact.contact_phases import PHASES


def test_the_phase_and_the_ball_say_what_a_motion_under_way_is() -> None:
    cases = [
        ("under-way", 1.0, "slip", "body", "under-way"),
        ("under-way", 1.0, "roll", "body", "rolling"),
        ("under-way", 1.0, "rest", "body", "rolling"),
        ("upright", 0.0, "roll", "body", "upright"),
        ("nutating", 0.05, "roll", "body", "rolling"),
        ("nutating", 0.05, "slip", "body", "nutating"),
        ("under-way", 1.0, "flight", "body", "bouncing"),
        ("upright", 0.05, "slip", "body", "upright"),
        ("inverted", 3.1, "flight", "body", "bouncing"),
        ("inverted", 3.1, "slip", "stem", "on-stem"),
    ]
    kinds = np.array([CLASSES.index(kind) for kind, *_ in cases])
    theta = np.array([theta for _, theta, *_ in cases])
    values = {
        "phase": np.array([PHASES.index(phase) for _, _, phase, *_ in cases]),
        "ball": np.array([BALLS.index(ball) for *_, ball, _ in cases]),
    }
    assert [CLASSES[k] for k in with_phases(kinds, theta, values)] == [
        expected for *_, expected in cases
    ]


def test_other_systems_have_no_such_classes() -> None:
    kinds = np.array([CLASSES.index("under-way")])
    assert with_phases(kinds, np.zeros(1), {"theta": np.zeros(1)}) is kinds
