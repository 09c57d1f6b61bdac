from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as _np
import xarray as _xr

from .library.derivatives import Sensitivities as Sensitivities
from .mechanics.event import Event
from .mechanics.form import Quantity
from .mechanics.system import System

def lyapunov(
    source: Any,
    friction: Any = ...,
    *,
    rows: int = ...,
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
) -> _xr.Dataset: ...
def sensitivities(
    source: Any,
    wrt: Sequence[str],
    friction: Any = ...,
    *,
    order: int = ...,
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
) -> Sensitivities: ...
