"""Derivatives of runs by their numbers, and the growth of small errors."""
