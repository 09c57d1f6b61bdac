"""The checkpoint of a run: what is acknowledged, with a digest of itself and of the root attributes that it belongs to.

The root attributes hold the scenario, precision, tolerance, versions and processor; the record holds the fingerprint of
the equations. A digest finds damage and edits, not a forger, who makes a new digest.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

from ..errors import StoreError
from . import files


CHECKPOINT = "checkpoint.json"
SCENARIO, DIGEST = "root_attributes", "digest"
FIELDS: dict[str, Any] = {
    "versions": dict,
    "cpu": str,
    "rows": int,
    "events": int,
    "digests": list,
    "integration": dict,
    "report": dict,
    "reason": str,
    "begun_with": list,
}


def digest(value: Any) -> str:
    """SHA-256 of plain data, whatever the order of its keys; hexadecimal."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, allow_nan=False).encode()).hexdigest()


def write(folder: Path, record: dict[str, Any], of: str) -> None:
    """Writes a record whole or not at all; `of` is the digest of the root attributes. Raises OSError."""
    bound = {**record, SCENARIO: of}
    files.replace_text(folder / CHECKPOINT, json.dumps({**bound, DIGEST: digest(bound)}, allow_nan=False))


def read(folder: Path, attributes: dict[str, Any]) -> dict[str, Any]:
    """The record of a store with these root attributes, as they stand there.

    Raises FileNotFoundError where there is none, StoreError where it is damaged or was written for others.
    """
    try:
        stored = json.loads((folder / CHECKPOINT).read_text(encoding="utf-8"))
        bound = {key: value for key, value in stored.items() if key != DIGEST}
        if stored[DIGEST] != digest(bound):
            raise ValueError("its digest is another")
        if wrong := [key for key, kind in FIELDS.items() if type(stored[key]) is not kind]:
            raise ValueError(f"`{wrong[0]}` has another type")
        scenario = stored[SCENARIO]
    except FileNotFoundError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise StoreError(
            f"`{folder}` must have a whole checkpoint of this release to be resumed, but: {error}."
        ) from None
    if scenario != digest(attributes):
        raise StoreError(
            f"`{folder}` must have the scenario and versions of its checkpoint, but its root attributes were changed."
        )
    return stored
