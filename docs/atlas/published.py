"""Published and derived numbers beside ours. Runs are made once, and shared by the rows that read them."""

import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import tippetop as tt


REFERENCE = Path(__file__).parents[2] / "tests" / "reference"
CANONICAL = tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=131 / 350 * 8e-6, I3=3.2e-6, g=9.82)
VISCOUS, COULOMB = tt.friction.Viscous(mu=0.3), tt.friction.Coulomb(mu=0.3)
SPIN = {"theta": 1.0, "phi_dot": 10.0, "omega3": 100.0}
SLENDER = tt.HeavyTop(m=0.02, l=0.03, I1=2e-5, I3=1e-5, g=9.82)
SLENDER_SPIN = {"theta": 0.5, "phi_dot": 5.0, "omega3": 300.0}
CYLINDER = tt.Cylinder(m=0.02, R=0.02, alpha=0.3, I=4e-6, g=9.82)
COHEN = tt.TippeTop(m=0.015, R=0.025, alpha=0.2, I1=3.75e-6, I3=3.75e-6, g=9.81)
LEINE_GLOCKER = tt.TippeTop(m=6e-3, R=1.5e-2, alpha=0.2, I1=8e-7, I3=7e-7, g=9.81)


class Published(NamedTuple):
    """A number with the digits that were published, and what gives ours. `within`: units of its last digit that it may
    differ; what is published with all 16 digits is met to some 1e-12."""

    what: str
    value: str
    ours: Callable[[], Any]
    unit: str = ""
    within: float = 1.0

    def last_digit(self) -> float:
        """The unit of the last digit that is printed."""
        mantissa, _, exponent = self.value.partition("e")
        return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))

    def allowed(self) -> float:
        """How far ours may be away."""
        return max(self.within * self.last_digit(), 3e-12 * abs(float(self.value)))


# --- runs ---------------------------------------------------------------------------------------


@cache
def canonical() -> tt.Run:
    """The canonical inversion."""
    columns = ["theta", "omega3", "nu_x", "nu_y", "jellett", "energy", "routh"]
    return tt.run(
        CANONICAL,
        VISCOUS,
        start={"theta": 0.1, "omega3": 155.0},
        until=10.0,
        output_step=1e-4,
        columns=columns,
    )


def at(run: tt.Run, column: str, t: float) -> float:
    """A column at a time that is a row."""
    return float(run.trajectory[column].sel(time=t, method="nearest"))


def first(column: str) -> Callable[[], float]:
    """A column of the canonical inversion at its start."""
    return lambda: float(canonical().trajectory[column][0])


def events(run: tt.Run, kind: str) -> np.ndarray:
    """Times of the events of a kind."""
    log = run.events
    return log.time.values[
        (log["kind"] == log["kind"].attrs["flag_meanings"].split().index(kind)).values
    ]


def fastest() -> float:
    """max |v_A| of the canonical inversion, by a parabola through the largest row."""
    rows = canonical().trajectory
    speed = np.hypot(rows.nu_x, rows.nu_y).values
    i = int(np.nanargmax(speed))
    before, middle, after = speed[i - 1 : i + 2]
    return float(middle - (before - after) ** 2 / (8 * (before - 2 * middle + after)))


def weights(end: str) -> float:
    """Least or largest g_n of the canonical inversion, by its weight."""
    return canonical().summary.to_dict()["normal_force"][end] / (0.02 * 9.82)


@cache
def modes() -> np.ndarray:
    """Rates near the upright spin of 155 rad/s."""
    return tt.theory.linear_modes(CANONICAL, VISCOUS, omega3=155.0)


