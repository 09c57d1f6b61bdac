"""What came of one attack, and the table of many."""

import base64
import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any


FINE = {
    "same": "the result of an undisturbed store, run or witness",
    "refused": "one sentence and a documented exit code",
    "broken": "a broken accuracy contract, with its exit code",
}
FAILURES = {
    "lost": "what was acknowledged is gone",
    "wrong": "exit code 0 or no error, and another result",
    "traceback": "an error that is no sentence of ours",
    "hang": "no end within the limit",
    "crash": "the process died by itself",
    "unsaid": "an exit code without its sentence, or one that is not documented",
    "litter": "something is left beside or inside the result",
}


@dataclass
class Verdict:
    """One attack: `tries` is what it counts for (kills of a chain), `repeat` is what repeats it."""

    kind: str
    what: str = ""
    tries: int = 1
    repeat: dict[str, Any] = field(default_factory=dict)
    campaign: str = ""
    number: int = -1
    seconds: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether it found something to mend."""
        return self.kind in FAILURES

    def line(self) -> str:
        """As a line of the results file."""
        return json.dumps(asdict(self), default=_plain)


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return {"base64": base64.b64encode(value[:100_000]).decode(), "bytes": len(value)}
    return value.tolist() if hasattr(value, "tolist") else str(value)


def table(verdicts: Iterable[Verdict], campaigns: Iterable[str]) -> str:
    """A row for each campaign, a column for each kind."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in campaigns}
    for v in verdicts:
        counts[v.campaign][v.kind] += v.tries
        counts[v.campaign]["cases"] += 1
        counts[v.campaign]["seconds"] += v.seconds  # type: ignore[assignment]
    kinds = [*FINE, *FAILURES]
    rows = [("campaign", "cases", "tries", *kinds, "seconds")]
    for name, count in counts.items():
        numbers = [count[kind] for kind in kinds]
        rows.append(
            (
                name,
                *(str(n) for n in (count["cases"], sum(numbers), *numbers)),
                f"{count['seconds']:.0f}",
            )
        )
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(f"{w:>{n}}" for w, n in zip(row, widths, strict=True)) for row in rows
    )


def files(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, by its path inside; links and pipes by what they are."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = b"link to " + str(path.readlink()).encode()
        elif path.is_file():
            found[name] = path.read_bytes()
        elif not path.is_dir():
            found[name] = b"neither file nor folder"
    return found


def difference(mine: dict[str, bytes], yours: dict[str, bytes]) -> str:
    """How two folders differ, in words; empty if they do not."""
    extra, missing = sorted(mine.keys() - yours.keys()), sorted(yours.keys() - mine.keys())
    other = [name for name in mine if name in yours and mine[name] != yours[name]]
    words = {"too many": extra, "missing": missing, "another content": other}
    return "; ".join(f"{what}: {', '.join(names[:4])}" for what, names in words.items() if names)
