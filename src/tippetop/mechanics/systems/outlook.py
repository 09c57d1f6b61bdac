"""Predictions of theory for a start, by system: thresholds, the regime in a sentence, the fate.

Each function takes the body and the quantities of the start, and returns an `Outlook`; a `System`
has one as its field `outlook`, which `runs.forecast` calls before a run. Where the contact may open
it is that of the `Opening`, which takes the rules of the contact too.

Symbols
    b         the body in SI units, a `contact.body.Touch` or `Asymmetric`, with its law b.friction
    start     quantities and angles at the start by name, SI; at_pole: whether theta is 0 or pi
    law       the rules of a contact that may open, a `ContactLaw`
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..contact.body import Touch, tip_inertia
from ..contact.frame import Asymmetric
from ..contact.restitution import ContactLaw
from ..friction import has_parts, is_frictionless, nowhere_vanishes
from ..operand import Vector
from ..system import Outlook
from ..theory import eggs_and_discs
from ..theory import heavy_top_motion as motions
from ..theory.modes import linear_modes
from ..theory.regimes import regime
from ..theory.small_oscillations import oscillations
from ..theory.spinning import rolling_thresholds
from ..theory.thresholds import (
    Threshold,
    lambda_de,
    lambda_s,
    lambda_u,
    sleeping_spin,
    spin_of,
    spins_by_height,
    thresholds,
    thresholds_of_sleeping,
)
from ..theory.tumbling import lambda_t
from ..units import JELLETT, RADIAN_PER_SECOND


Start = Mapping[str, float]
UNLESS = ", unless it lifts off"
"""No bound of the normal force is proven, whatever the start."""
STAYS = "stays at the pole until it is disturbed"
FREE = "no friction: nothing is lost, and no state attracts"
SOMEWHERE_FREE = (
    "friction vanishes somewhere on the body or in fast sliding: no state is known to attract"
)
PARTS_TAKE = (
    "rolling resistance or drilling takes energy and Jellett's integral: no state is "
    "known to attract"
)
NO_THEORY = "no theory of this body is known here"
ONLY_OSCILLATIONS = (
    "theory predicts small oscillations only, in pure rolling with half axis c nearly vertical"
)
LEANS = 0.1  # rad: an oscillation is small
GROWS = 1e-6  # 1/s: a mode that grows more slowly is neutral, to rounding


def tippe_top(b: Touch, start: Start) -> Outlook:
    """Predict a gliding tippe top: lambda is conserved and decides which states are stable.

    [T Theorem 3.3.2, corrected]
    """
    limits = thresholds(b) | rolling_thresholds(b)
    if is_frictionless(b.friction):
        fate = STAYS if start["at_pole"] else "theta nutates for ever" + UNLESS
        return Outlook(FREE, fate, limits)
    now = regime(start["jellett"], b)
    acts = nowhere_vanishes(b.friction)
    if start["at_pole"]:
        fate = STAYS
    elif not acts:
        fate = ""
    elif len(now.attractors) == 1:
        fate = f"ends in {now.attractors[0]}" + UNLESS
    else:
        fate = "depends on the start: " + ", or ".join(now.attractors) + UNLESS
    sentence = now.sentence() if acts else SOMEWHERE_FREE
    return Outlook(sentence, fate, limits)


def tippe_top_with_contact(b: Touch, start: Start, law: ContactLaw) -> Outlook:
    """Predict a tippe top whose contact may open or stick, while it slides on a ball."""
    if has_parts(b.friction):
        return Outlook(PARTS_TAKE)
    limits = thresholds(b)
    on_stem = b._replace(R=law.r, c=b.c + law.h)  # the ball of the stem, as in `views.samples`
    if law.stem and on_stem.c > 0:  # else the centre of mass is not above the stem's ball
        needed = lambda_s(on_stem)
        limits |= {
            "lambda_s_stem": Threshold(
                needed, JELLETT, "spin on the stem stable above, of the stem's lambda"
            ),
            "spin_stem": Threshold(
                -spin_of(needed, on_stem, inverted=True),
                RADIAN_PER_SECOND,
                "spin on the stem stable from here on",
            ),
        }
    if is_frictionless(b.friction):
        return Outlook(
            FREE, STAYS if start["at_pole"] else "theta nutates while it stands on one ball", limits
        )
    sentence = f"while it slides on its sphere {regime(start['jellett'], b).sentence()}"
    if b.friction.set_valued:
        sentence += (
            "; under Coulomb's law itself sliding may stop, and a top that rolls does not rise"
        )
    elif b.friction.regions:
        sentence += "; drilling friction reduces Jellett's integral, which decides that"
    return Outlook(sentence, "", limits)


def tippe_top_borders(b: Touch) -> dict[str, Any]:
    """Return each |lambda| at which the asymptotic states of a tippe top change [kg m^3/s].

    By label, "symbols: words", for bodies b with arrays of numbers, (n,); NaN: no border.
    """
    low, high = spins_by_height(b)
    least = lambda_u(b)
    tumbling = lambda_t(b)
    # otherwise tumbling begins where the lowest spin ends
    distinct = np.abs(np.log(tumbling / least)) >= 1e-3
    return {
        f"λ = λ_u: {low} spin stable below": least,
        f"λ = λ_s: {high} spin stable above": lambda_s(b),
        f"λ = λ_de: {high} spin has less energy above": lambda_de(b),
        "λ = λ_t: tumbling possible above": np.where(distinct, tumbling, np.nan),
    }


def rolling_tippe_top(b: Touch, start: Start) -> Outlook:
    """Predict a rolling tippe top: one degree of freedom. [T ch. 4]"""
    limits = rolling_thresholds(b)
    sentence = "pure rolling conserves E, D and lambda: theta nutates for ever"
    stable = "stable" if abs(start["jellett"]) > limits["lambda_pi"].value else "unstable"
    limits["gamma"] = thresholds(b)["gamma"]
    nutates = STAYS if start["at_pole"] else "nutation between two angles" + UNLESS
    fate = f"{nutates}; the {spins_by_height(b)[1]} spin of this lambda is {stable} in rolling"
    return Outlook(sentence, fate, limits)


def heavy_top(b: Touch, start: Start) -> Outlook:
    """Predict a heavy top whose tip is fixed. [T ch. 2]"""
    upright = "stable" if _sleeps(b, start) else "unstable"
    return Outlook(
        f"the sleeping top of this spin is {upright}",
        heavy_top_motion(b, start),
        thresholds_of_sleeping(b),
    )


def heavy_top_motion(b: Touch, start: Start) -> str:
    """Return the name of the motion of a heavy top whose tip is fixed; also `System.motion`."""
    if start["at_pole"]:
        return f"a spin that {STAYS}"
    conserved = start["energy"], start["Lz"], start["L3"]
    return motions.heavy_top_motion(*conserved, tip_inertia(b), b.I3, b.m * b.g * -b.c)


def gliding_heavy_top(b: Touch, start: Start) -> Outlook:
    """Predict a heavy top whose tip glides: upright it is always unstable, against [T 5.54]."""
    growth = float(linear_modes(start["L3"] / b.I3, b)[0].real)
    if is_frictionless(b.friction):
        regime = f"without friction the upright spin is {'un' if growth > GROWS else ''}stable"
        return Outlook(regime, STAYS if start["at_pole"] else "", thresholds_of_sleeping(b))
    how = "spirals out slowly" if _sleeps(b, start) else "topples"
    rate = f" (growth rate {growth:.3g} per second)" if GROWS < growth < math.inf else ""
    regime = f"upright spin unstable at every speed{rate}: the top {how}"
    fate = ""
    if not nowhere_vanishes(b.friction):
        regime = SOMEWHERE_FREE
    elif start.get("theta", 0.0) < math.pi / 2:
        fate = "falls to the plane in the end" + UNLESS
    return Outlook(regime, STAYS if start["at_pole"] else fate, thresholds_of_sleeping(b))


def cylinder(b: Touch, start: Start) -> Outlook:
    """Predict an eccentric cylinder that rolls, or comes to. [T ch. 6]"""
    if b.c == 0:
        return Outlook("a round cylinder rolls as it began")
    # theta'' of `rolling_cylinder.rolling_acceleration` for small theta
    omega = math.sqrt(b.m * b.g * b.c / (b.I1 + b.m * (b.R - b.c) ** 2))
    return Outlook(f"small oscillations in rolling have angular frequency {omega:.6g} rad/s")


def gliding_cylinder(b: Touch, start: Start) -> Outlook:
    """Predict an eccentric cylinder that glides.

    Without friction its centre of mass keeps its velocity.

    [T ch. 6]
    """
    if not is_frictionless(b.friction):
        return Outlook(_round(b.friction)) if b.c == 0 else cylinder(b, start)
    if b.c == 0:
        return Outlook("a round cylinder: without friction it glides and turns as it began")
    omega = math.sqrt(b.m * b.g * b.c / b.I1)
    return Outlook(f"without friction small oscillations have angular frequency {omega:.6g} rad/s")


def _round(law: Any) -> str:
    """Return how a round cylinder glides under a law, in a sentence: v_A' = -k g (I + m R^2)/I v_A.

    [T 6.7]
    """
    if law.coefficient is not None and not nowhere_vanishes(law):
        return "a round cylinder: its friction vanishes somewhere, so it may glide on"
    return "a round cylinder: gliding decays to rolling"


def revolution(
    b: Touch, start: Start, law: ContactLaw | None = None, *, rolls: bool = False
) -> Outlook:
    """Predict rest, spins at the poles and steady rolling of a body with an outline.

    `law` is given where the contact may open; `rolls`: pure rolling, where no friction law acts.
    How a disc ends is disputed, so nothing is predicted about it.
    """
    acts = nowhere_vanishes(b.friction) and not has_parts(b.friction)
    spins, limits = eggs_and_discs.spins(b, rolls=rolls) if rolls or acts else ([], {})
    found = eggs_and_discs.limits(b) | limits
    if start["phi_dot"] and 0 < start["theta"] < math.pi:
        found |= eggs_and_discs.steady_rolling(start["theta"], start["phi_dot"], b)
    when = "in pure rolling" if rolls else "under friction" if law is None else "while it slides"
    sentence = f"{when} {', '.join(spins)}" if spins else NO_THEORY
    return Outlook(sentence, STAYS if start["at_pole"] else "", found)


def without_axis(b: Asymmetric, start: Start, *, rolls: bool = False) -> Outlook:
    """Predict small oscillations of a body that rolls with its half axis c nearly vertical.

    `rolls` is whether the system is in pure rolling; of a gliding one nothing is predicted.
    """
    leans = max(abs(start["tilt"]), abs(math.sin(start["roll"])))
    if not rolls or leans > LEANS or b.outline.x or b.outline.y:
        return Outlook(ONLY_OSCILLATIONS)
    up = 1 if math.cos(start["roll"]) > 0 else -1
    at_rest, shapes = oscillations(0.0, up, b)
    at_spin, _ = oscillations(start["spin"], up, b)
    if len(at_rest) + len(at_spin) < 4:
        return Outlook("at rest or at this spin, pitch or roll does not oscillate")
    x, y, *_ = shapes[:, 0]
    along, across, _ = b.outline.half_axes(Vector(x, y, 0.0))
    names = ("pitch", "roll") if abs(along) > abs(across) else ("roll", "pitch")
    sentences = []
    for name, slow, rate in zip(names, at_rest.imag, at_spin.real, strict=True):
        how = f"{'grows' if rate > 0 else 'decays'} at {abs(rate):.3g} per second"
        how = how if abs(rate) > GROWS else "keeps its size"
        sentences.append(f"small {name}, {slow:.6g} rad/s at rest, {how} at this spin")
    return Outlook("; ".join(sentences))


def _sleeps(b: Touch, start: Start) -> bool:
    """Return whether the spin at the start is above that of the sleeping top, which is stable."""
    return abs(start["L3"]) / b.I3 > sleeping_spin(b)
