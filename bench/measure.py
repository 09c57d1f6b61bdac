"""Interleaved repetitions on processor clocks, and what they were made on."""

import importlib.metadata
import importlib.util
import os
import platform
import statistics
import time
from collections.abc import Callable, Hashable, Mapping
from typing import Any


PACKAGES = (
    "tippetop",
    "heyoka",
    "numpy",
    "numba",
    "llvmlite",
    "scipy",
    "numbalsoda",
    "diffrax",
    "jax",
    "xarray",
    "zarr",
)


def interleaved(
    works: Mapping[Hashable, Callable[[], float]], rounds: int
) -> dict[Hashable, list[float]]:
    """The seconds of every contestant in every round: each round runs all of them, so that
    neighbours in time compare.

    One round before is not counted.
    """
    found: dict[Hashable, list[float]] = {name: [] for name in works}
    for i in range(rounds + 1):
        for name, work in works.items():
            seconds = work()
            if i:
                found[name].append(seconds)
    return found


def timed(work: Callable[[], Any]) -> float:
    """Processor seconds of this process [s]: other people's work on the machine is not counted."""
    clock = time.process_time()
    work()
    return time.process_time() - clock


def elapsed(work: Callable[[], Any]) -> float:
    """Seconds by the wall clock [s]."""
    clock = time.perf_counter()
    work()
    return time.perf_counter() - clock


def ratio(slow: list[float], fast: list[float]) -> float:
    """Median of the ratios of neighbouring repetitions."""
    return statistics.median(a / b for a, b in zip(slow, fast, strict=True))


def machine() -> dict[str, Any]:
    """Processor, load and versions, for the results."""
    return {
        "processor": _processor(),
        "processors": os.cpu_count(),
        "load_average": [round(x, 2) for x in os.getloadavg()],
        "python": platform.python_version(),
        "versions": {name: version for name in PACKAGES if (version := _version(name))},
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as lines:
            fields = {
                key.strip(): value.strip()
                for key, _, value in (line.partition(":") for line in lines)
            }
        return f"{fields['model name']}, family {fields['cpu family']}, model {fields['model']}"
    except (OSError, KeyError):
        return platform.machine()


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
