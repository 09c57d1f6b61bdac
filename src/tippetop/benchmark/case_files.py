"""The cases as files that a simulator can read without Python.

`Case`s go in; folders with a reference, a scenario and texts come out.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData, path_of
from ..columns import flag_words
from ..exchange.fit_result import toml_of
from ..exchange.simulators import DIGITS, formats_of, gravity, rounded_to_digits, text_of
from ..runs import phases
from ..runs.run import Solution
from ..runs.shape import moments, surface_of
from ..scenario import build
from ..store import files as disk
from .named_cases import Case, case, names
from .outcome import outcome
from .truth import VECTORS, Truth, sample_times, truth


VERSION = "1"
"""Version of the cases. It changes with any number of a reference."""

MODELS = {"mjcf": "model.mjcf.xml", "urdf": "model.urdf", "sdf": "model.sdf"}
FRAMES = {
    "space": "right-handed, z up, the plane is z = 0; the tip of `joint` is the origin",
    "body": "origin at the centre of mass, z along the axis of symmetry",
    "quaternion": "q_w, q_x, q_y, q_z turns body axes into space axes",
    "model": "in MJCF the body frame is at the centre of the ball or the tip; see each model",
}
UNITS = {
    "t": "s",
    "x, y, z": "m, centre of mass",
    "vx, vy, vz": "m/s, centre of mass",
    "omega_x, omega_y, omega_z": "rad/s, in the space frame",
    "force_x, force_y, force_z": "N, total contact force on the body; of `joint` that of the joint",
}
CONTENT = {
    "scenario.toml": "the case for tippetop",
    "model.mjcf.xml": "the body, its start and friction as MJCF",
    "model.urdf": "the body as URDF; start and friction in a comment",
    "model.sdf": "the body, its pose and friction as SDF",
    "reference.csv": "the exact motion",
    "reference.parquet": "the same as Parquet",
    "phases.csv": "phases of the contact",
    "impacts.csv": "impacts with their impulses",
}
README = """# Contact benchmark of tippetop, version {version}

Exact motions of rigid bodies with friction, spin and impacts, for developers of contact simulators.
Each folder is a case; `case.json` describes it, with the
numbers of its body, law and start (`case.schema.json` is its schema).

1. Read `model.mjcf.xml`, `model.urdf` or `model.sdf`.
   A folder lacks the models that cannot express its body: URDF has no ellipsoid, and none of them a
   rounded rim. `outline` in `case.json` describes such a body.
   The first row of `reference.csv` is the start.
2. Write `ENGINE/SETTING/CASE/dt=STEP.csv` with the columns of `reference.csv`.
   `t [s]` and the quaternion `q_w,q_x,q_y,q_z` are required, the other columns are optional.
3. Install the score, `pip install tippetop`, and run `tippetop benchmark score ENGINE`.
   One file with another name: `tippetop benchmark score FILE --case CASE`.

`case.json` contains the certified error of the reference and its horizon.
Beyond the horizon a small error of the start has grown so much that a difference means nothing
about an engine.
Numbers have 12 significant digits of the largest number of their vector.

The score compares each row of a result with the reference at its time, up to the horizon.
STEP is in seconds; with several steps the score prints the order of convergence.
`order` is log(e1/e2)/log(h1/h2) of the root mean square error e of the attitude at this step h2 and
the next larger one h1.
It is blank (`-`) without such a step, where one of the two attitudes is ever off by more than 1 rad
(its error is saturated and hardly depends on the step), and where the errors are rounding errors.
Rows may start later than at 0: an engine that has no contact force there leaves out that row.

| score | largest difference of |
| --- | --- |
| `attitude`, `theta` | the angle between the two attitudes; the angle of the axis to the vertical |
| `position` | the centre of mass (not the centre of the ball) |
| `spin` | the angular velocity about the axis of the body |
| `energy` | the energy, relative to that at the start |
| `force` | the force of the plane on the body, a vector, by its weight; not the mean over a step |

`rms` and `mean` are the root mean square and the mean of such differences over the rows, `at` is
the time of the largest one.

The outcome is judged by the rows alone:

| outcome | meaning | needs |
| --- | --- | --- |
| `turns over` | theta passes pi/2 | the quaternion |
| `lifts off` | the body rises by more than 1 % of its size after a contact | the position |
| `rises as high` | the largest rise after a contact is within a factor of two | the position |
| `lands on the stem` | the stem touches the plane | the position |
| `sticks` | the contact point is slower than 2 % of sqrt(g R) at the end | all but the force |

The velocity has no score of its own.

`phases.csv` lists the phases of the contact with start, end and the ball that touches.

