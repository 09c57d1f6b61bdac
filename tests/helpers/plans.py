"""A small sweep for tests."""

PLAN = """
scenario = "inverting"
set.run.until = 0.5
chunk = 7
runs = [5]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 175.0]
n = 6
[[axis]]
of = "friction.mu"
values = [0.3, 0.1, 0.2, 0.4]
"""
