"""Motions and bodies of other programs: tables to compare and to fit, files for simulators."""
