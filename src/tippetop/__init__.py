"""tippetop: tops that roll and glide, integrated to machine precision.

>>> import tippetop as tt
>>> top = tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-6, I3=3.2e-6, g=9.82)
>>> run = tt.run(top, tt.friction.Viscous(mu=0.3), start=dict(theta=0.1, omega3=155.0), until=8.0)
>>> print(run)
>>> run.trajectory.theta.plot()

Bodies are TippeTop, HeavyTop, Cylinder, Ellipsoid, Spheroid and Disc, laws those of `friction`.
`run`, `open` and `resume` return runs; `ensemble` and `sweep` integrate many tops; `load` and
`presets` read scenarios; `fit` and `compare` read motions of films and of simulators, for which
`benchmark` has references. `theory`, `landscapes` and `derivatives` answer questions about the
mechanics; `extending` adds systems, laws, events and columns. `help(tt.run)` explains one of them.
"""

from typing import Any as _Any


# public names by their module; `python .ci/stub.py` writes their stubs
_NAMES = {
    "columns": "dataframe",
    "errors": "InputError StoreError Interrupted",
    "problem": "Problem",
    "mechanics.systems.cylinder": "Cylinder",
    "mechanics.systems.heavy_top": "HeavyTop",
    "mechanics.systems.ellipsoid": "Ellipsoid",
    "mechanics.systems.revolution": "Disc Spheroid",
    "mechanics.systems.tippe_top": "TippeTop",
    "library.exchanging": "compare fit",
    "library.likelihoods": "log_likelihood posterior",
    "library.variations": "ensemble sweep",
    "library.finished_run": "Run",
    "library.stored_run": "StoredRun",
    "library.running": "open resume run",
    "runs.starting": "load",
    "scenario.reading": "presets",
}
_PLACES = {name: module for module, names in _NAMES.items() for name in names.split()}
_MODULES = ("benchmark", "derivatives", "errors", "extending", "friction", "landscapes", "theory")
__all__ = sorted([*_PLACES, *_MODULES, "__version__"])


def __getattr__(name: str) -> _Any:
    """Import public names when first used: `tippetop --help` must not wait for LLVM.

    The message on an unknown name imports all public modules to find it there; a name that begins
    with `_`, such as the probe `_repr_html_` of IPython, imports nothing.
    """
    from importlib import import_module

    if name == "__version__":
        from importlib.metadata import version

        public: _Any = version("tippetop")
    elif name in _PLACES:
        public = getattr(import_module(f".{_PLACES[name]}", __name__), name)
    elif name in _MODULES:
        public = import_module(f".{name}", __name__)
    else:
        modules = [] if name.startswith("_") else _MODULES
        found = [m for m in modules if name in import_module(f".{m}", __name__).__all__]
        hint = f": see tippetop.{found[0]}.{name}" if found else ""
        raise AttributeError(f"module 'tippetop' has no attribute {name!r}{hint}")
    globals()[name] = public
    return public


def __dir__() -> list[str]:
    return list(__all__)
