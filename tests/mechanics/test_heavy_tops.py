"""The heavy tops: closed form, published numbers, the limit of the tippe top, and the upright
gliding top.
"""

import math

import examples
import heyoka as hy
import numpy as np
import pytest
from examples import HEAVY
from nightly import at_night

from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.engine.observables import Observables
from tippetop.engine.status import Status
from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact.gliding import euler as gliding_euler
from tippetop.mechanics.friction import Frictionless, Viscous
from tippetop.mechanics.operand import leaves
from tippetop.mechanics.systems import SYSTEMS, heavy_top, tippe_top
from tippetop.mechanics.theory import heavy_top_motion, nutation
from tippetop.runs.run import solve
from tippetop.scenario import build


def closed(made) -> heavy_top_motion.ClosedForm:
    b, start = examples.si(made), examples.at_start(made)
    inertia = heavy_top.tip_inertia(b)
    return heavy_top_motion.closed_form(
        start["energy"], start["Lz"], start["L3"], inertia, b.I3, -b.m * b.g * b.c
    )


@pytest.mark.parametrize("form", ["vector", at_night("euler")])
def test_the_impulse_beside_the_motion_changes_no_bit_of_it(
    form: str, rng: np.random.Generator
) -> None:
    """Whatever shares products with the equations of motion may: of twelve starts, four or five
    kept their bits.
    """
    made: dict[int, hy.taylor_adaptive] = {}
    for _ in range(12):
        start = {
            "theta": rng.uniform(0.3, 2.5),
            "phi_dot": rng.normal(0, 10),
            "omega3": rng.normal(0, 100),
        }
        problem = examples.problem("heavy-top", HEAVY, start, 0.5, form=form, orientation=False)
        rates = equations_of_motion(
            formulas_of(problem.system, problem.form.name, Frictionless), problem.variables
        ).rates
        moving = problem.variables.moving
        ends = []
        for n in (moving, len(rates)):
            integrator = made.setdefault(
                n, hy.taylor_adaptive(rates[:n], np.ones(n), high_accuracy=True)
            )
            integrator.pars[:] = [float(leaf) for leaf in leaves(problem.internal_body)][
                : len(integrator.pars)
            ]
            integrator.time, integrator.state[:] = 0.0, problem.start()[:n]
            integrator.propagate_until(float(problem.internal_time(0.5)))
            ends.append(integrator.state[:moving].copy())
        np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("form", ["vector", "euler"])
@pytest.mark.parametrize(
    "initial",
    [
        {"theta": 0.6, "omega3": 200.0},  # cusps
        {"theta": 1.2, "phi_dot": -4.0, "omega3": 150.0},  # loops
        {"theta": 2.0, "phi_dot": 7.0, "omega3": 90.0},
        {"theta": 2.5, "phi_dot": 3.0, "omega3": 0.0},  # spherical pendulum
    ],
)
def test_closed_form(form: str, initial: dict[str, float]) -> None:
    """theta(t) is the elliptic function of the source, to 1e-12; all starts are turning points."""
    made = examples.problem("heavy-top", HEAVY, initial, 2.0, form=form)
    exact = closed(made)
    z0 = math.cos(initial["theta"])
    shift = 0.0 if abs(z0 - exact.z1) < abs(z0 - exact.z2) else exact.period / 2
    result = solve(made)
    z = exact.z(result.times + shift)
    assert np.abs(np.cos(examples.columns(result)["theta"]) - z).max() < 1e-12
    assert np.abs(examples.columns(result)["theta"] - np.arccos(z)).max() < 1e-12
    assert max(result.report["drift"].values()) < 2e-13


def test_published_heavy_tops() -> None:
    """Joneja (2017), table 1, whose time 1 is 0.99999; and EXUDYN's benchmark."""
    m, R, l = 0.02, 0.02, 0.04
    pivot = 3 / 20 * m * (R**2 + l**2 / 4)
    joneja = {"m": m, "l": l, "I1": pivot - m * l**2, "I3": 0.3 * m * R**2, "g": 9.81}
    assert (
        joneja["I1"] < 0
    )  # the published cone is not a body of this tip: only the moment about the pivot enters
    exudyn = {"m": 15.0, "l": 1.0, "I1": 0.234375, "I3": 0.46875, "g": 9.81}
    made = examples.run(
        "heavy-top",
        exudyn,
        {"theta": math.pi / 2, "phi_dot": -4.61538, "omega3": 150.0},
        0.2,
        times=np.array([0.0, 0.2]),
    )
    rows = examples.columns(made)
    assert rows["theta"][-1] == pytest.approx(2.122316990777, abs=1e-11)
    assert rows["phi"][-1] == pytest.approx(-0.790871611821, abs=1e-11)
    start = {"theta": 0.1, "psi_dot": 125.0}
    rows = examples.columns(
        examples.run("heavy-top", joneja, start, 1.0, times=np.array([0.0, 0.99999, 1.0]))
    )
    np.testing.assert_allclose(rows["theta"][1:], [0.239331610776, 0.239334535444], atol=1e-11)


