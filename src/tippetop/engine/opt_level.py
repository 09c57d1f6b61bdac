"""The optimisation level of LLVM, which an environment variable can lower to compile faster.

Compiled code depends on it, so fingerprints and caches contain it.
"""

import os

from ..errors import InputError


OPT_LEVEL = "TIPPETOP_OPT_LEVEL"
DEFAULT = 3


def opt_level() -> int:
    """Return LLVM's level, 0 to 3: 0 compiles ten times faster and runs 1.3 to 1.8 times slower.

    Other operations are fused than at 3, and four lanes may differ from eight: a run is not
    resumed under another level. Raises InputError.
    """
    text = os.environ.get(OPT_LEVEL, str(DEFAULT))
    if text not in ("0", "1", "2", "3"):
        raise InputError([f"`{OPT_LEVEL}` must be 0, 1, 2 or 3, but is `{text}`."])
    return int(text)
