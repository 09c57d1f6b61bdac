"""An event and a column of the user, in a module that workers can import."""

import tippetop as tt
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import JOULE


@formula
def past_azimuth(s, b):
    """sin(theta) sin(phi): rises where the azimuth increases through zero."""
    return s.uy


@formula
def spin_energy(s, b):
    """Energy of the spin about the axis, L_3^2/(2 I_3)."""
    return s.L3**2 / (2 * b.I3)


SECTION = tt.extending.Event(
    "section",
    "the axis passes the azimuth 0",
    past_azimuth,
    direction=+1,
    kept=(tt.extending.Kept("sections", "count", "passages of the azimuth 0"),),
)
SPIN_ENERGY = tt.extending.Quantity(
    "spin_energy", "E_3", JOULE, "energy of the spin about the axis", spin_energy
)
RECORDS = {"events": ["turning", SECTION], "columns": [SPIN_ENERGY]}
