"""The origin of a store: format, versions, processor.

Attributes of every store; resuming compares them with those of the present process.
"""

import os
import platform
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any


FORMAT = "tippetop"
FORMAT_VERSION = 2


@lru_cache
def versions() -> dict[str, str]:
    """Return the versions of the packages that a result depends on."""
    packages = {name: version(name) for name in ("tippetop", "heyoka", "numpy", "zarr")}
    return {"python": platform.python_version(), **packages}


@lru_cache
def cpu() -> str:
    """Return the model of the processor: results are bit-identical only on the same one."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def provenance() -> dict[str, Any]:
    """Return the attributes of every store: format, versions, processor.

    `runs.resuming.same_here` compares `versions` and `cpu`, sweeps too; the others are for people.
    """
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "Conventions": "CF-1.11",
        "versions": versions(),
        "cpu": cpu(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors",
    }
