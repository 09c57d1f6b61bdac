"""The summary of a run as a record, printed by `tippetop info --json`.

Root attributes go in; a `Summary` comes out, which users print and read.
"""

from collections.abc import Callable, Mapping
from typing import Any

from ..errors import InputError
from ..problem import Problem
from ..scenario import build
from ..store.root import finite
from . import attributes, forecast
from .summary import certificate_sentence


class Record(dict[str, Any]):
    """A read-only record whose names are attributes and keys; tables in it are records too."""

    def __init__(self, values: Mapping[str, Any], name: str = ""):
        super().__init__(
            {k: Record(v, k) if isinstance(v, Mapping) else v for k, v in values.items()}
        )
        self.__dict__["_name"] = name or type(self).__name__

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"there is no `{name}`: known are {', '.join(self)}")
        return self[name]

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a record is read-only: `{name}` cannot be set")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *filter(str.isidentifier, self)]

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value!r}" for name, value in self.items())
        return f"{self._name}({values})"

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain dicts."""
        return {k: v.to_dict() if isinstance(v, Record) else v for k, v in self.items()}


class Summary(Record):
    """The summary of a run: `tippetop info --json` prints `to_dict()`.

    Every name is an attribute and a key.

    Attributes
    ----------
    status : str
        The status at the end: finished, liftoff, fallen, settled, stalled, non-finite;
        running if it has not ended.
    reason : str
        The same in a sentence.
    t_end : float
        Time of the end [s].
    steps : int
        Steps of the integrator.
    drift : Record
        Of each invariant, the largest relative deviation from its start.
    normal_force : Record
        `min`, `max` [N], when (`t_min`, `t_max` [s]), and the `weight` m g [N]; only where there is
        such a force.
    event_counts : Record
        Number of logged events of each kind, and of the turnings that are more than rounding.
    inversion : Record
        `first_equator`, `last_equator`, `inverted_at` [s]: passages of theta = pi/2 and pi - 0.1,
        None if there are none.
    nutational_band : Record
        `theta_min`, `theta_max` [rad] of all significant turnings.
    theta_end : float
        Inclination at the end [rad].
    outcome : str
        Only for a top that can turn over: upright or inverted (near a pole whose spin is stable
        and is not ended by a torque of friction), tumbling, lifted-off, under-way; if its contact
        can change its phase also rolling, on-stem, bouncing, at-rest.
    system, form, parameters, friction, initial, run
        The scenario with all defaults, in SI units; `friction` only if there is a law.
    certificate : Record
        The comparison with a run in higher precision, if `certify` was called.
    tolerance, precision
        Of the integrator.
    final_state : Record
        The integrated variables at the end, in SI units.
    versions, cpu
        Versions of the packages, and the processor.
    motion
        Only for a heavy top: the name of its kind of motion.
    """

    def __repr__(self) -> str:
        numbers = ", ".join(f"{k}={v!r}" for k, v in self.items() if isinstance(v, int | float))
        names = ", ".join(name for name in self if name != "reason")
        return f"<Summary: {self.reason}; {numbers}; {names}>"


class Certificate(Record):
    """The comparison of a run with one in higher precision, printed as a sentence.

    Every name is an attribute and a key; `Run.certify` lists them.
    """

    def __repr__(self) -> str:
        return f"<Certificate {certificate_sentence(self)}; {', '.join(self)}>"


def summary_of(attrs: dict[str, Any], problem: Callable[[], Problem] | None = None) -> Summary:
    """Return the summary of a run, from root attributes.

    `problem` returns its problem, if the caller has it; by default it is built of the attributes.
    """
    try:
        comments = forecast.comments(problem() if problem else build.stored(attrs))
    except InputError:  # of a system, law or event that this process does not know
        comments = {}
    return Summary(attributes.info(attrs) | finite(comments))
