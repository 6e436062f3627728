"""Fits of round contacts that stick in their middle: by `PartialSlip`'s own readings, and a bound of differences."""

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError

DEPTH, MU, N, AT, A = 2e-3, 0.6, 30.0, 0.3e-3, 1.6e-3
RUBBER = ss.Material(0.4e6)
SKINS = {"half plane": ss.HalfPlane(RUBBER), "layer": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 2 * DEPTH))}


def touch(share, position=AT, half_width=A, mu=MU, normal=N):
    """A contact with |T| = share mu N."""
    angle = np.arctan(np.asarray(share) * mu)
    return ss.PartialSlip(normal / np.cos(angle), angle, position, half_width=half_width, friction=mu)


def finger(skin, count):
    """With noise of 0.1 % of the largest reading."""
    quiet = ss.Finger(skin, ss.SensorArray.line(count, pitch=0.5 * DEPTH, depth=DEPTH, noise=1.0))
    noise = 1e-3 * np.abs(quiet.read(touch(0.5))).max()
    return ss.Finger(skin, ss.SensorArray.line(count, pitch=0.5 * DEPTH, depth=DEPTH, noise=noise))


@pytest.fixture(scope="module", params=[("half plane", 6), ("half plane", 8), ("layer", 6)], ids=str)
def tip(request):
    skin, count = request.param
    return finger(SKINS[skin], count)


@pytest.fixture(scope="module")
def six():
    return finger(SKINS["half plane"], 6)


def bound(tip, share, spread=0.0):
    """Covariance of (position, N, T, half width) by differences of the forward model; mu known, or to within spread."""

    def read(p):
        angle = np.arctan2(p[2], p[1])
        return tip.read(ss.PartialSlip(np.hypot(p[1], p[2]), angle, p[0], half_width=p[3], friction=p[4]))

    truth = np.array([AT, N, share * MU * N, A, MU])
    steps = np.diag([1e-7, 1e-3, 1e-3, 1e-7, 1e-4])[: 5 if spread else 4]
    columns = [(read(truth + h) - read(truth - h)) / (2 * h.sum()) for h in steps]
    jacobian = np.stack(columns, -1) / np.asarray(tip.array.noise)[:, None]
    information = jacobian.T @ jacobian
    if spread:
        information[4, 4] += 1 / spread**2
    return np.linalg.inv(information)[:4, :4]


def values(found):
    return np.column_stack([found.position, found.components, found.half_width])


def test_the_drag_half_way_to_slipping_is_found_to_the_bound(tip):
    frames = np.repeat(tip.read(touch(0.5))[None], 800, axis=0)
    frames += np.asarray(tip.array.noise) * np.random.default_rng(0).normal(size=frames.shape)
    found = tip.fit(frames, stick=MU)
    assert found.ok.all()
    errors = values(found) - [AT, N, 0.5 * MU * N, A]
    square = bound(tip, 0.5)
    assert abs(errors[:, 2].mean()) < 0.01 * MU * N
    if isinstance(tip.skin, ss.HalfPlane):  # on this layer the bound itself is 0.03 of mu N
        assert np.sqrt(np.mean(errors[:, 2] ** 2)) < 0.01 * MU * N
    assert np.sqrt(np.mean(errors**2, axis=0) / np.diag(square)) == pytest.approx(np.ones(4), abs=0.1)
    exact = tip.fit(tip.read(touch(0.5)), stick=MU)
    assert exact.residual < 1e-6
    assert exact.table[exact.layout.square] == pytest.approx(square, rel=2e-3, abs=1e-30)
    assert found.residual.mean() == pytest.approx(found.spare[0], rel=0.15)
    # a fit of a contact that slides finds too little of it, if it explains the readings at all
    slides = tip.fit(tip.read(touch(0.5)), false_alarm=1e-300)
    assert slides.components[1] < (0.5 - 0.05) * MU * N


def test_every_contact_within_the_search_comes_back(six):
    rng = np.random.default_rng(3)
    share, y, a = rng.uniform(-1, 1, 60), rng.uniform(-2e-3, 2e-3, 60), rng.uniform(0.2, 1.3, 60) * DEPTH
    contact = touch(share, y, a)
    found = six.fit(six.read(contact), stick=MU)
    assert found.ok.mean() > 0.95
    truth = np.column_stack([y, np.full(60, N), share * MU * N, a])[found.ok]
    assert values(found)[found.ok] / [DEPTH, N, N, DEPTH] == pytest.approx(truth / [DEPTH, N, N, DEPTH], abs=1e-4)


def test_what_slides_is_fitted_as_by_a_fit_of_what_slides(six):
    """At mu N and beyond it, noise or not, as far as the estimator's own cone."""
    share = np.array([1.0, 1.0, 1.2, -1.2, 1.2, -1.2])
    frames = six.read(ss.Hertz(N, np.arctan(share * MU), AT, half_width=A))
    frames[4:] += np.asarray(six.array.noise) * np.random.default_rng(1).normal(size=(2, 6))
    sticks, slides = six.fit(frames, stick=MU), six.fit(frames)
    assert (sticks.status == slides.status).all()
    assert values(sticks) == pytest.approx(values(slides), rel=1e-4)
    assert sticks.table[2:, sticks.layout.square] == pytest.approx(slides.table[2:, slides.layout.square], rel=1e-3)
    assert sticks.residual == pytest.approx(slides.residual, rel=1e-5, abs=1e-5)


