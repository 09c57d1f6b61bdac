"""Formulas written down in another language compute what the formulas do."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.contact_phases import FLIGHT
from tippetop.mechanics.friction import LAWS, Mixed
from tippetop.mechanics.operand import atan2, exp, formula, leaves, sqrt
from tippetop.mechanics.theory.thresholds import thresholds
from tippetop.mechanics.writing import CPP, JAVASCRIPT, function
from tippetop.views import phase_formulas
from tippetop.views.phase_formulas import TOP


NODE = shutil.which("node")


@formula
def entangled(x, y):
    """Arithmetic of all kinds, with repeated parts."""
    w = (x - y) * (x - y)
    return (
        sqrt(w + 1) / (2 - -x),
        exp(-w) * 3.5e-7 - 0 * y,
        atan2(y, x) ** 3,
        np.float64(2) * x,
        np.maximum(w, 0.5),
        (-2.0) - x,
    )


def written(language, names, formula):
    lines, results = function(language, names, formula)
    return "\n".join(lines), results


def test_each_part_is_written_once_and_what_is_not_needed_not_at_all() -> None:
    text, results = written(CPP, ["x", "y"], lambda s: entangled(*s)[:2])
    assert text.count("v0 - v1") == text.count("std::exp") == text.count("std::sqrt") == 1
    assert "atan" not in text
    assert len(results) == 2


@pytest.mark.skipif(NODE is None, reason="no node")
def test_javascript_computes_what_python_does() -> None:
    text, results = written(JAVASCRIPT, ["x", "y"], lambda s: entangled(*s))
    points = np.random.default_rng(3).normal(size=(50, 2))
    script = f"const f = (x, y) => {{{text} return [{', '.join(results)}];}};"
    found = run(
        f"{script} console.log(JSON.stringify({json.dumps(points.tolist())}.map(([x, y]) => "
        "f(x, y))))"
    )
    np.testing.assert_allclose(found, [entangled(*p) for p in points], rtol=1e-15)


@pytest.mark.skipif(NODE is None, reason="no node")
def test_the_right_hand_side_and_the_thresholds_of_a_top_survive_the_journey() -> None:
    law, form = LAWS["mixed"], FLIGHT.forms["vector"]
    numbers = [0.02, 0.021, 0.3, 3e-6, 3.2e-6, 9.82, 0.3, 0.2, 1e-2]
    b = TOP.body_of(dict(zip(TOP.parameters, numbers, strict=False)), Mixed(*numbers[6:]))
    assert isinstance(b, Touch)
    q = np.random.default_rng(4).normal(size=10)
    module = phase_formulas.contacts({"mixed": law})["phases.js"].replace("export ", "")
    found = run(
        f"{module} const f = formulas.mixed, b = f.body({numbers}), out = new Float64Array(16);"
        f"f.rates([...{q.tolist()}, 0, 0, 1, 0, 0, 0], b, out);"
        "console.log(JSON.stringify([b, [...out].slice(0, 10), f.thresholds(b).map(t => t.value)]))"
    )
    np.testing.assert_allclose(found[0], leaves(b), rtol=1e-15)
    np.testing.assert_allclose(found[1], form.rates(type(form.units)(*q), b), rtol=1e-13)
    np.testing.assert_allclose(found[2], [t.value for t in thresholds(b).values()], rtol=1e-14)


def run(script: str):
    assert NODE is not None
    done = subprocess.run([NODE, "-e", script], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)