def test_period_of_the_fixed_top() -> None:
    made = examples.problem(
        "heavy-top", examples.SLENDER, {"theta": 0.5, "phi_dot": 5.0, "omega3": 300.0}, 0.3
    )
    b, start = examples.si(made), examples.at_start(made)
    found = nutation.nutation(
        lambda z: heavy_top.theta_inertia(z, b),
        lambda z: heavy_top.potential(z, start["Lz"], start["L3"], b),
        start["energy"],
        0.5,
    )
    assert found.period == pytest.approx(0.08332549321234158, rel=1e-12)
    assert found.theta_min == pytest.approx(0.46196524721933895, abs=1e-13)
    assert closed(made).period == pytest.approx(0.08332549321234158, rel=1e-11)
    times = solve(made).events.of("turning", significant=True).time
    assert times[2] - times[0] == pytest.approx(0.08332549321234158, rel=1e-12)


@pytest.mark.parametrize(
    ("initial", "name"),
    [
        ({"theta": 0.6, "omega3": 200.0}, "nutation with cusps"),
        ({"theta": 0.6, "phi_dot": -5.0, "omega3": 200.0}, "nutation with loops"),
        ({"theta": 0.6, "phi_dot": 3.0, "omega3": 200.0}, "nutation without loops"),
        ({"theta": 0.0, "omega3": 200.0}, "spinning"),
        ({"theta": 2.5, "theta_dot": 1.0}, "planar pendulum"),
        ({"theta": 2.5, "phi_dot": 1.0}, "spherical pendulum"),
        ({"theta": math.pi}, "at rest"),
    ],
)
def test_motions_have_names(initial: dict[str, float], name: str) -> None:
    made = examples.problem("heavy-top", HEAVY, initial, 1.0)
    b, start = examples.si(made), examples.at_start(made)
    arguments = heavy_top.tip_inertia(b), b.I3, -b.m * b.g * b.c
    assert (
        heavy_top_motion.heavy_top_motion(start["energy"], start["Lz"], start["L3"], *arguments)
        == name
    )


def test_regular_precession_has_its_name() -> None:
    """I1* phi'^2 cos(theta) - I3 omega_3 phi' + m g l = 0."""
    inertia, theta, omega3 = 8e-5 + 0.1 * 0.04**2, 0.6, 200.0
    a, half, weight = inertia * math.cos(theta), 5e-5 * omega3 / 2, 0.1 * 9.82 * 0.04
    slow = (half - math.sqrt(half**2 - a * weight)) / a
    made = examples.problem(
        "heavy-top", HEAVY, {"theta": theta, "phi_dot": slow, "omega3": omega3}, 1.0
    )
    b, start = examples.si(made), examples.at_start(made)
    name = heavy_top_motion.heavy_top_motion(
        start["energy"], start["Lz"], start["L3"], inertia, b.I3, weight
    )
    assert name == "regular precession"
    assert np.ptp(examples.columns(solve(made))["theta"]) < 1e-13


# --- the tippe top with R alpha = -l, R -> 0 ----------------------------------------------------


def small_sphere(R: float) -> contact.Touch:
    return contact.Touch(0.1, R, -0.04, 8e-5, 5e-5, 9.82, Viscous(0.3))


TIP = contact.Touch(0.1, 0.0, -0.04, 8e-5, 5e-5, 9.82, Viscous(0.3))
RADII = 1e-5 * 0.5 ** np.arange(4)


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_equations_and_integrals_of_the_tippe_top_tend_to_the_gliding_heavy_top(
    rng: np.random.Generator,
) -> None:
    """Rates, jellett -> l L_3, (I1* lambda - l sqrt(I3 I1*) D)/(I1 R) -> L_z, V and d: all to first
    order in R.

    [T 5.57-5.77]"""
    e = gliding_euler.EulerState(*rng.uniform(0.2, 1.0, 6))
    e = e._replace(theta=0.7, omega3=200.0, phi_dot=4.0)
    s = gliding_euler.euler_scalars(e, TIP)
    inertia = heavy_top.tip_inertia(TIP)
    Lz = heavy_top.Lz(s, TIP)
    V = heavy_top.potential(s.z, Lz, s.L3, TIP)
    limit = np.array(gliding_euler.euler_rates(e, TIP))
    errors: dict[str, list[float]] = {"rates": [], "jellett": [], "Lz": [], "V": [], "d": []}
    for R in RADII:
        b = small_sphere(R)
        scalars = gliding_euler.euler_scalars(e, b)
        D, lam = tippe_top.routh(scalars, b), contact.jellett(scalars, b)
        errors["rates"].append(np.abs(np.array(gliding_euler.euler_rates(e, b)) - limit).max())
        errors["jellett"].append(abs(lam - 0.04 * s.L3))
        errors["Lz"].append(
            abs((inertia * lam - 0.04 * math.sqrt(b.I3 * inertia) * D) / (b.I1 * R) - Lz)
        )
        errors["V"].append(abs(tippe_top.potential(s.z, D, lam, b) - V))
        errors["d"].append(abs(tippe_top.d(s.z, b) - inertia / b.I3))
    for name, found in errors.items():
        assert np.all(np.abs(orders(found) - 1) < 0.02), (name, found)