| column | value | meaning |
| --- | --- | --- |
| `phase` | `flight`, `slip`, `roll` | no contact; the contact point slides; it does not |
| `phase` | `both` | the ball and the stem touch; `ball` is `body` |
| `phase` | `rest` | it rolls and does not turn about the vertical: the friction disc is held |
| `ball` | `body`, `stem` | the ball that touches; in flight the ball that left or bounced last |
| `reason` | `start` | start of the case |
| `reason` | `stick`, `slip` | the sliding speed became zero; friction no longer prevented sliding |
| `reason` | `liftoff`, `landing` | the contact force became zero; a ball struck the plane |
| `reason` | `other-ball`, `other-leaves` | the other ball struck the plane, or left it |
| `reason` | `opens-at-once` | the contact opened directly after an impact |
| `reason` | `rests`, `gives` | friction on a disc holds the body; it no longer does |

`impacts.csv` lists the impacts: the velocity of the contact point along the vertical `v_n`
(upwards positive) and its sliding `speed` before and after, and the impulse of the plane on the
body: `impulse` is its vertical part (upwards, never negative), `friction_impulse` the size of its
horizontal part, without a sign.
Its direction is that of the jump of `vx`, `vy` in `reference.csv`.
`work` is that of the impulse on the body (negative: energy lost).
`mode` is `slip` if the contact point slides throughout, `stick` if sliding ends within the impact,
and `reverse` if it ends and starts again in another direction.

| case | title |
| --- | --- |
{rows}
"""
LICENSE = """The data in this folder are dedicated to the public domain under CC0 1.0 Universal.
https://creativecommons.org/publicdomain/zero/1.0/
"""


def export(
    folder: str | Path, cases: Iterable[str | Path] = (), *, overwrite: bool = False
) -> list[Path]:
    """Write cases as files.

    Parameters
    ----------
    folder : str or path
        Created if missing.
    cases : iterable of str or path, optional
        Names, or TOML files of scenarios; by default all names.
    overwrite : bool, optional
        Replace existing files.

    Returns
    -------
    list of path
        The files.

    Raises
    ------
    InputError
        If a case is unknown, or a scenario is no case; see `case`.
    StoreError
        If a file exists or cannot be written.
    """
    root = path_of("folder", folder)
    chosen = [case(name) for name in dict.fromkeys(cases or names())]
    # all folders first: one that cannot be made is refused before the long runs
    for each in chosen:
        with disk.writing(root / each.name):
            (root / each.name).mkdir(parents=True, exist_ok=True)
    made = []

    def write(name: str, text: str) -> None:
        """Write a text file of the folder, and append its path to `made`."""
        disk.write_text(root / name, text, overwrite=overwrite)
        made.append(root / name)

    for each in chosen:
        for name, text in _texts(each, root / each.name, overwrite).items():
            write(f"{each.name}/{name}", text)
        made.append(root / each.name / "reference.parquet")
    present = sorted(path.parent.name for path in root.glob("*/case.json"))
    present.sort(key=[*names(), *present].index)
    titles = [
        json.loads((root / name / "case.json").read_text("utf-8"))["title"] for name in present
    ]
    rows = "\n".join(map("| `{}` | {} |".format, present, titles))
    write("README.md", README.format(version=VERSION, rows=rows))
    write("LICENSE", LICENSE)
    write("VERSION", f"{VERSION}\n")
    schema = (files(__package__) / "case.schema.json").read_text(encoding="utf-8")
    write("case.schema.json", schema)
    # cases of an earlier export are listed too
    others = [root / each / name for each in present for name in (*CONTENT, "case.json")]
    sums = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(root).as_posix()}"
        for path in sorted({*made, *others})
        if path.is_file()
    ]
    write("SHA256SUMS", "\n".join(sums) + "\n")
    return made


def _texts(given: Case, folder: Path, overwrite: bool) -> dict[str, str]:
    """Return the text files of a case by name, and write the Parquet file into `folder`.

    All but `case.json` are in `CONTENT`: checksums are made of those, and `score` skips them.
    """
    problem = given.problem
    tables = build.resolved(problem)
    tables["run"] = {key: tables["run"][key] for key in ("until", "output_step")}
    motion, run = truth(problem, sample_times(problem), "longdouble")
    columns = _columns(motion, given.certificate.get("rounding", {}))
    columns["phase"] = np.full(len(motion.t), "joint")
    if problem.contact is not None:
        columns["phase"] = flag_words(run.columns()["phase"])
    texts = {
        "scenario.toml": toml_of(tables).strip() + "\n",
        **{MODELS[to]: text_of(problem, to) for to in formats_of(problem)},
        "reference.csv": _csv(columns),
        **{f"{name}.csv": _csv(table) for name, table in _tables(run).items()},
    }
    _parquet(columns, folder / "reference.parquet", overwrite)
    description = _description(given, motion, columns, [*texts, "reference.parquet"])
    return texts | {"case.json": json.dumps(description, indent=2) + "\n"}


def _description(
    given: Case, motion: Truth, columns: Mapping[str, np.ndarray], made: list[str]
) -> PlainData:
    """Return the content of `case.json`; `made` are the names of the other files.

    `case.schema.json` lists the keys, and allows no others. The start is the first row of the
    rounded `columns` by header. As in `_columns`, bytes must be equal on every processor.
    """
    problem = given.problem
    body = problem.body()
    tables = build.resolved(problem)
    return {
        "name": given.name,
        "version": VERSION,
        "title": given.title,
        "text": given.text,
        "page": f"docs/benchmark.md#{given.name}" if given.name in names() else "",
        "until": problem.until,
        "horizon": given.horizon,
        "certified_error": given.certificate["error"],
        "certificate": {
            key: value
            for key, value in given.certificate.items()
            if key not in ("error", "rounding")
        },
        "body": {
            "mass": body.m,
            "moments_of_inertia": moments(body).tolist(),
            "gravity": body.g,
            "slope": gravity(body)[:2].tolist(),
            "balls": {
                name: {"offset": ball.c, "radius": ball.R}
                for name, ball in problem.balls.items()
                if not ball.outline and ball.R
            },
            "outline": _outline(body),
            "fixed_point": body.c if problem.contact is None else None,
        },
        "friction_law": given.law["words"],
        "law": {name: tables[name] for name in ("friction", "contact") if name in tables},
        "start": {
            name: [float(columns[header][0]) for header in headers]
            for name, headers in VECTORS.items()
            if name != "force"
        },
        "settings": given.settings,
        "frames": FRAMES,
        "units": UNITS,
        "outcome": outcome(problem, motion),
        "files": {name: words for name, words in CONTENT.items() if name in made},
    }


def _outline(body: Any) -> PlainData | None:
    """Return the surface of a body without balls: an ellipsoid, or its name and numbers.

    It is `outline` of the body in `case.json`, None where balls describe the surface.
    """
    outline = body.outline
    surface = surface_of(body)
    if not outline:
        return None
    if len(surface.meridian):
        return {"kind": type(outline).__name__.lower(), **outline._asdict()}
    return {
        "kind": "ellipsoid",
        "half_axes": surface.half.tolist(),
        "centre": surface.centre.tolist(),
        "turn": surface.turn,
    }


def _columns(motion: Truth, thresholds: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return the columns of a reference by header, rounded.

    A number is rounded up if the fraction of its last digit exceeds the threshold of its column, by
    default 0.5. `bench.certificates` finds those of named cases: no number is near one, so that
    last bits, which differ between processors, change no byte.
    """
    columns = {"t [s]": rounded_to_digits(motion.t)}
    for header, (values, power) in scaled(motion).items():
        # + 0.0 makes 0.0 of -0.0
        columns[header] = np.floor(values + 1 - thresholds.get(header, 0.5)) / power + 0.0
    return columns


