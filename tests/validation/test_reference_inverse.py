"""Three sensors against 80-digit reference values (30 cases), and how often their readings are ambiguous."""

import json
from pathlib import Path

import numpy as np
import pytest

from subskin.memo.three_sensors import Degeneracy, Verdict, three_sensor

REFERENCE = Path(__file__).resolve().parents[3] / "shared" / "reference" / "11a_inverse_three_sensors.json"
CASES = json.loads(REFERENCE.read_text())["cases"] if REFERENCE.exists() else []


@pytest.mark.skipif(not CASES, reason="the reference values are not beside this checkout")
def test_all_cases_are_there():
    assert len(CASES) == 30


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["label"])
def test_roots_forces_and_verdicts(case):
    b, depth = case["b_spacing"], case["x_depth"]
    readings = [case["eps1"], case["eps2"], case["eps3"]]
    # The reference puts sensor 1 at +b and the load at -y: our axis reversed, which is the one where y is the
    # load's place.
    found = three_sensor(readings, [-b, 0.0, b], depth, young=1.0)
    assert found.degree == case["polynomial_degree"]
    roots = [root for root in found.roots for _ in range(root.multiplicity)]
    assert len(roots) == len(case["real_roots"])
    for root, expected in zip(roots, case["real_roots"], strict=True):
        assert root.position == pytest.approx(expected["y"], rel=1e-9, abs=1e-12 * depth)
        assert (root.verdict is not Verdict.NOT_A_SOLUTION) == expected["solves_eq12"]
        if not expected["solves_eq12"]:
            continue
        assert root.force == pytest.approx(expected["P_over_E"], rel=1e-9)
        assert root.angle == pytest.approx(expected["alpha_rad"], rel=1e-9, abs=1e-12)
        assert (root.verdict is Verdict.PULLS) == expected["tension"]
        assert (root.verdict is Verdict.ACCEPTED) == expected["admissible_45deg"]
        # detJ of d(eps)/d(y, A/E, B/E) has a length cubed in it; twice-counted roots have none
        assert root.det_jacobian / depth**3 == pytest.approx(expected["detJ"], rel=1e-8, abs=1e-15)


@pytest.mark.skipif(not CASES, reason="the reference values are not beside this checkout")
def test_named_cases_are_named():
    kinds = {}
    for case in CASES:
        b = case["b_spacing"]
        found = three_sensor([case["eps1"], case["eps2"], case["eps3"]], [-b, 0.0, b], case["x_depth"], young=1.0)
        kinds[case["label"].split(":")[0]] = {note.kind for note in found.notes}
    assert kinds["b=x"] == {Degeneracy.PITCH_IS_DEPTH}
    assert kinds["b=2x"] == {Degeneracy.PITCH_IS_TWO_DEPTHS}
    assert kinds["y=0, alpha=0"] == {Degeneracy.NORMAL_LOAD_OVER_MIDDLE}
    assert kinds["2 eps2 = eps1+eps3"] == {Degeneracy.DEGREE_DROPS}
    assert all(not noted for label, noted in kinds.items() if label.startswith("random"))


# Spacing in depths: share of loads within half a spacing of the middle and 45 degrees for which a second load
# explains the readings as well (physics/FORMULAS.md section 1.2, rounded there).
AMBIGUOUS = {0.3: 0.86, 0.5: 0.997, 0.7: 0.74, 0.8: 0.45, 0.9: 0.24, 1.0: 0.039, 1.1: 0.24, 1.2: 0.43, 1.4: 0.70}


def accepted_loads(b, reach, count):
    """Place, angle and accepted roots of loads within `reach` of the middle and 45 degrees of the normal."""
    rng = np.random.default_rng(12)
    y = np.array([-b, 0.0, b])
    for _ in range(count):
        position, angle = rng.uniform(-reach, reach), rng.uniform(-np.pi / 4, np.pi / 4)
        t = y - position
        readings = -1.5 / np.pi * (np.cos(angle) + t * np.sin(angle)) * (1 - t**2) / (1 + t**2) ** 2
        yield position, angle, three_sensor(readings, y, 1.0, young=1.0).accepted


@pytest.mark.parametrize(("b", "share"), AMBIGUOUS.items())
def test_share_of_ambiguous_readings(b, share):
    count = ambiguous = 0
    for position, angle, accepted in accepted_loads(b, b / 2, 600 if share in (0.039, 0.997) else 200):
        assert any(abs(root.position - position) < 1e-8 and abs(root.angle - angle) < 1e-6 for root in accepted)
        count += 1
        ambiguous += len(accepted) > 1
    # three standard deviations of the count, and as much again as the expected share was rounded by
    margin = 3 * np.sqrt(share * (1 - share) / count) + 0.01
    assert ambiguous / count == pytest.approx(share, abs=margin)


@pytest.mark.parametrize(("b", "least", "most"), [(1.0, 0.0, 0.0), (0.8, 0.1, 0.3), (0.5, 0.7, 0.95)])
def test_second_load_within_the_array(b, least, most):
    """With spacing = depth there is none for loads over the array (FORMULAS.md: 0 of 3000)."""
    inside = [sum(abs(r.position) <= b for r in accepted) for _, _, accepted in accepted_loads(b, b, 200)]
    assert min(inside) == 1
    assert least <= np.mean(np.array(inside) > 1) <= most
