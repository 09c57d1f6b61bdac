"""The summary of a run as lines of text.

`attributes.info` goes in; out come pairs of a name and a text, which `tippetop run` and
`print(run)` show.
"""

from collections.abc import Mapping
from typing import Any

from ..mechanics.systems import find
from ..mechanics.systems.tippe_top import is_peg


Info = Mapping[str, Any]
"""What `attributes.info` returns, or a table of it."""
WORDS = {
    "upright": "upright spin, which is stable",
    "tumbling": "tumbling: nothing slides any more",
    "inverted": "inverted spin, which is stable",
    "lifted-off": "lifted off",
    "under-way": "under way: no final motion was recognised",
    "rolling": "rolling: nothing slides",
    "on-stem": "on its stem",
    "bouncing": "in the air",
    "nutating": "nutates for ever: without friction nothing is lost",
    "at-rest": "at rest",
}
"""Outcomes of a run, by the name of their class."""
COUNTED = {
    "equator": "equator (theta = pi/2)",
    "inverted": "inverted (theta rises through pi - 0.1)",
    "settled": "settled (sliding, or its loss, falls below 1e-12 of its unit)",
}
"""Events that are counted as passages."""
# phases, by name
VERBS = {
    "slip": "slips",
    "roll": "rolls",
    "rest": "rolls without turning about the vertical",
    "flight": "flies",
    "both": "stands on body and stem",
}
START = "where {from} ended, at its t = {t_end:.15g} s"
REPLAY = (
    "rows and events are of t = {from:.15g} to {until:.15g} s, every {step:.15g} s, of {of}; "
    "all else is of the whole run"
)
TIMES = {1: "once", 2: "twice"}
COMPARED = (
    ("turnings", "turning times", "time"),
    ("phases", "starts of phases", "start"),
    ("impacts", "impacts", "time"),
)
"""Tables of a certificate, in words, and their times."""


def lines(info: Info, seconds: dict[str, float] | None = None) -> list[tuple[str, str]]:
    """Return the name and the text of each line of a summary.

    Parameters
    ----------
    info
        What `attributes.info` returns. Of its entries, `contact_phases`, `outcome`, `kept`,
        `normal_force`, `motion`, `start`, `replay` and `certificate` are optional.
    seconds
        Durations of integrating and compiling [s], by `integrate` and `compile`.
    """
    status = f"{info['reason'].rstrip('.')}; {info['steps']} steps"
    if seconds is not None:
        status += (
            f", integrated in {1e3 * seconds['integrate']:.1f} ms, compiled in "
            f"{seconds['compile']:.2f} s"
        )
    system = find(info["system"])
    events = {event.name: event for event in system.events} if system is not None else {}
    peg = is_peg(info.get("parameters", {}))
    drift = [f"{name.replace('_', ' ')} {value:.1e}" for name, value in info["drift"].items()]
    rows = {
        "status": status,
        **_axis(info, system, events, peg),
        "phases": _contact(info["contact_phases"])
        if info.get("contact_phases", {}).get("last")
        else "",
        "outcome": WORDS.get(info.get("outcome", ""), ""),
        "turning angles": "" if info["theta_end"] is None else _turnings(info),
        "other events": ", ".join(
            f"{_counted(kind, events)}: {n} passage{'' if n == 1 else 's'}"
            for kind, n in info["event_counts"].items()
            if not (kind.startswith("turning") or (peg and kind == "inverted"))
        ),
        "kept": ", ".join(
            f"{name} = {f'{value:.9g} s' if isinstance(value, float) else value or 'none'}"
            for name, value in info.get("kept", {}).items()
        ),
        "normal force": _force(info["normal_force"]) if "normal_force" in info else "",
        "drift": f"{', '.join(drift)} (relative, worst of the run)" if drift else "",
        "motion": info.get("motion", ""),
        "start": START.format(**info["start"]) if "start" in info else "",
        "replay": REPLAY.format(**info["replay"]) if "replay" in info else "",
        "certificate": certificate_sentence(info["certificate"]) if "certificate" in info else "",
    }
    return [(name, text) for name, text in rows.items() if text]


