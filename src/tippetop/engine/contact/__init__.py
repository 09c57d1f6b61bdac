"""Runs whose contact changes its phase: each phase has its own equations, and a rule says what follows it."""
