"""The effective potential V, its minimum F over the angle, marked lines, turning angles, the band
of a run.
"""

from .library.landscapes import band, marked_lines, minimal_surface, potential, turning_angles


__all__ = ["band", "marked_lines", "minimal_surface", "potential", "turning_angles"]