def _axis(info: Info, system: Any, events: Info, peg: bool) -> dict[str, str]:
    """Return the lines on the inversion, or only on the last theta of a body that cannot invert.

    `info` is what `attributes.info` returns, `system` its System or None, `events` the events of
    that by name; `peg` is whether the centre of mass is lowest at theta = pi.
    """
    inversion = info["inversion"]
    end = info["theta_end"]
    # the names of `reporting.INVERSION`
    first, last, inverted = (
        inversion[name] for name in ("first_equator", "last_equator", "inverted_at")
    )
    inverts = system.inverts if system is not None else False
    can_invert = system is None or inverts or "inverted" in events
    if peg or not can_invert or not (inverts or any(inversion.values())):
        return {} if end is None else {"theta": f"ends at {end:.6g} rad"}
    if inverted is not None:
        equator = f"theta = pi/2 at {first:.6f} s" if first else "inverted"
        again = f" (last at {last:.6f} s)" if last != first else ""
        text = f"{equator}{again}, pi - 0.1 at {inverted:.6f} s"
    elif first is not None:
        text = f"theta = pi/2 at {first:.6f} s, not beyond pi - 0.1; theta ends at {end:.6g}"
    else:
        text = f"none; theta ends at {end:.6g} rad"
    return {"inversion": text}


def _turnings(info: Info) -> str:
    """Return the number of turning points, and the band of theta between them."""
    counts = info["event_counts"]
    band = info["nutational_band"]
    if not counts.get("turning"):
        return "none logged"
    significant = counts.get("turning_significant", counts["turning"])
    noise = counts["turning"] - significant
    text = f"{significant} logged"
    if band["theta_min"] is not None:
        low, high = (f"{band[name]:.6g}" for name in ("theta_min", "theta_max"))
        text += (
            f", at theta = {low} rad" if low == high else f", at theta between {low} and {high} rad"
        )
    return text + (f"; {noise} more below the rounding floor" if noise else "")


def _counted(kind: str, events: Info) -> str:
    """Return a kind of event in words; a tip that is held does not lift off."""
    if kind == "liftoff" and kind in events and events[kind].ends is None:
        return "vertical reaction falls to zero"
    if kind == "equator" and "inverted" not in events:  # beyond theta = pi too
        return "equator (cos theta = 0)"
    return COUNTED.get(kind, kind)


def _force(force: Info) -> str:
    """Return the extremes of the normal force, in words; those that are rounding errors as 0."""
    weight = force["weight"]
    low, high = (f if abs(f) > 1e-12 * weight else 0.0 for f in (force["min"], force["max"]))
    in_weights = f"{low / weight:.4f} to {high / weight:.4f} m g"
    return f"{low:.5g} to {high:.5g} N, that is {in_weights}"


def _contact(phases: Info) -> str:
    """Return the phases of a contact: all if they are few, else counts, the first and the last.

    `phases` is what `PhaseHistory.report` returns.
    """
    counts = phases["counts"]
    first = phases["first"]
    last = phases["last"]
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


def _verb(phase: Info) -> str:
    """Return the verb of a phase of a contact; of a user-defined system, its name.

    `phase` is an entry of `PhaseHistory.report`, as in the functions below; only phases of contacts
    have a `ball`.
    """
    name = phase["phase"]
    return VERBS.get(name, f"`{name}`") if "ball" in phase else f"`{name}`"


def _does(phase: Info) -> str:
    """Return the verb of a phase, and where the body touches the plane."""
    on_stem = phase.get("ball") == "stem" and phase["phase"] in ("slip", "roll", "rest")
    return _verb(phase) + (" on its stem" if on_stem else "")


def _until(phase: Info) -> str:
    """Return a phase and its end, in words: "rolls until 2.5 s"."""
    return f"{_does(phase)} until {phase['end']:.6g} s"


def certificate_sentence(result: Info) -> str:
    """Return a certificate, as `certificate.certificate` returns it, in one sentence."""
    if result["against"] is None:
        return result["reason"]
    if "theta" in result:
        error = f"theta differs by at most {result['theta']:.1e} rad"
    else:  # of a user's system
        error = f"columns differ by at most {max(result['columns'].values()):.1e} in SI units"
    text = f"against {result['against']} over {result['window'][1]:g} s: {error}"
    for name, words, time in COMPARED:
        if name in result:
            rows, expected = result[name]["counts"]
            if rows == expected:
                text += f", {rows} {words} by {result[name][time]:.1e} s"
            else:
                text += f", {rows} {words}, but {expected} in {result['against']}"
    shared = "; ".join(result.get("thresholds", ()))
    return f"{text}. Both runs share the thresholds of contact of {shared}" if shared else text
