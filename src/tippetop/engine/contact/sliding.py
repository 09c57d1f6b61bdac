"""How a slide under Coulomb's law itself ends, and how one begins, in a time so short that its rates stay."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...mechanics.contact import body as contact
from ...mechanics.contact import coulomb
from ...mechanics.contact.body import Touch
from ...mechanics.contact.phases.legs import Kind
from ...mechanics.contact.response import mobility_inverse_times
from ...mechanics.operand import Vector, cross, dot, plus, times
from ...mechanics.variables import INTEGRAL_SCALE
from .impacts import Impacts, Moment


BEGINS_AT = 1e-8  # |v_A| with which sliding begins from rest outside the friction cone; its square is the error


class Sliding(Impacts):
    """The ends and beginnings of slides.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    """

    def _run_out(self, kind: Kind, body: Touch, moment: Moment, v: Vector, w: Any) -> tuple[Moment, Any]:
        """The last of a slide, |v_A| = w so small that its rates stay: the end, and the time to it."""
        n = Vector(v.x / w, v.y / w, 0 * w)
        _, P, _ = coulomb.slip_motion(moment.u, moment.L, n, body)
        lag = -w / P
        q = kind.state(moment.u, moment.L, moment.velocity, moment.height, body)
        end = [x + lag * rate for x, rate in zip(q, kind.form.rates(q, body), strict=True)]
        says = kind.says(type(q)(*end), body)
        carried = self._later(kind, body, q, moment.carried, lag)
        return Moment(says.u, says.L, says.velocity, contact.height(says.u.z, body), carried), lag

    def _stopped(self, b: Touch, moment: Moment) -> Moment:
        """The contact point brought to rest by the impulse that this takes: nothing of energy or Jellett's integral is
        lost."""
        v = contact.contact_velocity(moment.u, moment.L, moment.velocity, b)
        p = mobility_inverse_times(moment.u, times(-1, v), b)
        velocity, L = plus(moment.velocity, times(1 / b.m, p)), plus(moment.L, cross(contact.arm(moment.u, b), p))
        carried = moment.carried.copy()
        carried[self.work] = carried[self.work] - dot(p, v) / 2 * INTEGRAL_SCALE
        return moment._replace(L=L, velocity=velocity, carried=carried)

    def _run_in(self, ball: int, moment: Moment, n: Vector) -> tuple[Moment, Any]:
        """The first of a slide along n from rest, so short that its rates stay; and the time that it takes."""
        kind, body = self.kinds["dry-slip"], self.balls[ball]
        F, P, _ = coulomb.slip_motion(moment.u, moment.L, n, body)
        speed = min(self.number(BEGINS_AT), P * self.left)
        lag = speed / P
        u = plus(moment.u, times(lag, contact.axis_rate(moment.u, moment.L, body)))
        L = plus(moment.L, times(lag, cross(contact.arm(moment.u, body), F)))
        velocity, height = contact.centre_velocity(u, L, times(speed, n), body), contact.height(u.z, body)
        q = kind.state(u, L, velocity, height, body)
        carried = self._later(kind, body, q, moment.carried, lag)
        return Moment(u, L, velocity, height, carried), lag

    def _rates(self, kind: Kind, body: Touch) -> Callable:
        """rates(q, carried) of the integrals of a row, (k, n), in a phase."""
        form, variables = kind.form, self.problem.variables
        turning = form.orientation.integrals if self.problem.orientation and form.orientation else ()
        by_name = {integral.name: integral.rate for integral in (*form.integrals, *turning)}

        def rates(q: Any, carried: np.ndarray) -> np.ndarray:
            record = variables.carried(*carried)
            shape = carried.shape[1:]
            return np.array(
                [
                    np.broadcast_to(by_name[name](q, record, body), shape) if name in by_name else np.zeros(shape)
                    for name in variables.carried._fields
                ]
            )

        return rates

    def _later(self, kind: Kind, body: Touch, q: Any, carried: np.ndarray, time: Any) -> np.ndarray:
        """The integrals after a time so short that their rates stay."""
        whole = carried / INTEGRAL_SCALE
        return (whole + time * self._rates(kind, body)(q, whole)) * INTEGRAL_SCALE