def test_no_drag_is_no_special_case(six):
    found = six.fit(six.read(touch([0.0, 1e-12, -1e-12, 1e-6, -1e-6])), stick=MU)
    assert found.ok.all()
    assert found.components[:, 1] == pytest.approx(np.array([0, 0, 0, 1e-6, -1e-6]) * MU * N, abs=1e-6 * N)
    assert found.table[0][found.layout.square] == pytest.approx(found.table[1][found.layout.square], rel=1e-4)
    assert np.isfinite(found.std).all()


def test_a_range_of_friction_is_allowed_for(six):
    """As one more unknown, of which the range is one more reading."""
    low, high = 0.4, 0.8
    wide = six.fit(six.read(touch(0.5)), stick=(low, high))
    square = bound(six, 0.5, spread=(high - low) / np.sqrt(12))
    assert wide.table[wide.layout.square] == pytest.approx(square, rel=5e-3, abs=1e-30)
    assert wide.residual < 1e-6
    assert wide.spare == 2
    known = six.fit(six.read(touch(0.5)), stick=MU)
    assert wide.table[wide.layout.square[2, 2]] > 1.1 * known.table[known.layout.square[2, 2]]
    assert six.fit(six.read(touch(0.5)), stick=(MU, MU)).table == pytest.approx(known.table, nan_ok=True)


def test_what_is_no_such_contact_is_unexplained(six):
    others = ss.FlatPunch(N, 0.2, AT, half_width=A), ss.Wedge(N, 0.2, AT, half_width=A)
    found = six.fit([six.read(other) for other in others], stick=MU)
    assert (found.status == ss.Status.UNEXPLAINED).all()
    assert np.isnan(found.position).all()
    assert six.fit(np.zeros(6), stick=MU).status == ss.Status.NO_CONTACT
    lost = six.read(touch(0.5))
    lost[:3] = np.nan
    assert six.fit(lost, stick=MU).status == ss.Status.INCOMPLETE


def test_where_another_drag_explains_as_much_it_is_ambiguous():
    """Five sensors, the contact in their middle: another share of slip, or a drag the other way, reads the same."""
    tip = finger(SKINS["half plane"], 5)
    rng = np.random.default_rng(5)
    share, y, a = rng.uniform(-1, 1, 400), rng.uniform(-0.1, 0.1, 400) * DEPTH, rng.uniform(0.8, 1.2, 400) * DEPTH
    exact = tip.read(touch(share, y, a))
    found = tip.fit(exact + np.asarray(tip.array.noise) * rng.normal(size=exact.shape), stick=MU)
    assert (found.status != ss.Status.UNEXPLAINED).all()
    wrong = np.abs(found.components[:, 1] - share * MU * N) > 0.3 * MU * N
    assert (wrong & found.ok).sum() == 0
    assert wrong.sum() >= 5  # it is no easy case
    rival = found.second.components[:, 1]
    assert (np.abs(rival - share * MU * N) < 0.3 * MU * N)[wrong].mean() > 0.8
    assert found.ok.mean() > 0.5


def test_what_neither_explains_is_not_called_nothing(six):
    odd = 2.4 * np.asarray(six.array.noise) * np.array([1, -1, 1, -1, 1, -1])
    assert six.fit(odd).status == six.fit(odd, stick=MU).status == ss.Status.UNEXPLAINED


@pytest.mark.parametrize("stick", [MU, (0.3, 0.9)], ids=["known", "range"])
def test_a_known_half_width_and_range_of_force_are_used(six, stick):
    frame = six.read(touch(0.5))
    found = six.fit(frame, stick=stick, half_width=(A, A), normal_force=(20.0, 40.0))
    assert found.ok
    assert [found.position, *found.components, found.half_width] == pytest.approx([AT, N, 0.5 * MU * N, A], rel=1e-5)
    assert found.std[3] == 0
    assert six.fit(frame, stick=stick, normal_force=(35.0, 50.0)).status == ss.Status.UNEXPLAINED


def test_the_cone_of_the_search_binds_before_friction(six):
    found = six.fit(six.read(touch(0.8, mu=0.4)), stick=0.4, friction=0.3, false_alarm=1e-300)
    assert found.status == ss.Status.AMBIGUOUS
    assert found.components[1] == pytest.approx(0.3 * found.components[0], rel=1e-9)


@pytest.mark.parametrize(
    ("family", "options", "said"),
    [
        ("wedge", {"stick": 0.5}, 'only "hertz"'),
        ("hertz", {"stick": 0.5, "friction": 0.0}, "without drag"),
        ("hertz", {"stick": 0.0}, "> 0"),
        ("hertz", {"stick": (0.8, 0.4)}, "ascend"),
        ("hertz", {"stick": np.nan}, "finite"),
        ("hertz", {"stick": (0.1, 0.2, 0.3)}, "two that ascend"),
    ],
)
def test_what_cannot_be_is_refused(six, family, options, said):
    with pytest.raises(InvalidValueError, match=said):
        six.fit(np.zeros(6), family, **options)
