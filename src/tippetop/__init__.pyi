import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as _np
import xarray as _xr

from . import benchmark as benchmark
from . import derivatives as derivatives
from . import errors as errors
from . import extending as extending
from . import friction as friction
from . import landscapes as landscapes
from . import theory as theory
from .columns import dataframe as dataframe
from .errors import InputError as InputError
from .errors import Interrupted as Interrupted
from .errors import StoreError as StoreError
from .exchange.likelihood import LogLikelihood
from .library.exchanging import Comparison, Fitted
from .library.finished_run import Run as Run
from .library.likelihoods import posterior as posterior
from .library.running import open as open
from .library.running import resume as resume
from .library.stored_run import StoredRun as StoredRun
from .mechanics.contact.body import Top
from .mechanics.event import Event
from .mechanics.form import Quantity
from .mechanics.friction import FrictionLaw
from .mechanics.system import System
from .mechanics.systems.cylinder import Cylinder as Cylinder
from .mechanics.systems.ellipsoid import Ellipsoid as Ellipsoid
from .mechanics.systems.heavy_top import HeavyTop as HeavyTop
from .mechanics.systems.revolution import Disc as Disc
from .mechanics.systems.revolution import Spheroid as Spheroid
from .mechanics.systems.tippe_top import TippeTop as TippeTop
from .problem.problem import Problem as Problem
from .runs.starting import load as load
from .scenario.reading import presets as presets
from .sweeps.plan import Plan

__version__: str

def compare(
    others: str | Path | Sequence[str | Path],
    reference: Any,
    *,
    quaternion: str | None = ...,
    up: str = ...,
    track: str | None = ...,
    chip: Sequence[float] | str | None = ...,
) -> Comparison: ...
def ensemble(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    variations: Mapping[str, Any],
    friction: Any = ...,
    *,
    threads: int | None = ...,
    progress: Callable[[int, int], None] | bool = ...,
    orientation: bool = ...,
    lyapunov: bool = ...,
    event_table: bool = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    air: Mapping[str, Any] | None = ...,
    plane: Mapping[str, Any] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | _np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
) -> Any: ...
def fit(
    data: str | Path,
    scenario: Any,
    free: str | Sequence[str],
    *,
    loss: str = ...,
    starts: int = ...,
    within: float = ...,
    systematic: bool = ...,
    laws: Sequence[str | Mapping[str, Any]] | str = ...,
    progress: Callable[[int, int], None] | bool = ...,
    marker: Sequence[float] | str | None = ...,
    noise: float | str | None = ...,
    quaternion: str | None = ...,
    up: str = ...,
    track: str | None = ...,
    chip: Sequence[float] | str | None = ...,
) -> Fitted: ...
def log_likelihood(
    data: str | Path,
    scenario: Any,
    free: str | Sequence[str],
    *,
    marker: Sequence[float] | str | None = ...,
    noise: float | str | None = ...,
    quaternion: str | None = ...,
    up: str = ...,
    track: str | None = ...,
    chip: Sequence[float] | str | None = ...,
) -> LogLikelihood: ...
def run(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    friction: FrictionLaw | tuple | Mapping[str, Any] | None = ...,
    *,
    out: str | Path | None = ...,
    overwrite: bool = ...,
    progress: bool = ...,
    stop: threading.Event | None = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    air: Mapping[str, Any] | None = ...,
    plane: Mapping[str, Any] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | _np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    orientation: bool | None = ...,
) -> Run: ...
def sweep(
    plan: str | Path | Mapping[str, Any] | Plan,
    out: str | Path,
    *,
    events: Iterable[str | Event] | str | Event | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    workers: int | None = ...,
    scheduler: str | None = ...,
    progress: Callable[[int, int], None] | bool = ...,
    stop: threading.Event | None = ...,
    overwrite: bool = ...,
) -> _xr.Dataset: ...
