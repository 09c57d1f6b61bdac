"""Compile the loop on installation: with $CC, the system's compiler, or PyPI's ziglang."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


SOURCE = Path(__file__).parent / "kernels" / "tippetop_kernels" / "loop.c"
BUILT = SOURCE.with_suffix(".so")
FLAGS = ["-std=c11", "-O3", "-shared", "-fPIC"]
# Stored runs continue bit by bit, so no operation may be reordered or fused.
FLAGS += ["-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
# Minor versions of glibc for which auditwheel has a platform tag.
MANYLINUX = 17, 24, 26, 27, 28, 31, 34, 35, 36, 37, 38, 39, 40, 41


def compiler() -> list[str]:
    """Return the command of the C compiler of this machine; empty without a compiler."""
    if named := os.environ.get("CC"):
        return named.split()
    return next(([path] for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), [])


def build() -> None:
    """Compile the loop next to its source."""
    command = compiler() or [sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline"]
    digest = hashlib.sha256(SOURCE.read_bytes()).hexdigest()
    define = f'-DDIGEST="{digest}"'
    subprocess.run([*command, *FLAGS, define, str(SOURCE), "-o", str(BUILT), "-lm"], check=True)


def platform() -> str:
    """Return the platform of the wheel.

    On Linux, the newest version of glibc that the loop requires decides: the oldest tag that
    distributors of wheels use and that includes it.
    """
    name = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    versions = [int(version) for version in re.findall(rb"GLIBC_2\.(\d+)", BUILT.read_bytes())]
    oldest = next((tag for tag in MANYLINUX if tag >= max(versions, default=0)), None)
    return name.replace("linux", f"manylinux_2_{oldest}") if versions and oldest else name


class LoopBuildHook(BuildHookInterface):
    """Add the compiled loop to wheels and editable installs."""

    def dependencies(self) -> list[str]:
        """Return what the build needs: a compiler, where the machine has none."""
        return [] if self.target_name == "sdist" or compiler() else ["ziglang>=0.14"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and name the platform of the wheel: any Python, one machine."""
        if self.target_name == "sdist":
            return
        build()
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform()}"


if __name__ == "__main__":
    build()
