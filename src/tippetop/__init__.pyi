import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from .engine.status import Status as Status
from .errors import InputError as InputError
from .errors import Interrupted as Interrupted
from .errors import StoreError as StoreError
from .errors import Unfinished as Unfinished
from .library.asymptotics import accelerations as accelerations
from .library.asymptotics import asymptotic_states as asymptotic_states
from .library.asymptotics import least_energy as least_energy
from .library.bodies import Cylinder as Cylinder
from .library.bodies import HeavyTop as HeavyTop
from .library.bodies import TippeTop as TippeTop
from .library.bodies import Top
from .library.derivatives import Sensitivities as Sensitivities
from .library.exchanging import Comparison as Comparison
from .library.exchanging import Fitted as Fitted
from .library.exchanging import compare as compare
from .library.exchanging import fit as fit
from .library.landscapes import band as band
from .library.landscapes import marked_lines as marked_lines
from .library.landscapes import minimal_surface as minimal_surface
from .library.landscapes import potential as potential
from .library.landscapes import turning_angles as turning_angles
from .library.laws import Contensou as Contensou
from .library.laws import Coulomb as Coulomb
from .library.laws import Friction
from .library.laws import Frictionless as Frictionless
from .library.laws import Latitude as Latitude
from .library.laws import Mixed as Mixed
from .library.laws import Modified as Modified
from .library.laws import Stribeck as Stribeck
from .library.laws import Viscous as Viscous
from .library.registering import LAWS as LAWS
from .library.registering import SYSTEMS as SYSTEMS
from .library.registering import register as register
from .library.run import Run as Run
from .library.running import datasets as datasets
from .library.running import integrate as integrate
from .library.running import open as open
from .library.running import resume as resume
from .library.stored_run import StoredRun as StoredRun
from .library.theory import linear_modes as linear_modes
from .library.theory import nutation as nutation
from .library.theory import reconstruct as reconstruct
from .library.theory import regime as regime
from .library.theory import thresholds as thresholds
from .mechanics.events import Event as Event
from .mechanics.events import Kept as Kept
from .mechanics.friction import Law as Law
from .mechanics.system import Parameter as Parameter
from .mechanics.system import Quantity as Quantity
from .mechanics.system import System as System
from .mechanics.units import Unit as Unit
from .problem import Problem as Problem
from .runs.results import Summary as Summary
from .runs.starting import load as load
from .scenario.reading import presets as presets
from .store.root import open_group as open_group
from .sweeps.summary import gridded as gridded
from .sweeps.sweep import sweep as sweep

__version__: str

def lyapunov(
    source: Any,
    friction: Any = ...,
    *,
    rows: int = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    initial: Mapping[str, Any] | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    sensitivities: Sequence[str] | None = ...,
    orientation: bool | None = ...,
) -> xr.Dataset: ...
def sensitivities(
    source: Any,
    wrt: Sequence[str],
    friction: Any = ...,
    *,
    order: int = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    initial: Mapping[str, Any] | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    sensitivities: Sequence[str] | None = ...,
    orientation: bool | None = ...,
) -> Sensitivities: ...
def ensemble(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    variations: Mapping[str, Any],
    friction: Any = ...,
    *,
    threads: int | None = ...,
    progress: Callable[[int, int], None] | bool = ...,
    orientation: bool = ...,
    lyapunov: bool = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    initial: Mapping[str, Any] | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    sensitivities: Sequence[str] | None = ...,
) -> xr.Dataset: ...
def run(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    friction: Friction | tuple | Mapping[str, Any] | Sequence[str] | None = ...,
    *,
    out: str | Path | None = ...,
    overwrite: bool = ...,
    progress: bool = ...,
    stop: threading.Event | None = ...,
    start: Mapping[str, Any] | str | Path | None = ...,
    initial: Mapping[str, Any] | None = ...,
    parameters: Mapping[str, Any] | None = ...,
    system: str | System | None = ...,
    form: str | None = ...,
    contact: Mapping[str, Any] | None = ...,
    stem: Mapping[str, float] | None = ...,
    until: float | str | None = ...,
    output_step: float | str | None = ...,
    output_times: Sequence[float] | np.ndarray | Any | None = ...,
    output: Literal["times", "events", "steps", "keyframes"] | None = ...,
    keyframe_steps: int | None = ...,
    stop_when: Literal["until", "settled"] | None = ...,
    events: Iterable[str | Event] | str | Event | None = ...,
    on_liftoff: Literal["stop", "continue", "fly"] | None = ...,
    precision: Literal["double", "longdouble", "quad"] | None = ...,
    tolerance: float | None = ...,
    columns: Iterable[str | Quantity] | str | Quantity | None = ...,
    sensitivities: Sequence[str] | None = ...,
    orientation: bool | None = ...,
) -> Run: ...
