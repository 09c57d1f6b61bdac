"""The mechanics of tops as formulas and records of formulas, which other packages compile.

- `system.System` is one kind of top: body, equations, events, columns and theory.
- `form.Form` is a choice of variables with its equations, `form.Phase` a state of the contact.
- `friction.FrictionLaw` is a law of friction; its instances contain the numbers of the law.

A formula takes records, such as a state q and a body b, of numbers, arrays, duals or expressions
(`operand`). `systems` contains the tops of the package, made of the formulas of `contact`; `theory`
predicts their motions. `engine` compiles the equations; `landscape` the effective potential.
"""
