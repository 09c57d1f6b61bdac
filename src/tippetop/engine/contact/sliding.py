"""How a slide under Coulomb's law itself ends, and how one begins, in a time so short that its rates stay."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...mechanics.contact import ball as balls_
from ...mechanics.contact import coulomb
from ...mechanics.contact.ball import Ball
from ...mechanics.contact.phases.legs import Body, Kind
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

    def _run_out(self, kind: Kind, body: Body, b: Ball, moment: Moment, v: Vector, w: Any) -> tuple[Moment, Any]:
        """The last of a slide, |v_A| = w so small that its rates stay: the end, and the time to it."""
        n = Vector(v.x / w, v.y / w, 0 * w)
        _, P, _ = coulomb.slip_motion(moment.u, moment.L, n, b)
        lag = -w / P
        q = kind.state(moment.u, moment.L, moment.velocity, moment.height, body)
        end = [x + lag * rate for x, rate in zip(q, kind.form.rates(q, body), strict=True)]
        says = kind.says(type(q)(*end), body)
        carried = self._later(kind, body, q, moment.carried, lag)
        return Moment(says.u, says.L, says.velocity, balls_.height(says.u.z, b), carried), lag

    def _stopped(self, b: Ball, moment: Moment) -> Moment:
        """The contact point brought to rest by the impulse that this takes: nothing of energy or Jellett's integral is
        lost."""
        v = balls_.contact_velocity(moment.u, moment.L, moment.velocity, b)
        p = balls_.mobility_inverse_times(moment.u, times(-1, v), b)
        velocity, L = plus(moment.velocity, times(1 / b.m, p)), plus(moment.L, cross(balls_.arm(moment.u, b), p))
        carried = moment.carried.copy()
        carried[self.work] = carried[self.work] - dot(p, v) / 2 * INTEGRAL_SCALE
        return moment._replace(L=L, velocity=velocity, carried=carried)

    def _run_in(self, ball: int, b: Ball, moment: Moment, n: Vector) -> tuple[Moment, Any]:
        """The first of a slide along n from rest, so short that its rates stay; and the time that it takes."""
        kind, body = self.kinds["dry-slip"], self.balls[ball]
        F, P, _ = coulomb.slip_motion(moment.u, moment.L, n, b)
        speed = min(self.number(BEGINS_AT), P * self.left)
        lag = speed / P
        u = plus(moment.u, times(lag, balls_.axis_rate(moment.u, moment.L, b)))
        L = plus(moment.L, times(lag, cross(balls_.arm(moment.u, b), F)))
        velocity, height = balls_.centre_velocity(u, L, times(speed, n), b), balls_.height(u.z, b)
        q = kind.state(u, L, velocity, height, body)
        carried = self._later(kind, body, q, moment.carried, lag)
        return Moment(u, L, velocity, height, carried), lag

    def _rates(self, kind: Kind, body: Body) -> Callable:
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

    def _later(self, kind: Kind, body: Body, q: Any, carried: np.ndarray, time: Any) -> np.ndarray:
        """The integrals after a time so short that their rates stay."""
        whole = carried / INTEGRAL_SCALE
        return (whole + time * self._rates(kind, body)(q, whole)) * INTEGRAL_SCALE
