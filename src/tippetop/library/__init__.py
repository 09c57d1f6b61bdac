"""Public objects and calls of `import tippetop`: bodies, laws, runs.

- `running` has `run`, `open` and `resume`; `finished_run.Run` is their result.
- `scenarios.problem_of` makes a `Problem` of the arguments of these calls.
- `variations` has `ensemble` and `sweep`, `exchanging` has `fit` and `compare`.

Arguments are checked here, one sentence for each fault; results get labels and SI units. All work
is done by the packages below.
"""
