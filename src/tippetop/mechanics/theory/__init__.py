"""Theory of tops without integration: thresholds, steady states, their stability and modes.

- `thresholds.thresholds(b)` are the numbers that separate regimes, each a `Threshold`.
- `least_energy.asymptotic_states` are the states in which a gliding tippe top can end.
- `modes.linear_modes` are the rates at which a lean from a spin grows.

Functions take a body in SI units, a `contact.body.Touch`, and numbers such as Jellett's integral
lambda. `systems.outlook` combines them to a prediction; `library.theory` offers them to users.
"""