def scaled(motion: Truth) -> dict[str, tuple[np.ndarray, float]]:
    """Return by header the numbers of a motion in units of their last digit, and 1/unit."""
    columns: dict[str, tuple[np.ndarray, float]] = {}
    for name, headers in VECTORS.items():
        values = getattr(motion, name).astype(float)
        largest = np.abs(values).max() or 1.0
        power = 10.0 ** (DIGITS - 1 - math.floor(math.log10(largest)))
        columns |= {h: (column * power, power) for h, column in zip(headers, values.T, strict=True)}
    return columns


def _tables(run: Solution) -> dict[str, dict[str, Any]]:
    """Return phases and impacts by column; without tables that have no rows.

    Exported headers have m/s, as those of `VECTORS`, where stores have m s-1.
    """
    result: dict[str, dict[str, Any]] = {}
    for name, table in phases.joined(run.problem.system, run.others).items():
        columns: dict[str, Any] = {}
        for key, column in table.items():
            if "flag_meanings" in column.attrs:
                columns[key] = flag_words(column)
                continue
            unit = column.attrs["units"]
            # digits of the largest number of its unit, so that zeros have no rounding errors
            alike = [c.values for c in table.values() if c.attrs["units"] == unit]
            end = [run.problem.until] if unit == "s" else []
            numbers = rounded_to_digits(np.concatenate([column.values, *alike, end]))
            header = f"{key} [{unit.replace('m s-1', 'm/s')}]"
            columns[header] = numbers[: len(column.values)]
        if len(next(iter(columns.values()))):
            result[name] = columns
    return result


def _csv(columns: Mapping[str, Any]) -> str:
    """Return columns, by header, as the text of a CSV file with 12 digits.

    The digits are those of `_parquet` and of DIGITS: a change of one is a change of all.
    """
    from pandas import DataFrame

    return DataFrame(columns).to_csv(index=False, float_format="%.12g", lineterminator="\n")


def _parquet(columns: dict[str, Any], path: Path, overwrite: bool) -> None:
    """Write columns as Parquet, with the numbers of the CSV file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table(
        {
            name: values if values.dtype.kind == "U" else [float(f"{v:.12g}") for v in values]
            for name, values in columns.items()
        }
    )
    with disk.replacing(path, overwrite=overwrite) as scratch:
        pq.write_table(table, scratch)
