"""How this process keeps memory.

A library leaves that to whoever calls it; the command line asks for it.
"""

import contextlib
import ctypes


TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # M_TRIM_THRESHOLD, M_MMAP_THRESHOLD of <malloc.h>


def keep_memory() -> None:
    """Lets the C library keep what is freed: every slice of a run takes and frees some 20 MB, a
    fifth of the run's time where the system has to hand them out anew, page by page. Does nothing
    with a C library other than glibc.
    """
    with contextlib.suppress(AttributeError, OSError):
        adjust = ctypes.CDLL(None).mallopt
        adjust(TRIM_THRESHOLD, 1 << 30)
        adjust(MMAP_THRESHOLD, 32 << 20)
