"""An impact under a friction law that is smooth in the sliding velocity: F_h = -k(|v|^2) g_n v, so dp_h = -k v dpi.

The equations of `contact.struck`, whose law has a corner at v = 0, without one: by an integrator of scipy, whose last
step is made again to its end.
"""

from collections.abc import Callable


import numpy as np

from ...mechanics.contact.ball import Mobility
from ...mechanics.contact.struck import Impact


TOLERANCE = 1e-13
NEWTON = 4  # corrections of the end of a stage


def struck_smooth(
    v_e: float, v_2: float, v_n: float, K: Mobility, k: Callable, e_n: float, restitution: str = "energetic"
) -> Impact:
    """The impact of a contact point that arrives with v_n < 0.

    Parameters
    ----------
    v_e, v_2, v_n
        Velocity of the contact point before it, along e, 2hat, zhat.
    K
        Mobility of the contact.
    k
        k(|v|^2) of the friction law.
    e_n, restitution
        As of `contact.struck.struck`.

    Returns
    -------
    Impact
        After it, in doubles.
    """
    K = Mobility(*map(float, K))
    start = np.array([v_e, v_2, v_n, 0.0, 0.0], float)  # velocity; works of the normal impulse and of friction

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        along, sideways = (float(k(y[0] ** 2 + y[1] ** 2)) * y[i] for i in (0, 1))
        slid = along * y[0] + sideways * y[1]
        return np.array([K.ez - K.ee * along, -K.tt * sideways, K.zz - K.ez * along, y[2], -slid])

    def stage(y: np.ndarray, field: int, value: float, longest: float) -> tuple[float, np.ndarray]:
        """Impulse and state where a field reaches a value, rising."""
        from scipy.integrate import solve_ivp

        def missing(_: float, y: np.ndarray) -> float:
            return float(y[field] - value)

        missing.terminal, missing.direction = True, 1  # type: ignore[attr-defined]
        options = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE * abs(v_n)}
        rough = solve_ivp(rates, (0.0, longest), y, events=missing, **options)
        impulse = float(rough.t_events[0][0])
        for _ in range(NEWTON):
            end = solve_ivp(rates, (0.0, impulse), y, **options).y[:, -1]
            change = (value - end[field]) / rates(0.0, end)[field]
            impulse += change
            if abs(change) <= 1e-15 * impulse:
                break
        end = end + change * rates(0.0, end)
        end[field] = value
        return impulse, end

    # v_n' = K_zz - K_ez k v_e may be small for a while, never for long: v_e falls
    longest = 1e3 * abs(v_n) / K.zz + 1e3 * abs(v_e) / K.ee
    p_z, y = stage(start, 2, 0.0, longest)
    compression = float(y[3])
    if e_n > 0:
        if restitution == "poisson":
            from scipy.integrate import solve_ivp

            y = solve_ivp(rates, (0.0, e_n * p_z), y, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE * abs(v_n)).y[:, -1]
            p_z *= 1 + e_n
        else:
            field, value = (3, (1 - e_n**2) * compression) if restitution == "energetic" else (2, -e_n * v_n)
            more, y = stage(y, field, value, longest)
            p_z += more
    p_e, p_2 = (y[0] - v_e - K.ez * p_z) / K.ee, (y[1] - v_2) / K.tt
    return Impact(p_e, p_2, p_z, y[0], y[1], y[2], float(y[3]), float(y[4]), compression, "slip")


