"""Work that is waited for is done as if it were done here."""

import numpy as np

from tippetop.awaiting import awaited


def test_it_is_done_in_the_context_of_who_waits() -> None:
    """Before, a warning of numpy that was silenced here became an error there, if the equations had
    to be compiled.
    """
    with np.errstate(invalid="ignore"):
        assert np.isnan(awaited(lambda: np.sqrt(np.float64(-1.0)), "a root"))
