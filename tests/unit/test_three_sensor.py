"""Three sensors: every root found, each root's load right, degeneracies named, bad input refused."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval

from subskin.contact import LineLoad
from subskin.errors import GeometryError, InvalidValueError
from subskin.material import Material
from subskin.memo._three_sensor_roots import Determinant
from subskin.memo.three_sensors import Degeneracy, Verdict, three_sensor
from subskin.skin import HalfPlane

EQUAL = [-0.75, 0.0, 0.75]


def read(position, angle, y, depth=1.0, young=1.0, poisson=0.5, plane="strain", force=1.0):
    skin = HalfPlane(Material(young, poisson), plane)
    return skin.strain(LineLoad(force, angle, position), x=depth, y=y).xx


def nearest(solution, position):
    return min(solution.roots, key=lambda root: abs(root.position - position))


# --- Exact arithmetic: the polynomial over the rationals, its real roots counted by Sturm's theorem ---


def times(a, b):
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, u in enumerate(a):
        for j, v in enumerate(b):
            out[i + j] += u * v
    return out


def polynomial(readings, y):
    """Equation (13) for depth 1, any spacing, nu = 1/2, in exact arithmetic; coefficients ascending."""
    e, s = [Fraction(float(v)) for v in readings], [Fraction(float(v)) for v in y]
    total = [Fraction(0)] * 9
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        q = [1 + s[i] ** 2, -2 * s[i], Fraction(1)]
        h = [[1 - s[m] ** 2, 2 * s[m], Fraction(-1)] for m in (j, k)]
        term = times(times(q, q), times(*h))
        total = [a + e[i] * (s[k] - s[j]) * b for a, b in zip(total, term, strict=True)]
    while total and total[-1] == 0:
        total.pop()
    return total


def value(poly, f):
    total = Fraction(0)
    for c in reversed(poly):
        total = total * f + c
    return total


def remainder(a, b):
    a = list(a)
    while len(a) >= len(b):
        factor = a[-1] / b[-1]
        for i in range(1, len(b) + 1):
            a[-i] -= factor * b[-i]
        a.pop()
    while a and a[-1] == 0:
        a.pop()
    return a


def sturm_count(poly):
    """Number of distinct real roots."""
    chain = [poly, [i * c for i, c in enumerate(poly)][1:]]
    while rest := remainder(chain[-2], chain[-1]):
        chain.append([-c for c in rest])
    at_plus = [p[-1] > 0 for p in chain]
    at_minus = [(p[-1] > 0) == (len(p) % 2 == 1) for p in chain]
    changes = [sum(a != b for a, b in itertools.pairwise(signs)) for signs in (at_minus, at_plus)]
    return changes[0] - changes[1]


def check_against_sturm(readings, y):
    poly = polynomial(readings, y)
    solution = three_sensor(readings, y, 1.0, young=1.0)
    assert solution.degree == len(poly) - 1
    assert len(solution.roots) == sturm_count(poly)
    assert all(root.multiplicity == 1 for root in solution.roots)
    for root in solution.roots:
        f = Fraction(root.position)
        reach = Fraction(1e-9) * max(1, abs(f))
        assert value(poly, f - reach) * value(poly, f + reach) < 0, root
    return solution


def dyadic(rng, low, high, size=None):
    """Numbers on a grid of 1/64, so that places in units of the depth are exact."""
    return np.round(rng.uniform(low, high, size) * 64) / 64


def test_sturm_count_counts():
    product = [Fraction(1)]
    for r in (-3, Fraction(1, 2), 2, 2):
        product = times(product, [Fraction(-r), Fraction(1)])
    assert sturm_count(times(product, [Fraction(1), Fraction(0), Fraction(1)])) == 3


def test_every_real_root_of_readings_of_a_load():
    rng = np.random.default_rng(771)
    for _ in range(120):
        b = dyadic(rng, 0.2, 3.0)
        y = [-b, 0.0, b]
        check_against_sturm(read(rng.uniform(-2 * b, 2 * b), rng.uniform(-1.5, 1.5), y), y)


def test_every_real_root_of_any_readings_at_any_pitch():
    rng = np.random.default_rng(13)
    counts = set()
    for _ in range(120):
        y = np.cumsum(dyadic(rng, 0.1, 2.5, 3) + 1 / 64) - 2
        solution = check_against_sturm(rng.standard_normal(3), y)
        counts.add(len(solution.roots))
    assert counts >= {2, 4, 6}


def test_every_real_root_where_sensors_are_blind_together():
    rng = np.random.default_rng(2)
    for y in ([-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0], [-1.25, 0.5, 0.75], [0.0, 2.0, 3.5], [0.0, 0.5, 2.5]):
        for _ in range(12):
            solution = check_against_sturm(rng.standard_normal(3), y)
            false = [root for root in solution.roots if root.verdict is Verdict.NOT_A_SOLUTION]
            pairs = [(a, b) for i, a in enumerate(y) for b in y[:i] if abs(a - b) == 2]
            assert [r.position for r in false] == sorted(0.5 * (a + b) for a, b in pairs)
            assert all(np.isnan(r.force) and np.isnan(r.angle) and r.residual > 1e-3 for r in false)


def test_derivatives_of_the_product_form():
    rng = np.random.default_rng(1)
    rows = [-0.7, 0.0, 0.9], [-1.0, 0.0, 1.0]
    for kappa, s in ((1.0, rows[0]), (1.0, rows[1]), (0.4, rows[0]), (0.0, rows[1])):
        determinant = Determinant(np.array(s), rng.standard_normal(3), kappa)
        coefficients, sizes = determinant.expand()
        for f in (-1.3, 0.2, 2.5):
            jet, size = determinant(f)
            expected = [polyval(f, polyder(coefficients, m)) for m in (0, 1, 2)]
            assert (jet.v, jet.d, 2 * jet.h) == pytest.approx(tuple(expected), rel=1e-11)
            assert abs(jet.v) <= size * (1 + 1e-12)
        assert (np.abs(coefficients) <= sizes * (1 + 1e-12)).all()


# --- The load of each root ---


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("poisson", [0.5, 0.47, 0.3, 0.05, 0.0])
def test_finds_the_load_and_every_root_makes_the_readings(plane, poisson):
    rng = np.random.default_rng(5)
    for _ in range(12):
        depth, young, force = rng.uniform(1e-3, 5e-3), rng.uniform(1e5, 1e7), rng.uniform(1, 100)
        y = 0.1 + depth * np.cumsum(rng.uniform(0.3, 1.5, 3))
        position, angle = rng.uniform(y[0], y[2]), rng.uniform(-0.75, 0.75)
        order = rng.permutation(3)
        readings = read(position, angle, y, depth, young, poisson, plane, force)
        found = three_sensor(readings[order], y[order], depth, young=young, poisson=poisson, plane=plane)
        true = nearest(found, position)
        assert true.verdict is Verdict.ACCEPTED
        assert true.position == pytest.approx(position, abs=1e-9 * depth)
        assert true.force == pytest.approx(force, rel=1e-9)
        assert true.angle == pytest.approx(angle, abs=1e-9)
        for root in found.roots:
            again = read(root.position, root.angle, y, depth, young, poisson, plane, root.force)
            assert np.abs(again - readings).max() < 1e-8 * np.abs(readings).max(), root
            assert root.residual < 1e-8
            tangent, normal = root.tangential_force, root.normal_force
            assert np.hypot(tangent, normal) == pytest.approx(root.force, rel=1e-14)


def test_verdicts_follow_the_force():
    found = three_sensor(read(0.3, 0.2, EQUAL), EQUAL, 1.0, young=1.0, friction=0.1)
    assert nearest(found, 0.3).verdict is Verdict.SLIPS
    for root in found.roots:
        pulls, cone = abs(root.angle) > np.pi / 2, abs(np.tan(root.angle)) <= 0.1
        assert root.verdict is (Verdict.PULLS if pulls else Verdict.ACCEPTED if cone else Verdict.SLIPS)
    assert {Verdict.PULLS, Verdict.SLIPS} <= {root.verdict for root in found.roots}


@pytest.mark.parametrize("angle", [-np.pi / 4, np.pi / 4])
def test_the_edge_of_the_friction_cone_belongs_to_it(angle):
    readings = read(0.3, angle, EQUAL)
    assert nearest(three_sensor(readings, EQUAL, 1.0, young=1.0), 0.3).verdict is Verdict.ACCEPTED
    less = three_sensor(readings, EQUAL, 1.0, young=1.0, friction=1 - 1e-6)
    assert nearest(less, 0.3).verdict is Verdict.SLIPS


def test_a_pull_has_a_positive_force_and_an_angle_beyond_a_right_one():
    readings = -read(0.3, 0.2, EQUAL)
    root = nearest(three_sensor(readings, EQUAL, 1.0, young=1.0), 0.3)
    assert root.verdict is Verdict.PULLS
    assert (root.force, root.angle) == pytest.approx((1.0, 0.2 - np.pi))
    straight = three_sensor(-read(0.0, 0.0, EQUAL), EQUAL, 1.0, young=1.0)
    assert abs(nearest(straight, 0.0).angle) == pytest.approx(np.pi)


def test_mirror_image():
    readings = read(0.3, 0.2, EQUAL)
    here = three_sensor(readings, EQUAL, 1.0, young=1.0)
    there = three_sensor(readings, [-v for v in EQUAL], 1.0, young=1.0)
    for root, image in zip(here.roots, reversed(there.roots), strict=True):
        mirrored = (-image.position, image.force, -image.angle, image.verdict)
        assert mirrored == pytest.approx((root.position, root.force, root.angle, root.verdict), rel=1e-12)


def test_sensitivity_is_the_derivative_of_the_answer():
    depth, young, y = 2e-3, 4e5, np.array([-1.7e-3, 0.1e-3, 1.4e-3])
    readings = read(0.5e-3, -0.3, y, depth, young, force=30.0)
    root = nearest(three_sensor(readings, y, depth, young=young), 0.5e-3)
    step = 1e-6 * np.abs(readings).max()
    answers = []
    for i in range(3):
        change = [nearest(three_sensor(readings + sign * step * np.eye(3)[i], y, depth, young=young), 0.5e-3)
                  for sign in (1, -1)]  # fmt: skip
        up, down = (np.array([r.position, r.force, r.angle]) for r in change)
        answers.append((up - down) / (2 * step))
    expected = np.sqrt((np.array(answers) ** 2).sum(axis=0))
    assert tuple(root.sensitivity) == pytest.approx(tuple(expected), rel=1e-6)


def test_jacobian_is_that_of_the_readings():
    depth, young, y = 2e-3, 4e5, np.array([-1.7e-3, 0.1e-3, 1.4e-3])

    def readings(p):
        normal, tangential = p[1] * young * depth, p[2] * young * depth
        angle = np.arctan2(tangential, normal)
        return read(p[0] * depth, angle, y, depth, young, force=np.hypot(normal, tangential))

    p = np.array([0.25, 0.04, -0.012])
    h = 1e-6 * np.eye(3)
    jacobian = np.stack([(readings(p + h[i]) - readings(p - h[i])) / 2e-6 for i in range(3)], axis=-1)
    root = nearest(three_sensor(readings(p), y, depth, young=young), 0.25 * depth)
    assert root.det_jacobian == pytest.approx(np.linalg.det(jacobian), rel=1e-6)


# --- Degeneracies, by name ---


def test_nothing_special_nothing_said():
    assert three_sensor(read(0.3, 0.2, EQUAL), EQUAL, 1.0, young=1.0).notes == ()


def test_no_contact():
    found = three_sensor([0, 0, 0], EQUAL, 1.0, young=1.0)
    assert found.has(Degeneracy.NO_CONTACT)
    assert (found.roots, found.accepted, found.degree) == ((), (), -1)


@pytest.mark.parametrize("origin", [0.0, 0.1137])
def test_pitch_is_the_depth(origin):
    y = origin + 2e-3 * np.array([-1, 0, 1])
    found = three_sensor(read(origin + 0.5e-3, 0.1, y, 2e-3), y, 2e-3, young=1.0)
    assert [n.kind for n in found.notes] == [Degeneracy.PITCH_IS_DEPTH]
    false = [root for root in found.roots if root.verdict is Verdict.NOT_A_SOLUTION]
    assert [root.position for root in false] == pytest.approx([origin], abs=1e-15)
    assert nearest(found, origin + 0.5e-3).verdict is Verdict.ACCEPTED


def test_pitch_is_the_depth_and_the_load_lies_over_the_middle():
    y = [-1.0, 0.0, 1.0]
    found = three_sensor(read(0.0, 0.3, y), y, 1.0, young=1.0)
    assert [n.kind for n in found.notes] == [Degeneracy.PITCH_IS_DEPTH, Degeneracy.FORCE_UNDETERMINED]
    root = nearest(found, 0.0)
    assert (root.verdict, root.multiplicity) == (Verdict.ACCEPTED, 2)
    assert root.normal_force == pytest.approx(np.cos(0.3), rel=1e-12)  # the tangential load leaves no trace
    assert root.tangential_force == pytest.approx(0.0, abs=1e-12)
    assert np.isinf(root.sensitivity).all()


def test_false_root_that_is_a_root_twice():
    found = three_sensor([0.1, -0.2, 0.1], [-1.0, 0.0, 1.0], 1.0, young=1.0)  # f is even in the place
    root = nearest(found, 0.0)
    assert (root.position, root.multiplicity, root.verdict) == (0.0, 2, Verdict.NOT_A_SOLUTION)
    assert root.residual == pytest.approx(0.5)
    assert [n.kind for n in found.notes] == [Degeneracy.PITCH_IS_DEPTH]


@pytest.mark.parametrize("b", [0.6, 1.0, 2.0])
def test_order_of_the_sensors_does_not_matter(b):
    y = np.array([-b, 0.0, b])
    readings = read(0.0, 0.0, y) if b == 0.6 else read(0.3, 0.2, y)
    sorted_ = three_sensor(readings, y, 1.0, young=1.0)
    assert sorted_.notes
    for order in ([2, 1, 0], [1, 0, 2], [2, 0, 1]):
        assert str(three_sensor(readings[order], y[order], 1.0, young=1.0)) == str(sorted_)


@pytest.mark.parametrize("off", [1e-8, 1e-5])
def test_a_load_close_to_the_false_root_is_told_from_it(off):
    y = [-1.0, 0.0, 1.0]
    found = three_sensor(read(off, 0.3, y), y, 1.0, young=1.0)
    close = [r for r in found.roots if abs(r.position) < 0.1]
    assert [r.verdict for r in close] == [Verdict.NOT_A_SOLUTION, Verdict.ACCEPTED]
    assert close[1].position == pytest.approx(off, rel=1e-6)
    assert close[1].angle == pytest.approx(0.3, abs=1e-6)


def test_pitch_is_two_depths():
    y = [-2.0, 0.0, 2.0]
    found = three_sensor(read(0.3, 0.1, y), y, 1.0, young=1.0)
    assert [n.kind for n in found.notes] == [Degeneracy.PITCH_IS_TWO_DEPTHS]
    assert [r.position for r in found.roots if r.verdict is Verdict.NOT_A_SOLUTION] == [-1.0, 1.0]


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_two_sensors_blind_to_one_position(poisson):
    blind = np.sqrt((1 - poisson) / poisson)
    y = [-blind, 0.2, blind]
    found = three_sensor(read(0.3, 0.1, y, poisson=poisson), y, 1.0, young=1.0, poisson=poisson)
    assert [n.kind for n in found.notes] == [Degeneracy.BLIND_TOGETHER]
    assert [r.position for r in found.roots if r.verdict is Verdict.NOT_A_SOLUTION] == [pytest.approx(0.0, abs=1e-12)]
    assert nearest(found, 0.3).angle == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("b", [0.3, 0.75, 1.4, 2.3])
def test_normal_load_over_the_middle_sensor(b):
    y = [-b, 0.0, b]
    found = three_sensor(read(0.0, 0.0, y, force=2.0), y, 1.0, young=1.0)
    assert [n.kind for n in found.notes] == [Degeneracy.NORMAL_LOAD_OVER_MIDDLE]
    root = nearest(found, 0.0)
    assert (root.multiplicity, root.verdict) == (2, Verdict.ACCEPTED)
    assert (root.position, root.force, root.angle) == pytest.approx((0.0, 2.0, 0.0), abs=1e-9)
    assert np.isinf(root.sensitivity).all()


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.7])
def test_pitch_of_root_three_depths(angle):
    b = np.sqrt(3)
    y = [-b, 0.0, b]
    found = three_sensor(read(0.0, angle, y), y, 1.0, young=1.0)
    double = Degeneracy.DOUBLE_ROOT if angle else Degeneracy.NORMAL_LOAD_OVER_MIDDLE
    assert [n.kind for n in found.notes] == [Degeneracy.PITCH_IS_SQRT3_DEPTHS, double]
    root = nearest(found, 0.0)
    assert root.multiplicity == 2
    assert root.angle == pytest.approx(angle, abs=1e-6)


def test_degree_seven_and_six():
    seven = three_sensor([-0.1, -0.2, -0.3], EQUAL, 1.0, young=1.0)
    six = three_sensor([-0.1, -0.1, -0.1], EQUAL, 1.0, young=1.0)
    assert (seven.degree, six.degree) == (7, 6)
    assert seven.has(Degeneracy.DEGREE_DROPS)
    assert six.has(Degeneracy.DEGREE_DROPS)
    uneven = three_sensor([-0.1, -0.2, -0.4], [0.0, 0.5, 1.5], 1.0, young=1.0)  # on a line along y
    assert uneven.degree == 7
    assert all(abs(r.position) < 1e3 for s in (seven, six, uneven) for r in s.roots)


def test_degree_drops_with_readings_that_were_rounded():
    rng = np.random.default_rng(9)
    for _ in range(50):
        y = np.cumsum(rng.uniform(0.2, 1.0, 3))
        offset, slope = rng.uniform(-1, 1, 2)
        found = three_sensor(offset + slope * y, y, 1.0, young=1.0)
        assert found.degree == 7
        level = three_sensor(offset * (1 + 1e-15 * rng.standard_normal(3)), y, 1.0, young=1.0)
        assert level.degree == 6


@pytest.mark.parametrize("silent", [(0,), (1,), (2,), (0, 1), (0, 2), (1, 2)])
def test_sensors_that_read_nothing(silent):
    readings = np.array([-0.3, -0.5, -0.2])
    readings[list(silent)] = 0.0
    found = three_sensor(readings, EQUAL, 1.0, young=1.0)
    for i in silent if len(silent) == 1 else ():
        # a load one depth beside a sensor that reads nothing explains it, whatever the others read
        positions = [r.position for r in found.roots if r.residual < 1e-12]
        assert any(abs(p - EQUAL[i] - 1) < 1e-12 for p in positions)
        assert any(abs(p - EQUAL[i] + 1) < 1e-12 for p in positions)
    for root in found.roots:
        again = read(root.position, root.angle, EQUAL, force=root.force)
        assert again == pytest.approx(readings, abs=1e-12)


def test_noise_splits_a_double_root_and_the_tolerance_mends_it():
    rng = np.random.default_rng(3)
    clean = read(0.0, 0.0, EQUAL)
    seen = set()
    for _ in range(20):
        readings = clean + 1e-4 * np.abs(clean).max() * rng.standard_normal(3)
        strict = [r for r in three_sensor(readings, EQUAL, 1.0, young=1.0).roots if abs(r.position) < 0.3]
        seen.add(len(strict))
        lenient = three_sensor(readings, EQUAL, 1.0, young=1.0, tolerance=1e-3)
        (root,) = [r for r in lenient.roots if abs(r.position) < 0.3]
        assert (root.multiplicity, root.verdict) == (2, Verdict.ACCEPTED)
        assert root.force == pytest.approx(1.0, rel=1e-3)
        assert lenient.has(Degeneracy.NORMAL_LOAD_OVER_MIDDLE)
    assert seen == {0, 2}


def test_wild_numbers_neither_warn_nor_fail():
    rng = np.random.default_rng(8)
    for _ in range(300):
        depth = 10 ** rng.uniform(-6, 3)
        y = depth * (np.cumsum(10 ** rng.uniform(-3, 2.5, 3)) + rng.standard_normal())
        readings = rng.standard_normal(3) * 10 ** rng.uniform(-250, 250, 3)
        given = {"poisson": rng.uniform(0, 0.5), "plane": rng.choice(["strain", "stress"])}
        found = three_sensor(readings, y, depth, young=1e6, tolerance=rng.choice([0.0, 1e-12, 0.1]), **given)
        for root in found.roots:
            assert np.isfinite(root.position)
            assert np.isfinite(root.force) == (root.verdict is not Verdict.NOT_A_SOLUTION)


# --- Bad input ---


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"readings": [0.1, 0.2]}, GeometryError, r"readings of shape \(2,\)"),
        ({"readings": [0.1, np.nan, 0.2]}, InvalidValueError, r"readings\[1\] = nan"),
        ({"readings": ["a", 1, 2]}, InvalidValueError, "real number"),
        ({"y": [0.0, 1.0]}, GeometryError, r"y of shape \(2,\)"),
        ({"y": [0.0, 1.0, 0.0]}, GeometryError, "have to differ"),
        ({"depth": 0.0}, InvalidValueError, "depth = 0"),
        ({"depth": [1.0, 1.0, 1.0]}, InvalidValueError, "single number"),
        ({"young": -1.0}, InvalidValueError, "young = -1"),
        ({"poisson": 0.6}, InvalidValueError, "poisson = 0.6"),
        ({"plane": "both"}, InvalidValueError, "plane = 'both'"),
        ({"friction": -0.1}, InvalidValueError, "friction = -0.1"),
        ({"tolerance": 0.5}, InvalidValueError, "tolerance = 0.5"),
    ],
)
def test_bad_input_is_refused(change, error, words):
    given = {"readings": [-0.1, -0.2, -0.1], "y": EQUAL, "depth": 1.0, "young": 1.0, **change}
    with pytest.raises(error, match=words):
        three_sensor(**given)


def test_integers_mean_floats_and_inputs_stay():
    readings, y = np.array([-1, -3, -2]), np.array([1, 0, -1])
    found = three_sensor(readings, y, 2, young=1)
    assert found == three_sensor(readings.astype(float), y.astype(float), 2.0, young=1.0)
    assert readings.tolist() == [-1, -3, -2]
    assert y.tolist() == [1, 0, -1]
