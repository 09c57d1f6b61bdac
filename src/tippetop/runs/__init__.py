"""Follow one run from its start to its end: rows, events, drift, store, report.

- `integration.Integration` lets the driver make slices of steps, and measures each of them.
- `sinks.Sink` receives rows and events: `Memory` keeps them, `recording.Recorder` writes a store.
- `reporting.RunProgress` is the immutable record from which reports and attributes are made.

`run.solve` integrates in memory, `recording.record` into a new store, and `resuming.resume`
continues a store. In each slice rows go from the driver to `Integration` and then to the sink;
zeros of event functions go through `EventLog`, sampled states to `Drift`. At the end `attributes`
makes the root attributes of the store, from which `results.Summary` is made.
"""
