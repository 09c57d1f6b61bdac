"""What a run needs to be continued, in a JSON record with a digest of itself and of the root attributes it belongs to.

`checkpoint.json` of an unfinished run says what is acknowledged; the root attribute `end` of a finished one keeps where
its last slice began, and its end. The other root attributes hold the scenario, precision, tolerance, versions and
processor; the record holds the fingerprint of the equations. A digest finds damage and edits, not a forger, who makes a
new digest.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

from ..errors import StoreError
from . import files


CHECKPOINT = "checkpoint.json"
END, END_FILE = "end", "end.json"  # a root attribute; the file in which the first stores kept it
SCENARIO, DIGEST = "root_attributes", "digest"
LATER = ("certificate", "seal", END)  # attributes that a finished store gets, which say nothing of how it was made
DERIVED = ("sensitivities", "event_sensitivities")  # made at the end of a run: none of their rows is acknowledged
ROWS = {name: name for name in ("events", "keyframes", "phases", "impacts", *DERIVED)} | {"trajectory": "rows"}
"""What a checkpoint calls the rows of a group."""

FIELDS: dict[str, dict[str, Any]] = {
    CHECKPOINT: {
        "versions": dict,
        "cpu": str,
        "rows": int,
        "events": int,
        "keyframes": int,
        "phases": int,
        "impacts": int,
        **dict.fromkeys(DERIVED, int),
        "digests": dict,
        "integration": dict,
        "report": dict,
        "reason": str,
        "begun_with": list,
    },
    END: {"slice": dict, "end": dict},
}


def digest(value: Any) -> str:
    """SHA-256 of plain data, whatever the order of its keys; hexadecimal."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, allow_nan=False).encode()).hexdigest()


def digest_of_finished(attributes: dict[str, Any]) -> str:
    """The digest of the root attributes of a finished store, whatever was added to them later."""
    return digest({key: value for key, value in attributes.items() if key not in LATER})


def bound(record: dict[str, Any], of: str) -> dict[str, Any]:
    """A record with the digests that bind it: `of`, that of the root attributes, and its own."""
    whole = {**record, SCENARIO: of}
    return {**whole, DIGEST: digest(whole)}


def write(folder: Path, record: dict[str, Any], of: str) -> None:
    """Writes a checkpoint whole or not at all; `of` is the digest of the root attributes. Raises OSError."""
    files.replace_text(folder / CHECKPOINT, json.dumps(bound(record, of), allow_nan=False))


def read(folder: Path, attributes: dict[str, Any], name: str = CHECKPOINT) -> dict[str, Any]:
    """The record of a store with these root attributes, as they stand there: its checkpoint, or its end.

    Raises FileNotFoundError where there is none, StoreError where it is damaged or was written for others.
    """
    what, to_be = ("checkpoint", "resumed") if name == CHECKPOINT else (f"root attribute `{END}`", "continued")
    try:
        if name == END and END in attributes:
            stored = attributes[END]
        else:
            stored = json.loads((folder / (END_FILE if name == END else name)).read_text(encoding="utf-8"))
        if stored[DIGEST] != digest({key: value for key, value in stored.items() if key != DIGEST}):
            raise ValueError("its digest is another")
        if name == CHECKPOINT:  # one that was written before a contact could change its phase has no such tables
            stored = {"phases": 0, "impacts": 0, **dict.fromkeys(DERIVED, 0), **stored}
        if wrong := [key for key, kind in FIELDS[name].items() if type(stored[key]) is not kind]:
            raise ValueError(f"`{wrong[0]}` has another type")
        scenario = stored[SCENARIO]
    except FileNotFoundError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        whole = f"`{folder}` must have a whole {what}, as this release writes it, to be {to_be}"
        raise StoreError(f"{whole}, but: {error}.") from None
    if scenario != (digest_of_finished if name == END else digest)(attributes):
        raise StoreError(
            f"`{folder}` must have the scenario and versions of its {what}, but its root attributes were changed."
        )
    return stored
