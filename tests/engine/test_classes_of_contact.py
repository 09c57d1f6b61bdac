"""What has become of a top whose contact changes its phase."""

import numpy as np

from tippetop.engine.settling import CLASSES, classes_of
from tippetop.mechanics.contact.body import BALLS
from tippetop.mechanics.contact.contact_phases import PHASES
from tippetop.runs import starting


def fates(theta: list[float], **values: np.ndarray) -> list[str]:
    """Return the fates of tops without spin that have not settled."""
    problem, n = starting.load("inverting"), len(theta)
    values |= {"theta": np.array(theta), "omega3": np.zeros(n)}
    kinds = classes_of(problem.system, values, 1.0, np.zeros(n, bool), problem.body())
    return [CLASSES[kind] for kind in kinds]


def test_the_phase_and_the_ball_say_what_a_motion_under_way_is() -> None:
    cases = [
        (1.0, "slip", "body", "under-way"),
        (1.0, "roll", "body", "rolling"),
        (1.0, "rest", "body", "rolling"),
        (0.0, "roll", "body", "upright"),
        (0.05, "roll", "body", "rolling"),
        (3.14, "roll", "body", "rolling"),  # upside down without spin: it will leave
        (1.0, "flight", "body", "bouncing"),
        (0.05, "slip", "body", "upright"),
        (3.1, "flight", "body", "bouncing"),
        (3.1, "slip", "stem", "on-stem"),
    ]
    theta, phases, balls, expected = zip(*cases, strict=True)
    phase = np.array([PHASES.index(phase) for phase in phases])
    ball = np.array([BALLS.index(ball) for ball in balls])
    assert fates([*theta], phase=phase, ball=ball) == [*expected]


def test_other_systems_have_no_such_classes() -> None:
    assert fates([1.0, 0.05]) == ["under-way", "upright"]