@cache
def joneja() -> tt.Run:
    """Joneja's cone. Its mass and length are those of no body with this tip, I1* < m l^2; only I1*, I3, m g l enter,
    so that of a shorter, heavier top with the same three is the same motion."""
    m, R, l = 0.02, 0.02, 0.04
    pivot, k = 3 / 20 * m * (R**2 + l**2 / 4), 100
    top = tt.HeavyTop(m=m * k, l=l / k, I1=pivot - m * l**2 / k, I3=3 / 10 * m * R**2, g=9.81)
    return tt.run(
        top, start={"theta": 0.1, "psi_dot": 125.0}, until=1.0, output_times=[0.0, 0.99999, 1.0]
    )


@cache
def exudyn() -> tt.Run:
    """The benchmark of a heavy top in multibody dynamics."""
    top = tt.HeavyTop(m=15.0, l=1.0, I1=0.234375, I3=0.46875, g=9.81)
    start = {"theta": np.pi / 2, "phi_dot": -4.61538, "omega3": 150.0}
    return tt.run(top, start=start, until=0.2, output_times=[0.0, 0.2])


@cache
def swing(name: str) -> tuple[float, float]:
    """Period and other turning angle of a nutation: the times and angles of its turnings in a run."""
    none = tt.friction.Frictionless()
    given: dict[str, tuple[Any, Any, dict, dict]] = {
        "rolling": (CANONICAL, None, SPIN, {"system": "rolling-tippe-top"}),
        "frictionless": (CANONICAL, none, SPIN, {}),
        "frictionless heavy": (SLENDER, none, SLENDER_SPIN, {}),
        "fixed": (SLENDER, None, SLENDER_SPIN, {}),
        "small": (CYLINDER, None, {"theta": 0.5}, {}),
        "wide": (CYLINDER, None, {"theta": 2.0}, {}),
    }
    top, law, start, more = given[name]
    log = tt.run(top, law, start=start, until=2.2, output="events", **more).events
    turnings = log.isel(event=((log["kind"] == 0) & log["significant"]).values)
    return float(turnings.time[2] - turnings.time[0]), float(turnings.theta[0])


@cache
def round_cylinder() -> tt.Run:
    """A round cylinder that glides."""
    top = tt.Cylinder(m=0.02, R=0.02, alpha=0.0, I=4e-6, g=9.82)
    return tt.run(top, VISCOUS, start={"nu_x": 0.5}, until=0.2, output_times=[0.0, 0.2])


@cache
def lifting_cylinder() -> float:
    """theta'^2 cos(theta) R alpha/g where the eccentric cylinder lifts off."""
    run = tt.run(
        CYLINDER, VISCOUS, start={"theta": 1.0, "theta_dot": 60.0}, until=2.0, output="events"
    )
    last = run.trajectory.isel(time=-1)
    return float(last.theta_dot**2 * np.cos(last.theta) * 0.02 * 0.3 / 9.82)


THROWN = {
    "theta": 0.5,
    "theta_dot": 60.0,
    "phi_dot": 5.0,
    "omega3": 30.0,
    "nu_x": 0.1,
    "nu_y": -0.2,
}
SLIDING = {"theta": 2.0, "nu_x": 0.3}


@cache
def dry(name: str) -> tt.Run:
    """Runs under Coulomb's law itself."""
    rest = {"theta": 0.1, "centre_at_rest": True}
    given: dict[str, tuple[Any, Any, dict, float]] = {
        "C1": (CANONICAL, COULOMB, rest | {"omega3": 155.0}, 0.1),
        "C3": (CANONICAL, COULOMB, THROWN, 0.1),
        "C6": (
            tt.Cylinder(m=0.02, R=0.02, alpha=0.3, I=CANONICAL.I1, g=9.82),
            tt.friction.Coulomb(mu=0.1),
            SLIDING,
            0.5,
        ),
        "cohen": (COHEN, COULOMB, rest | {"omega3": 100.0}, 0.1),
        "leine-glocker": (LEINE_GLOCKER, COULOMB, rest | {"omega3": 180.0}, 0.1),
    }
    top, law, start, until = given[name]
    return tt.run(top, law, start=start, until=until)


