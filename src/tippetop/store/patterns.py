"""The root attributes that our releases write: names and types, for `skeleton` to compare with."""

from typing import Any


NUMBER = (int, float)
WORDS: dict[str, Any] = {"title": str, "versions": {str: str}, "cpu": str}  # every store
ATTRIBUTES: dict[str, dict[str, Any]] = {
    "run": {
        "status": str,
        "reason": str,
        "source": str,
        "system": str,
        "form": str,
        "parameters": {str: NUMBER},
        "initial": {str: (*NUMBER, bool)},
        "run": dict,
        "tolerance": NUMBER,
        "precision": str,
        "units": {str: str},
        "final_state": {str: (*NUMBER, None)},
        "report": dict,
    },
    "sweep": {
        "status": str,
        "reason": str,
        "plan": dict,
        "tops": int,
        "chunk": int,
        "dimensions": [str],
        "shape": [int],
        "coordinates": [str],
        "columns": [str],
        "steps_by?": str,
    },
    "surface": {"system": str, "parameters": {str: NUMBER}, "axes": {str: [NUMBER]}},
    "potential": {"system": str, "parameters": {str: NUMBER}},
}
REPORT: dict[str, Any] = {  # of a run; `?`: where the system has it
    "t_end": NUMBER,
    "steps": int,
    "drift": {str: (*NUMBER, None)},
    "event_counts": {str: int},
    "theta_end": (*NUMBER, None),
    "normal_force?": {str: (*NUMBER, None)},
    "inversion?": {str: (*NUMBER, None)},
    "nutational_band?": {str: (*NUMBER, None)},
}
OPTIONAL: dict[str, Any] = {
    "friction?": {str: (str, *NUMBER)},
    "certificate?": dict,
    "auto_form?": {str: str},
    "contact?": {str: (str, *NUMBER)},
    "end?": dict,
    "stem?": {str: NUMBER},
    "replay?": {str: (str, *NUMBER)},
    "start?": {str: (str, dict, *NUMBER)},
    "own?": {str: {str: str}},
}
RUN: dict[str, Any] = {
    "until": NUMBER,
    "events": [str],
    "on_liftoff": str,
    "precision": str,
    "tolerance": NUMBER,
    "stop_when": str,
    "output_step?": NUMBER,
    "output_times?": [NUMBER],
    "output?": str,
    "keyframe_steps?": int,
    "columns?": [str],
    "sensitivities?": [str],
    "orientation?": bool,
}