def test_motions_of_the_tippe_top_tend_to_the_gliding_heavy_top() -> None:
    """theta(t) after half a second converges to first order in R."""
    start, until = {"theta": 0.4, "omega3": 300.0, "nu_x": 0.05, "nu_y": -0.02}, 0.5
    exact = examples.columns(
        examples.run("gliding-heavy-top", HEAVY, start, until, ("viscous", {"mu": 0.3}))
    )["theta"]
    errors = []
    for R in RADII:
        parameters = {"m": 0.1, "R": R, "alpha": -0.04 / R, "I1": 8e-5, "I3": 5e-5, "g": 9.82}
        made = examples.run(
            "tippe-top", parameters, start, until, ("viscous", {"mu": 0.3}), on_liftoff="continue"
        )
        errors.append(np.abs(examples.columns(made)["theta"] - exact).max())
    assert np.all(np.abs(orders(errors) - 1) < 0.05), errors


def test_main_equation_of_the_gliding_heavy_top_along_a_run() -> None:
    """E~ = I1* theta'^2/2 + V(z, L_z(t), L_3); L_3 constant. [T 5.26]"""
    made = examples.run(
        "gliding-heavy-top",
        HEAVY,
        {"theta": 0.4, "omega3": 300.0, "nu_x": 0.05},
        2.0,
        ("viscous", {"mu": 0.3}),
    )
    b, rows = examples.si(made.problem), examples.columns(made)
    V = heavy_top.potential(np.cos(rows["theta"]), rows["Lz"], rows["L3"], b)
    left = heavy_top.tip_inertia(b) / 2 * rows["theta_dot"] ** 2 + V
    np.testing.assert_allclose(left, rows["modified_energy"], rtol=1e-12)
    assert made.report["drift"]["L3"] < 1e-14


def test_the_fallen_top_stops_at_the_plane() -> None:
    made = examples.run(
        "gliding-heavy-top", HEAVY, {"theta": 0.4, "omega3": 10.0}, 4.0, ("viscous", {"mu": 0.3})
    )
    assert made.status is Status.FALLEN
    assert made.report["theta_end"] == pytest.approx(math.pi / 2, abs=1e-12)
    assert list(made.events.kind) == [2]


def test_forms_of_one_motion_agree() -> None:
    start = {"theta": 0.4, "omega3": 300.0, "nu_x": 0.05, "nu_y": -0.02, "phi": 0.3}
    rows = [
        examples.columns(
            examples.run(
                "gliding-heavy-top", HEAVY, start, 2.0, ("viscous", {"mu": 0.3}), form=form
            )
        )
        for form in SYSTEMS["gliding-heavy-top"].forms
    ]
    for other in rows[1:]:
        for name, values in rows[0].items():
            size = max(np.abs(values).max(), 1e-12)
            assert np.abs(other[name] - values).max() < 1e-11 * size, name


def test_view_of_the_vectors() -> None:
    made = examples.run("heavy-top", HEAVY, {"theta": 0.6, "omega3": 200.0}, 0.5, form="euler")
    L = examples.columns(made)["L"]
    rows = Observables(made.problem).columns(made.times, made.rows)
    np.testing.assert_allclose(L[:, 2], rows["Lz"].values, rtol=1e-13)


def test_the_angular_momentum_of_a_gliding_top_is_about_its_centre_of_mass() -> None:
    """L.3hat = L_3, for the column L; the quantity L_z is about the tip, and more by m l^2 phi'
    sin(theta)^2.
    """
    run = solve(build.load("gliding-heavy-top", until=0.2))
    c = {name: column.values for name, column in run.columns().items()}
    m, l = run.problem.parameters["m"], run.problem.parameters["l"]
    np.testing.assert_allclose(np.sum(c["L"] * c["axis"], axis=1), c["L3"], rtol=1e-13)
    np.testing.assert_allclose(
        c["L"][:, 2],
        c["Lz"] - m * l**2 * c["phi_dot"] * np.sin(c["theta"]) ** 2,
        rtol=1e-12,
        atol=1e-15,
    )
