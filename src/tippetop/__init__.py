"""tippetop: tops that roll and glide, integrated to rounding, with their events, potentials and surfaces.

>>> import tippetop as tt
>>> top = tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-6, I3=3.2e-6, g=9.82)
>>> run = tt.run(top, tt.Viscous(mu=0.3), start=dict(theta=0.1, omega3=155.0), until=8.0)
>>> print(run)
>>> run.trajectory.theta.plot()
"""

from typing import Any


_NAMES = {
    "errors": "InputError StoreError Interrupted Unfinished",
    "engine.status": "Status",
    "problem": "Problem",
    "mechanics.friction": ("FrictionLaw Contensou Coulomb Frictionless Latitude Mixed Stribeck Viscous"),
    "mechanics.events": "Event Kept",
    "mechanics.number": "number",
    "mechanics.system": "Number Quantity System",
    "mechanics.systems.cylinder": "Cylinder Modified",
    "mechanics.systems.heavy_top": "HeavyTop",
    "mechanics.systems.tippe_top": "TippeTop",
    "mechanics.units": "Unit",
    "library.asymptotics": "accelerations asymptotic_states least_energy",
    "library.derivatives": "Sensitivities lyapunov sensitivities",
    "library.exchanging": "Comparison Fitted compare fit",
    "library.landscapes": "band marked_lines minimal_surface potential turning_angles",
    "library.many": "ensemble",
    "library.registering": "LAWS SYSTEMS register",
    "library.run": "Run",
    "library.stored_run": "StoredRun",
    "library.running": "datasets integrate open resume run",
    "library.theory": "linear_modes nutation reconstruct regime thresholds",
    "runs.results": "Summary",
    "runs.starting": "load",
    "scenario.reading": "presets",
    "store.root": "open_group",
    "sweeps.summary": "gridded",
    "sweeps.sweep": "sweep",
}
_PLACES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = sorted([*_PLACES, "__version__"])


def __getattr__(name: str) -> Any:
    """Public names, imported when first used: `tippetop --help` must not wait for LLVM."""
    if name == "__version__":
        from importlib.metadata import version

        public: Any = version("tippetop")
    elif name in _PLACES:
        from importlib import import_module

        public = getattr(import_module(f".{_PLACES[name]}", __name__), name)
    else:
        raise AttributeError(f"module 'tippetop' has no attribute {name!r}")
    globals()[name] = public
    return public


def __dir__() -> list[str]:
    return list(__all__)