@cache
def regularised(eps: float) -> tt.Run:
    """The body of Leine and Glocker under regularised Coulomb friction."""
    return tt.run(
        "leine-glocker", friction={"eps": eps}, until=3.0 if eps > 5e-4 else 8.0, output="events"
    )


# --- reference trajectories ---------------------------------------------------------------------


@cache
def stored(name: str) -> dict[str, Any]:
    """A reference case."""
    return json.loads((REFERENCE / f"{name}.json").read_text(encoding="utf-8"))


TRAJECTORIES = {
    "case1_inverting": ("tippe-top", "the canonical inversion, 8 s"),
    "case3_noninverting_low": ("tippe-top", "below the upright threshold, 5 s"),
    "case4_gliding_hst": ("gliding-heavy-top", "the gliding heavy top, 4 s"),
    "case5_cylinder": (
        "gliding-cylinder",
        "the eccentric cylinder, over the top sixteen times, 4 s",
    ),
    "case5b_cylinder_round": ("gliding-cylinder", "the round cylinder, 1 s"),
    "case6_rolling": ("rolling-tippe-top", "pure rolling with a wide nutation, 4 s"),
    "case7_hst": ("heavy-top", "the heavy top with a fixed tip, cusps, 4 s"),
}


def gap(name: str) -> tuple[float, int, int]:
    """Largest difference of theta from a reference trajectory at its times, and turnings of both."""
    case, system = stored(name), TRAJECTORIES[name][0]
    record = tt.extending.SYSTEMS[system]
    numbers = {k: float(Fraction(v)) for k, v in case["parameters_exact"].items()}
    numbers["I"] = numbers["I1"]
    names = {"thetadot": "theta_dot", "phidot": "phi_dot"}
    start = {names.get(k, k): float(Fraction(v)) for k, v in case["initial_exact"].items()}
    times = [float(t) for t in case["t"]]
    run = tt.run(
        record,
        {"law": "viscous", "mu": numbers["mu"]} if record.frictional else None,
        parameters={k: numbers[k] for k in record.parameters},
        start={k: v for k, v in start.items() if k in record.initial},
        until=times[-1],
        output_times=times,
    )
    exact = np.array(case.get("theta_unwrapped", case["theta"]), dtype=float)
    log = run.events
    ours = int(((log["kind"] == 0) & log["significant"]).sum())
    theirs = sum(0 < float(point["t"]) <= times[-1] for point in case["turning_points"])
    return float(abs(run.trajectory.theta.values - exact).max()), ours, theirs


# --- the table ----------------------------------------------------------------------------------


def _mode(i: int, part: str) -> Callable[[], float]:
    return lambda: getattr(modes()[i], part)


def _limit(name: str) -> Callable[[], float]:
    return lambda: tt.theory.thresholds(CANONICAL)[name].value


def _theta(t: float) -> Callable[[], float]:
    return lambda: at(canonical(), "theta", t)


def _passage(i: int) -> Callable[[], float]:
    return lambda: events(canonical(), "equator")[i]


def _swing(name: str, i: int) -> Callable[[], float]:
    return lambda: swing(name)[i]


def _dry(name: str, kind: str, column: str = "time") -> Callable[[], float]:
    def value() -> float:
        log = dry(name).events
        number = log["kind"].attrs["flag_meanings"].split().index(kind)
        return float(log[column].values[(log["kind"] == number).values][0])

    return value


def _first_equator(eps: float) -> Callable[[], float]:
    return lambda: regularised(eps).summary.to_dict()["inversion"]["first_equator"]


