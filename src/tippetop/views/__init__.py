"""Pages that a browser opens without a network: a run, a sweep, the playground."""
