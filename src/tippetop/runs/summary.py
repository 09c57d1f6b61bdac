"""The summary of a run as lines of text."""

from collections.abc import Mapping
from typing import Any

from ..mechanics.systems import find


WORDS = {
    "upright": "upright spin, which is stable",
    "tumbling": "tumbling: nothing slides any more",
    "inverted": "inverted spin, which is stable",
    "lifted-off": "lifted off",
    "under-way": "under way: this is not yet where the motion ends",
    "rolling": "rolling: nothing slides",
    "on-stem": "on its stem",
    "bouncing": "in the air",
    "nutating": "nutates for ever: without friction nothing is lost",
}
"""What has become of a body, by the name of its class."""


def lines(
    info: Mapping[str, Any], seconds: dict[str, float] | None = None
) -> list[tuple[str, str]]:
    """Name and text of each line of a summary."""
    status = f"{info['reason'].rstrip('.')}; {info['steps']} steps"
    if seconds is not None:
        status += (
            f", integrated in {1e3 * seconds['integrate']:.1f} ms, compiled in "
            f"{seconds['compile']:.2f} s"
        )
    result = [("status", status)]
    system = find(info["system"])
    events = {event.name: event for event in system.events} if system is not None else {}
    can_invert = system is None or system.inverts or "inverted" in events
    if info.get("parameters", {}).get("alpha", 0) < 0:
        result.append(("theta", _of_peg(info["inversion"], info["theta_end"])))
    elif can_invert and (
        any(info["inversion"].values()) or (system is not None and system.inverts)
    ):
        result.append(("inversion", _inversion(info)))
    elif info["theta_end"] is not None:
        result.append(("theta", f"ends at {info['theta_end']:.6g} rad"))
    if info.get("contact_phases", {}).get("last"):
        result.append(("phases", contact(info["contact_phases"])))
    if info.get("outcome") in WORDS:
        result.append(("outcome", WORDS[info["outcome"]]))
    if info["theta_end"] is not None:
        result.append(("turning angles", _turnings(info)))
    others = {k: n for k, n in info["event_counts"].items() if not k.startswith("turning")}
    if others:
        result.append(
            (
                "other events",
                ", ".join(
                    f"{_counted(kind, events)}: {_passages(n)}" for kind, n in others.items()
                ),
            )
        )
    if info.get("kept"):
        result.append(
            ("kept", ", ".join(f"{name} = {_kept(value)}" for name, value in info["kept"].items()))
        )
    if "normal_force" in info:
        force, weight = info["normal_force"], info["normal_force"]["weight"]
        low, high = (f if abs(f) > 1e-12 * weight else 0.0 for f in (force["min"], force["max"]))
        result.append(
            (
                "normal force",
                f"{low:.5g} to {high:.5g} N, that is {low / weight:.4f} to {high / weight:.4f} m g",
            )
        )
    if drift := ", ".join(
        f"{name.replace('_', ' ')} {value:.1e}" for name, value in info["drift"].items()
    ):
        result.append(("drift", f"{drift} (relative, worst of the run)"))
    if by := info.get("run", {}).get("sensitivities"):
        result.append(("sensitivities", f"derivatives of columns and events by {', '.join(by)}"))
    if "motion" in info:
        result.append(("motion", info["motion"]))
    if "regularisation" in info:
        result.append(("regularisation", regularisation(info)))
    if len(system.forms if system is not None else ()) > 1 and "auto_form" in info:
        result.append(("form", form_sentence(info)))
    if start := info.get("start"):
        result.append(("start", f"where {start['from']} ended, at its t = {start['t_end']:.15g} s"))
    if replay := info.get("replay"):
        part = (
            f"t = {replay['from']:.15g} to {replay['until']:.15g} s, every {replay['step']:.15g} s"
        )
        result.append(
            (
                "replay",
                f"rows and events are of {part}, of {replay['of']}; all else is of the whole run",
            )
        )
    if "certificate" in info:
        result.append(("certificate", _certificate(info["certificate"])))
    return result


COUNTED = {
    "equator": "equator (theta = pi/2)",
    "inverted": "inverted (theta rises through pi - 0.1)",
    "settled": "settled (sliding, or its loss, falls below 1e-12 of its unit)",
}
"""What is passed, in words."""

VERBS = {
    "slip": "slips",
    "roll": "rolls",
    "rest": "rolls without turning about the vertical",
    "flight": "flies",
    "both": "stands on body and stem",
}
TIMES = {1: "once", 2: "twice"}


def contact(phases: Mapping[str, Any]) -> str:
    """The story of a contact that changes its phase: all phases if they are few, else how many, the
    first and the last.
    """
    counts, first, last = phases["counts"], phases["first"], phases["last"]
    if sum(counts.values()) == 1:
        text = f"{_does(last)} throughout"
    elif sum(counts.values()) == len(first):
        text = ", then ".join([*map(_until, first[:-1]), _does(last)])
    else:
        often = ", ".join(
            f"{_verb({**last, 'phase': phase})} {TIMES.get(n, f'{n} times')}"
            for phase, n in counts.items()
        )
        begins = ", then ".join(map(_until, first[:2]))
        text = f"{often}; first {begins}; at last {_does(last)} from {last['start']:.6g} s"
    n = phases["impacts"]
    return f"{text}; {n} impact{'' if n == 1 else 's'}" if n else text


def _does(phase: Mapping[str, Any]) -> str:
    """What the body does in a phase."""
    on_stem = phase.get("ball") == "stem" and phase["phase"] in ("slip", "roll", "rest")
    return _verb(phase) + (" on its stem" if on_stem else "")


