"""The ways in which a run can end.

The loop counts in codes, stores and reports have words.
"""

from enum import Enum


class Status(Enum):
    """The way in which a run has ended.

    The value is the word in stores; `code` is the number in the lanes of ensembles and in the
    stores of sweeps.

    Attributes
    ----------
    TODO
        A top of a sweep that is not yet computed.
    FINISHED
        The run reached `until`.
    LIFTOFF, FALLEN
        The normal force fell to zero; theta reached pi/2, where the body would enter the plane.
    SETTLED
        Sliding has ended, and `stop_when` is "settled".
    NON_FINITE, STALLED
        The state is not finite; the steps became too short. `summary.reason` has the details.
    INVALID
        A top of an ensemble whose numbers allow no motion, or whose formulas fail.
    ENDED
        A user-defined event ended the run, and its `ends` is not the name of another status.
    RUNNING
        The store is being written, or was interrupted and can be resumed.
    """

    TODO = "todo"
    FINISHED = "finished"
    LIFTOFF = "liftoff"
    FALLEN = "fallen"
    SETTLED = "settled"
    NON_FINITE = "non-finite"
    STALLED = "stalled"
    INVALID = "invalid"
    ENDED = "ended"
    RUNNING = "running"

    @property
    def code(self) -> int:
        """Return the number of the status in stores: its index in the enumeration.

        loop.c has some of these numbers, so a new status goes to the end.
        """
        return list(Status).index(self)

    @property
    def ordinary(self) -> bool:
        """Return whether the run ended for a reason that lies in the motion of the top."""
        return self in (
            Status.FINISHED,
            Status.LIFTOFF,
            Status.FALLEN,
            Status.SETTLED,
            Status.ENDED,
        )

    @classmethod
    def of_event(cls, ends: str) -> "Status":
        """Return the status of a run that an event with this ending has ended.

        Parameters
        ----------
        ends
            As in `Event.ends`.

        Returns
        -------
        Status
            ENDED for any other word.
        """
        return cls(ends) if ends in {status.value for status in cls} else cls.ENDED