P = Published
S, RAD, RATE = "s", "rad", "rad/s"
TABLE: dict[str, tuple[Published, ...]] = {
    "The canonical inversion (Rauch-Wojciechowski and Rutstam 2013; Joneja 2017)": (
        P("Jellett's integral λ", "6.894441319558e-6", first("jellett"), "kg m³/s"),
        P("λ/λ_s", "2.004851", lambda: first("jellett")() / _limit("lambda_s")()),
        P("λ_s", "3.43887972e-6", _limit("lambda_s"), "kg m³/s"),
        P("E(0)", "0.04215328802636", first("energy"), "J"),
        P("D(0)", "7.300820515e-4", first("routh"), "kg m²/s"),
        P("θ(5 s)", "0.6029316951312", _theta(5), RAD, 10),
        P("θ(6 s)", "1.7774390745963", _theta(6), RAD, 10),
        P("θ(7 s)", "3.0594782395116", _theta(7), RAD, 10),
        P("θ(10 s)", "3.1388919565416", _theta(10), RAD, 10),
        P("ω₃(10 s)", "-82.866108109", lambda: at(canonical(), "omega3", 10), RATE),
        P("first passage of π/2", "5.879749518", _passage(0), S),
        P("second passage of π/2", "5.907255794", _passage(1), S),
        P("third passage of π/2", "5.927194629", _passage(2), S),
        P("θ passes π − 0.1", "6.943847617", lambda: events(canonical(), "inverted")[0], S),
        P("least g_n/mg", "0.286874", lambda: weights("min"), "", 3),
        P("largest g_n/mg", "1.756894", lambda: weights("max")),
        P("largest gliding speed", "0.832143", fastest, "m/s"),
    ),
    "Thresholds and linear modes of the same body (theorem 3.3.2; Magnus; Friedl 1997; Leine and Glocker 2003)": (
        P("upright spin loses stability", "27.6679170948", _limit("spin_upright"), RATE),
        P("inverted spin gains stability", "41.3326889577", _limit("spin_inverted"), RATE),
        P("upright spin needed for the full inversion", "76.7607080642", _limit("spin_full"), RATE),
        P("p₁, real part", "1.206845166719", _mode(0, "real"), "1/s"),
        P("p₁, imaginary part", "168.048551617954", _mode(0, "imag"), "1/s"),
        P("p₂, real part", "-0.161265295486", _mode(1, "real"), "1/s"),
        P("p₂, imaginary part", "-0.847112112075", _mode(1, "imag"), "1/s"),
        P("p₃, real part", "-7.848366130776", _mode(2, "real"), "1/s"),
        P("p₃, imaginary part", "-1.552584544047", _mode(2, "imag"), "1/s"),
    ),
    "Heavy tops with a fixed tip (Joneja 2017, table 1; EXUDYN's benchmark)": (
        P(
            "Joneja, θ(0.99999 s), printed there as θ(1)",
            "0.239331610776",
            lambda: at(joneja(), "theta", 0.99999),
            RAD,
        ),
        P("Joneja, θ(1 s)", "0.239334535444", lambda: at(joneja(), "theta", 1.0), RAD),
        P("EXUDYN, θ(0.2 s)", "2.122316990777", lambda: at(exudyn(), "theta", 0.2), RAD, 10),
        P("EXUDYN, φ(0.2 s)", "-0.790871611821", lambda: at(exudyn(), "phi", 0.2), RAD, 10),
    ),
    "Periods and other turning angles, published by quadrature, ours from the turnings of a run": (
        P("rolling top, period", "0.05405845287215864", _swing("rolling", 0), S),
        P("rolling top, other angle", "0.83867185863810919", _swing("rolling", 1), RAD),
        P(
            "gliding top without friction, period",
            "0.06011604153899423",
            _swing("frictionless", 0),
            S,
        ),
        P(
            "gliding top without friction, other angle",
            "0.79505511802680335",
            _swing("frictionless", 1),
            RAD,
        ),
        P(
            "gliding heavy top without friction, period",
            "0.04697105057746059",
            _swing("frictionless heavy", 0),
            S,
        ),
        P(
            "gliding heavy top without friction, other angle",
            "0.48028100380708158",
            _swing("frictionless heavy", 1),
            RAD,
        ),
        P("heavy top with a fixed tip, period", "0.08332549321234158", _swing("fixed", 0), S),
        P(
            "heavy top with a fixed tip, other angle",
            "0.46196524721933895",
            _swing("fixed", 1),
            RAD,
        ),
        P("rolling cylinder, amplitude 0.5, period", "0.5329210375359308", _swing("small", 0), S),
        P("rolling cylinder, amplitude 2, period", "0.8321650553406782", _swing("wide", 0), S),
    ),
    "Gliding cylinders": (
        P(
            "round, ν_x(0.2 s)",
            "0.08537113947514",
            lambda: at(round_cylinder(), "nu_x", 0.2),
            "m/s",
        ),
        P(
            "round, θ'(0.2 s)",
            "13.820962017495",
            lambda: at(round_cylinder(), "theta_dot", 0.2),
            RATE,
        ),
        P("eccentric, θ'² cos θ Rα/g at liftoff", "-1.000000000000", lifting_cylinder),
    ),
    "Coulomb's law itself (two engines that share nothing; Cohen 1977; Leine and Glocker 2003)": (
        P("C1, sliding stops", "0.0392357743555808144", _dry("C1", "stick"), S),
        P("C1, θ there", "0.0419599070366", _dry("C1", "stick", "theta"), RAD, 10),
        P("C3, liftoff", "0.0247646188905308", _dry("C3", "liftoff"), S),
        P("C3, landing", "0.0902782512366346", _dry("C3", "impact"), S),
        P("C3, sliding stops", "0.0918574789470826", _dry("C3", "stick"), S, 1e5),
        P("C6, the slip reverses", "0.2300749674224018", _dry("C6", "reversal"), S),
        P("C6, sliding stops", "0.3302954448145226", _dry("C6", "stick"), S),
        P("C6, sliding begins again", "0.3596055902373041", _dry("C6", "slip"), S),
        P("Cohen, sliding stops", "0.02878761568", _dry("cohen", "stick"), S),
        P("Cohen, θ there", "0.0528961411", _dry("cohen", "stick", "theta"), RAD),
        P(
            "Leine and Glocker without drilling, sliding stops",
            "0.0361449219",
            _dry("leine-glocker", "stick"),
            S,
        ),
    ),
    "Regularised Coulomb friction: eps decides when the body of Leine and Glocker passes 90 degrees": (
        P("eps = 1e-2 m/s", "1.05", _first_equator(1e-2), S),
        P("eps = 1e-3 m/s", "2.71", _first_equator(1e-3), S),
    ),
}