def _verb(phase: Mapping[str, Any]) -> str:
    """Return the verb of a phase of a contact; of a user-defined system, its name."""
    return VERBS[phase["phase"]] if "ball" in phase else f"`{phase['phase']}`"


def _until(phase: Mapping[str, Any]) -> str:
    return f"{_does(phase)} until {phase['end']:.6g} s"


def form_sentence(info: Mapping[str, Any]) -> str:
    """The form of a run, and what `form = "auto"` says of it."""
    auto = info["auto_form"]
    named = "" if auto["form"] == info["form"] else f"{info['form']}; "
    return f"{named}auto -> {auto['form']}, because {auto['because']}"


def _passages(n: int) -> str:
    return "1 passage" if n == 1 else f"{n} passages"


def _kept(value: float | None) -> str:
    """A number that an event keeps: a count, or a time."""
    return "none" if value is None else str(value) if isinstance(value, int) else f"{value:.9g} s"


def _counted(kind: str, events: Mapping[str, Any]) -> str:
    """What is passed: a kind of event in words; a tip that is held does not lift off."""
    event = events.get(kind)
    if kind == "liftoff" and event is not None and event.ends is None:
        return "vertical reaction falls to zero"
    if (
        kind == "equator" and "inverted" not in events
    ):  # a cylinder or a pendulum turns beyond theta = pi
        return "equator (cos theta = 0)"
    return COUNTED.get(kind, kind)


def regularisation(info: Mapping[str, Any]) -> str:
    """What the regularisation speed eps of a Coulomb law decides: the time of inversion for three
    values of it.
    """
    if "inversion_by_eps" not in info:
        return info["regularisation"]
    by_eps = {name: entry["value"] for name, entry in info["inversion_by_eps"].items()}
    lifted = by_eps.get("lifted_at") or [None] * len(
        by_eps["eps"]
    )  # stores of earlier versions do not say
    times = ", ".join(
        f"{_equator(t, end)} ({'eps = ' if i == 0 else ''}{1e3 * eps:g} mm/s)"
        for i, (eps, t, end) in enumerate(
            zip(by_eps["eps"], by_eps["first_equator"], lifted, strict=True)
        )
    )
    power = "" if by_eps["exponent"] is None else f", about as eps^{by_eps['exponent']:.3g}"
    return f"{info['regularisation']}; theta = pi/2 at: {times}{power}"


def _equator(time: float | None, lifted: float | None) -> str:
    """When theta = pi/2 is passed, or why it is not."""
    if time is not None:
        return f"{time:.5g} s"
    return "not in this time" if lifted is None else f"lifts off before, at {lifted:.5g} s"


COMPARED = (
    ("turnings", "turning times", "time"),
    ("phases", "starts of phases", "start"),
    ("impacts", "impacts", "time"),
)
"""Tables of a certificate, in words, and their times."""


def _certificate(result: Mapping[str, Any]) -> str:
    if result["against"] is None:
        return result["reason"]
    span = f"against {result['against']} over {result['window'][1]:g} s"
    text = f"{span}: theta differs by at most {result['theta']:.1e} rad"
    columns = result.get("columns", {})
    place = [columns[name] for name in ("x", "y", "z") if name in columns]
    if place:
        text += f", the place by {max(place):.1e} m"
    if "normal_force" in columns:
        text += f", the normal force by {columns['normal_force']:.1e} N"
    for name, words, time in COMPARED:
        if name in result:
            text += f", {result[name]['compared']} {words} by {result[name][time]:.1e} s"
    return text


def _of_peg(inversion: Mapping[str, Any], end: float) -> str:
    """Return where the axis of a peg has been: near theta = pi it is not inverted, but at its
    lowest.
    """
    passages = [
        inversion[name] for name in ("first_equator", "last_equator") if inversion[name] is not None
    ]
    passed = " and ".join(f"{time:.6f} s" for time in dict.fromkeys(passages))
    return (f"pi/2 at {passed}, " if passed else "") + f"ends at {end:.6g} rad"


def _inversion(info: Mapping[str, Any]) -> str:
    inversion, end = info["inversion"], info["theta_end"]
    if inversion["inverted_at"] is not None:
        equator = (
            f"theta = pi/2 at {inversion['first_equator']:.6f} s"
            if inversion["first_equator"]
            else "inverted"
        )
        last = inversion["last_equator"]
        again = f" (last at {last:.6f} s)" if last != inversion["first_equator"] else ""
        return f"{equator}{again}, pi - 0.1 at {inversion['inverted_at']:.6f} s"
    if inversion["first_equator"] is not None:
        return (
            f"theta = pi/2 at {inversion['first_equator']:.6f} s, not beyond pi - 0.1; theta "
            f"ends at {end:.6g}"
        )
    return f"none; theta ends at {end:.6g} rad"


def _turnings(info: Mapping[str, Any]) -> str:
    counts, band = info["event_counts"], info["nutational_band"]
    if not counts.get("turning"):
        return "none logged"
    significant = counts.get(
        "turning_significant", counts["turning"]
    )  # of an event without a sense all are
    noise = counts["turning"] - significant
    text = f"{significant} logged"
    if band["theta_min"] is not None:
        low, high = (f"{band[name]:.6g}" for name in ("theta_min", "theta_max"))
        text += (
            f", at theta = {low} rad" if low == high else f", at theta between {low} and {high} rad"
        )
    return text + (f"; {noise} more below the rounding floor" if noise else "")
