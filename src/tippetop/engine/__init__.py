"""Integrate a `Problem`: Taylor steps, events, changes of phase, columns and derivatives.

- `driver.Driver` makes the steps of one run; `hybrid.HybridDriver` of a run that changes its phase;
  `pools.Pools` of many tops in SIMD lanes. `taylor.driver_of(problem)` chooses.
- `loop.Loop` binds the arrays of a run to the compiled loop, `loop.c`.
- `observables.Observables` converts states to columns.

Formulas become heyoka expressions (`expressions`), these a compiled Taylor step (`integrator`).
`Driver.advance` lets the loop make a slice of steps, which fills arrays of Python with states,
zeros of event functions and rows. The caller (`runs`) gets them as a `Slice`, in internal units.
"""
