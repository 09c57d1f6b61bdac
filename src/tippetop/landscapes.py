"""The effective potential, its minimum over the angle, turning angles, the band of a run."""

from .library.landscapes import band, marked_lines, minimal_surface, potential, turning_angles


__all__ = ["band", "marked_lines", "minimal_surface", "potential", "turning_angles"]
