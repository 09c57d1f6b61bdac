"""Damaged stores: read or continued, they are refused in one sentence, or give what the undamaged
store gives.

A copy of a store is damaged once (a bit, a length, a missing, swapped, empty or foreign file, a
value of its JSON, a link, a pipe), and one command reads or continues it. What is compared: the
JSON of `info`, the bytes of a picture or of a CSV file, all values and attributes that
`tippetop.open` gives, and of a command that continues a store every file of the finished one.

What it cannot see: flags of an unfinished run (they may change until it ends), damage in two places
that fit each other, a forger who computes digests and checksums again, faults of the disk under the
file system, damage while the store is being read, other users' permissions (it runs as one user),
and whatever no command looks at.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import undisturbed
from forking import Done, command
from verdict import Verdict, files


COUNT = 1000
STORES = ("run", "interrupted", "potential", "sweep", "half_a_sweep", "surface", "half_a_surface")
CHEAP = 2  # stores that are made in seconds
PRECIOUS = "nothing of anybody else's is written"


# --- what is done to a store --------------------------------------------------------------------


def _bit(place: Path, rng: np.random.Generator, _: Path) -> str:
    content = bytearray(place.read_bytes())
    if not content:
        content = bytearray(b"x")
    at, bit = int(rng.integers(len(content))), int(rng.integers(8))
    content[at] ^= 1 << bit
    place.write_bytes(content)
    return f"bit {bit} of byte {at}"


def _truncated(place: Path, rng: np.random.Generator, _: Path) -> str:
    size = int(rng.integers(place.stat().st_size + 1))
    os.truncate(place, size)
    return f"cut to {size} bytes"


def _longer(place: Path, rng: np.random.Generator, _: Path) -> str:
    with place.open("ab") as file:
        file.write(rng.bytes(int(rng.integers(1, 100))))
    return "bytes appended"


def _noise(place: Path, rng: np.random.Generator, _: Path) -> str:
    place.write_bytes(rng.bytes(int(rng.integers(1, 5000))))
    return "random bytes"


def _deleted(place: Path, _: np.random.Generator, __: Path) -> str:
    place.unlink()
    return "deleted"


def _empty(place: Path, _: np.random.Generator, __: Path) -> str:
    place.write_bytes(b"")
    return "empty"


def _swapped(place: Path, rng: np.random.Generator, store: Path) -> str:
    others = sorted(
        p for p in store.rglob("*") if p.is_file() and p.name != "zarr.json" and p != place
    )
    other = others[int(rng.integers(len(others)))]
    mine, yours = place.read_bytes(), other.read_bytes()
    place.write_bytes(yours)
    other.write_bytes(mine)
    return f"swapped with {other.relative_to(store)}"


def _copied(place: Path, rng: np.random.Generator, store: Path) -> str:
    others = sorted(p for p in store.rglob(place.name) if p.is_file() and p != place)
    if not others:
        return _empty(place, rng, store)
    other = others[int(rng.integers(len(others)))]
    shutil.copyfile(other, place)
    return f"a copy of {other.relative_to(store)}"


def _folder_gone(place: Path, _: np.random.Generator, store: Path) -> str:
    shutil.rmtree(place.parent)
    return f"folder {place.parent.relative_to(store.parent)} deleted"


def _folder(place: Path, _: np.random.Generator, __: Path) -> str:
    place.unlink()
    place.mkdir()
    return "a folder"


def _pipe(place: Path, _: np.random.Generator, __: Path) -> str:
    place.unlink()
    os.mkfifo(place)
    return "a pipe"


def _link(place: Path, rng: np.random.Generator, store: Path) -> str:
    elsewhere = store.parent / "elsewhere"
    targets = [
        elsewhere / "precious",
        Path("/dev/zero"),
        Path("nowhere"),
        Path(place.name),
        elsewhere,
    ]
    target = targets[int(rng.integers(len(targets)))]
    place.unlink()
    place.symlink_to(target)
    return f"a link to {target}"


def _own_link(place: Path, _: np.random.Generator, store: Path) -> str:
    moved = store.parent / "elsewhere" / "moved"
    shutil.move(place, moved)
    place.symlink_to(moved)
    return "moved elsewhere and linked"


def _folder_link(place: Path, _: np.random.Generator, store: Path) -> str:
    moved = store.parent / "elsewhere" / "moved"
    folder = place.parent if place.parent != store else place
    shutil.move(folder, moved)
    folder.symlink_to(moved)
    return f"{folder.relative_to(store.parent)} moved elsewhere and linked"


def _foreign(place: Path, rng: np.random.Generator, _: Path) -> str:
    name = str(
        rng.choice(
            ["0", "1", "99", "x", "zarr.json", "ledger.jsonl", ".x.part-1", "c.0.new", "c.7"]
        )
    )
    beside = place.with_name(name)
    if beside.exists():
        return _empty(beside, rng, _) if beside.is_file() else "nothing"
    beside.write_bytes(rng.bytes(10))
    return f"a file {name} beside it"


VALUES = (
    0,
    -1,
    1,
    7,
    2**31,
    2**63,
    10**15,
    10**400,
    0.5,
    -0.0,
    1e308,
    True,
    None,
    "",
    "x",
    "../..",
    "é\u0000",
    [],
    {},
    [1],
)


def _json(place: Path, rng: np.random.Generator, store: Path) -> str:
    documents = sorted(store.rglob("*.json"))
    place = documents[int(rng.integers(len(documents)))]
    document = json.loads(place.read_text())
    leaves: list[tuple[Any, Any]] = []

    def walk(node: Any) -> None:
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            leaves.append((node, key))
            if isinstance(value, dict | list):
                walk(value)

    walk(document)
    node, key = leaves[int(rng.integers(len(leaves)))]
    old, way = node[key], int(rng.integers(3))
    if way == 0:
        del node[key]
        words = f"without {key}"
    else:
        number = isinstance(old, int | float) and not isinstance(old, bool) and way == 1
        new = old * 2 + 1 if number else VALUES[int(rng.integers(len(VALUES)))]
        if json.dumps(new) == json.dumps(old):
            return _json(place, rng, store)
        node[key] = new
        words = f"{key}: {str(new)[:40]} instead of {str(old)[:40]}"
    place.write_text(json.dumps(document))
    return f"{place.relative_to(store)} {words}"


WAYS: tuple[Callable[[Path, np.random.Generator, Path], str], ...] = (
    *(_bit,) * 3,
    *(_swapped, _link) * 2,
    *(_json,) * 5,
    *(_truncated, _longer, _noise, _deleted, _empty, _copied, _folder_gone, _folder, _pipe),
    *(_own_link, _folder_link, _foreign),
)


# --- what is asked of it ------------------------------------------------------------------------


def _opened(store: Path) -> Done:
    """What `tippetop.open` gives, as text: every value and attribute."""
    import tippetop
    from tippetop.errors import InputError, StoreError

    try:
        found = tippetop.open(store)
    except (StoreError, InputError) as error:
        return Done(5, "", f"tippetop: {error}")
    groups = [found] if not hasattr(found, "trajectory") else [found.trajectory, found.events]
    parts = []
    for group in groups:
        try:
            values = {str(name): v.values for name, v in group.variables.items()}
        except Exception as error:  # read when needed: the error is xarray's
            return Done(5, "", f"tippetop: {' '.join(str(error).split())}")
        parts.append(
            sorted((name, hashlib.sha256(v.tobytes()).hexdigest()) for name, v in values.items())
        )
        parts.append(json.dumps(group.attrs, default=str, sort_keys=True))
    return Done(0, repr(parts), "")


def _made(words: list[object], out: Path) -> Done:
    """A command that makes a file: what it holds."""
    done = command(*words, "--out", out)
    return (
        done._replace(out=hashlib.sha256(out.read_bytes()).hexdigest()) if done.code == 0 else done
    )


def ask(kind: str, what: str, store: Path) -> Done:
    """The answer of one command, or of the library."""
    beside = store.parent
    again: dict[str, list[object]] = {
        "resume": ["resume", store],
        "sweep": ["sweep", beside / "PLAN.toml", "--out", store, "--workers", 1],
        "surface": [*undisturbed.SURFACE, "--out", beside / "F.zarr"],
    }
    if what == "open":
        return _opened(store)
    if what == "info":
        return command("info", store, "--json")
    if what == "plot":
        return _made(["plot", store], beside / "a.png")
    if what == "export":
        return _made(["export", store, "--to", "csv"], beside / "a.csv")
    done = command(*again[what])
    return done._replace(out="") if done.code == 0 else done


QUESTIONS = {
    "run": ("info", "plot", "export", "open", "resume"),
    "interrupted": ("resume", "resume", "info", "export"),
    "sweep": ("info", "plot", "export", "open", "sweep"),
    "half_a_sweep": ("sweep", "sweep", "info"),
    "surface": ("info", "plot", "open", "surface"),
    "half_a_surface": ("surface",),
    "potential": ("info", "plot", "open"),
}
FINISHED = {
    "resume": "run",
    "sweep": "sweep",
    "surface": "surface",
}  # a command that continues -> the store it ends in


# --- the campaign -------------------------------------------------------------------------------


def _kinds(count: int) -> tuple[str, ...]:
    return STORES if count > 8 else STORES[:CHEAP]


def prepare(folder: Path, count: int, first: int) -> dict[str, Any]:
    """The stores, and the answers of the undamaged."""
    undisturbed.many_chunks()
    stores, answers = {}, {}
    for kind in STORES if first else _kinds(count):
        (folder / kind).mkdir()
        stores[kind] = getattr(undisturbed, kind)(folder / kind)
    for kind in stores:
        for what in dict.fromkeys(QUESTIONS[kind]):
            copy = Path(shutil.copytree(folder / kind, folder / "answering"))
            answers[kind, what] = ask(kind, what, copy / stores[kind].name)
            shutil.rmtree(copy)
    whole = {kind: files(stores[kind]) for kind in FINISHED.values() if kind in stores}
    return {
        "folder": folder,
        "stores": stores,
        "answers": answers,
        "whole": whole,
        "kinds": tuple(stores),
    }


def attack(
    number: int, rng: np.random.Generator, folder: Path, prepared: dict[str, Any]
) -> Verdict:
    """Damages a copy of a store and asks for what is in it, or continues it."""
    kind = prepared["kinds"][number % len(prepared["kinds"])]
    what = QUESTIONS[kind][int(rng.integers(len(QUESTIONS[kind])))]
    store = (
        Path(shutil.copytree(prepared["folder"] / kind, folder / kind))
        / prepared["stores"][kind].name
    )
    elsewhere = folder / kind / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "precious").write_text(PRECIOUS)
    inside = sorted(p for p in store.rglob("*") if p.is_file())
    place = inside[int(rng.integers(len(inside)))]
    if rng.random() < 0.3:  # metadata are few among the files, and decide most
        metadata = [p for p in inside if p.suffix == ".json"]
        place = metadata[int(rng.integers(len(metadata)))]
    way = WAYS[int(rng.integers(len(WAYS)))]
    words = f"{kind}: {place.relative_to(store)}: {way(place, rng, store)}"
    after = (
        place.read_bytes()
        if place.is_file() and place.stat().st_size < 10**6 and not place.is_symlink()
        else None
    )
    repeat = {"damage": words, "question": what, "after": after}
    before = files(elsewhere)
    done, expected = ask(kind, what, store), prepared["answers"][kind, what]
    verdict = done.fault((0, 2, 5))
    if verdict is None:
        verdict = Verdict("refused" if done.code else "same", done.err.strip()[-300:])
        if done.code == 0 and (done.out, done.code) != (expected.out, expected.code):
            verdict = Verdict(
                "wrong", f"{what} of {words}: {_first_difference(done.out, expected.out)}"
            )
        if done.code == 0 and what in FINISHED:
            verdict = (
                _finished(prepared["whole"].get(FINISHED[what]), folder / kind, what) or verdict
            )
    if files(elsewhere) != before:
        verdict = Verdict("wrong", f"{what} of {words} writes elsewhere")
    if verdict.failed:
        verdict.what = f"{what} of {words}: {verdict.what}"
    verdict.repeat = repeat
    return verdict


def _finished(whole: dict[str, bytes] | None, folder: Path, what: str) -> Verdict | None:
    """What is wrong with a store that was continued: files that differ from those of an undisturbed
    one.
    """
    name = {"resume": "R.zarr", "sweep": "S.zarr", "surface": "F.zarr"}[what]
    if whole is None:
        return None
    places = {path: folder / name / path for path in whole}  # what is linked is read there
    differ = [
        p for p, place in places.items() if not place.is_file() or place.read_bytes() != whole[p]
    ]
    return Verdict("wrong", f"differs in {', '.join(differ[:5])}") if differ else None


def _first_difference(found: str, expected: str) -> str:
    at = next((i for i, (a, b) in enumerate(zip(found, expected, strict=False)) if a != b), 0)
    return (
        f"...{found[max(0, at - 60) : at + 60]}... instead of "
        f"...{expected[max(0, at - 60) : at + 60]}..."
    )