def differences() -> list[tuple[str, Published, float]]:
    """Every row with ours. Raises where one differs by more than its digits allow."""
    rows = [(title, row, float(row.ours())) for title, rows in TABLE.items() for row in rows]
    wrong = [
        f"{row.what}: {row.value} and {ours!r}"
        for _, row, ours in rows
        if not abs(ours - float(row.value)) <= row.allowed()
    ]
    if wrong:
        raise ValueError("\n".join(wrong))
    return rows


def table() -> Any:
    """The table, for a page."""
    from IPython.display import Markdown

    lines, last = [], ""
    for title, row, ours in differences():
        if title != last:
            lines += [
                "",
                f"**{title}**",
                "",
                "| | published | ours | difference |",
                "|---|---|---|---|",
            ]
            last = title
        lines.append(
            f"| {row.what} | {row.value} {row.unit} | {ours:.16g} | {ours - float(row.value):.1e} |"
        )
    return Markdown("\n".join(lines))


def trajectories() -> Any:
    """The table of reference trajectories, for a page."""
    from IPython.display import Markdown

    lines = [
        "| trajectory | largest difference in θ (rad) | turnings, ours and theirs |",
        "|---|---|---|",
    ]
    for name, (_, words) in TRAJECTORIES.items():
        difference, ours, theirs = gap(name)
        lines.append(f"| {words} (`{name}`) | {difference:.1e} | {ours}, {theirs} |")
    return Markdown("\n".join(lines))
