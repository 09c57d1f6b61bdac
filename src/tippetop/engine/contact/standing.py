"""Standing on sphere and stem at once: when a body does, and how it comes to rest there. [contact 4.3]"""

from ...mechanics.contact.body import angular_velocity
from ...mechanics.contact.phases.both import BOTH, Touching, both_kind, force_of, lost_of, shares
from ...mechanics.operand import Vector, cross, dot, plus, times
from ...mechanics.variables import INTEGRAL_SCALE
from .impacts import Impacts, Moment


ON_PLANE = 1e-12  # gap of a ball that touches
BOTH_AT = (
    1e-6  # v_n of both balls below which the body stands on them; what is left is an impulse of both: the error is
)
# the square of that
PRESSES = 1e-12  # part of the weight that a ball bears at least


class Standing(Impacts):
    """When a body stands on both of its balls.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    """

    def _rests_on_both(self, moment: Moment) -> bool:
        """Whether both balls touch the plane, and neither moves up or down."""
        return self.balls.stem and all(
            float(self.gap(k, moment)) <= ON_PLANE and abs(float(self.point(k, moment).z)) < BOTH_AT for k in (0, 1)
        )

    def _at_rest(self, moment: Moment) -> tuple[Moment, str]:
        """The body without theta' and vertical velocity, which impulses at both balls take, as the endless hops from
        one to the other would; and the kind of standing on both, empty if a ball does not press."""
        body = self.balls[0]
        name = both_kind(moment.u, moment.L, moment.velocity, body, self.balls.drills)
        kind, sides = BOTH[name]
        q = kind.state(moment.u, moment.L, moment.velocity, moment.height, body)
        one, two = sides(q, body)
        u, L, V = moment.u, moment.L, moment.velocity
        P = shares(one, two, -(body.m * V.z), L.y * u.x - L.x * u.y)
        one, two = one._replace(N=P[0]), two._replace(N=P[1])
        p, turn = self._impulses(one, two)
        stands = moment._replace(L=plus(L, turn), velocity=plus(V, times(1 / body.m, p)), carried=moment.carried.copy())
        mean = times(0.5, plus(angular_velocity(u, L, body), angular_velocity(u, stands.L, body)))
        gained = dot(p, times(0.5, plus(V, stands.velocity))) + dot(turn, mean)
        stands.carried[self.work] = stands.carried[self.work] - gained * INTEGRAL_SCALE
        stands.carried[self.impulse] = stands.carried[self.impulse] + p.z * INTEGRAL_SCALE
        if self.lost >= 0:
            stands.carried[self.lost] = stands.carried[self.lost] + lost_of(one, two) * INTEGRAL_SCALE
        stands = stands._replace(velocity=stands.velocity._replace(z=0 * p.z))
        loads = kind.form.scalars(kind.state(u, stands.L, stands.velocity, moment.height, body), body)
        presses = min(loads.force, loads.stem_force) > PRESSES * body.m * body.g
        return stands, name if presses else ""

    def _impulses(self, one: Touching, two: Touching) -> tuple[Vector, Vector]:
        """Of both contacts: the impulse, and that of the torque about the centre of mass."""
        turns = (times(side.N, plus(cross(side.arm, side.force), side.torque)) for side in (one, two))
        return plus(force_of(one), force_of(two)), plus(*turns)

    def _opens(self, name: str, ball: int, moment: Moment) -> bool:
        """Whether the other ball, which touches too, leaves the plane while this one stays there: by its gap''."""
        kind, body, u, L = self.kinds[name], self.balls[ball], moment.u, moment.L
        q = kind.state(u, L, moment.velocity, moment.height, body)
        rate = kind.form.rates(q, body)
        turned = plus(cross(Vector(rate.Lx, rate.Ly, rate.Lz), u), cross(L, Vector(rate.ux, rate.uy, rate.uz)))
        return bool((self.balls[1 - ball].c - body.c) * turned.z > 0)
