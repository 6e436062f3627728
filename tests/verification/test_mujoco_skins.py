"""Skins on geoms of MuJoCo: forces against MuJoCo's own, pressures against closed forms and `press` on a finer grid."""

import numpy as np
import pytest

import subskin as ss
from subskin.mujoco import GeomSkin, contact_to_skin
from subskin.mujoco.footing import footing_of
from subskin.mujoco.pressed import Outline, PressedFeet

mujoco = pytest.importorskip("mujoco")

RUBBER = ss.Material(young=0.4e6)
ARRAY = ss.SensorArray.grid((4, 4), 4e-3, depth=2.5e-3, noise=2e-4)
FINGER = ss.Finger(ss.HalfSpace(RUBBER), ARRAY)
PUSH = np.array([0.15, 0.1, -2.0, 0.0, 0.0, 4e-4])

THINGS = {
    "ball": ('type="sphere" size=".02"', 0.0249, ""),
    "box inside": ('type="box" size=".005 .004 .01"', 0.0149, ""),
    "box beyond": ('type="box" size=".02 .02 .01"', 0.0149, ""),
    "box turned": ('type="box" size=".006 .006 .01"', 0.0149, 'euler="0 0 30"'),
    "box over the rim": ('type="box" size=".008 .008 .01"', 0.0149, 'euler="0 0 20"'),
    "bottle on its side": ('type="cylinder" size=".02 .03"', 0.0249, 'euler="90 0 20"'),
    "bottle upright": ('type="cylinder" size=".006 .03"', 0.0349, ""),
    "egg": ('type="ellipsoid" size=".02 .03 .015"', 0.0199, ""),
    "capsule": ('type="capsule" size=".01 .03"', 0.0149, 'euler="90 0 0"'),
}


def scene(
    geom: str, height: float, turn: str = "", pad: str = 'type="box" size=".01 .01 .005"', cone: str = "elliptic"
):
    """A thing on a pad whose upper face is at z = 5 mm, pressed down and sideways after it has settled."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option cone="{cone}" impratio="10" timestep="0.001"/><worldbody>'
        f'<geom name="pad" {pad} friction="1 .01 .001" condim="4"/><body pos="0.0006 -0.0004 {height}" {turn}>'
        f'<freejoint/><geom name="thing" {geom} mass=".1" condim="4" friction="1 .01 .001"/></body>'
        "</worldbody></mujoco>"
    )
    return model, mujoco.MjData(model)


def pressed(model, data, steps: int = 40, push: np.ndarray = PUSH):
    data.xfrc_applied[1] = push
    mujoco.mj_step(model, data, steps)
    return data


def wrench(model, data, skin: GeomSkin) -> np.ndarray:
    """MuJoCo's force and moment on the pad about the middle of its face, in the skin's axes."""
    total, one, pad = np.zeros(6), np.zeros(6), model.geom("pad").id
    turn = data.geom_xmat[pad].reshape(3, 3)
    middle = data.geom_xpos[pad] + turn @ skin.surface.origin
    for i in range(data.ncon):
        contact = data.contact[i]
        mujoco.mj_contactForce(model, data, i, one)
        sign = 1.0 if contact.geom2 == pad else -1.0
        force, twist = (sign * contact.frame.reshape(3, 3).T @ part for part in (one[:3], one[3:]))
        total += np.concatenate([force, np.cross(contact.pos - middle, force) + twist])
    axes = skin.surface.axes @ turn.T
    return np.concatenate([axes @ total[:3], axes @ total[3:]])


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
@pytest.mark.parametrize("name", THINGS)
def test_the_points_carry_mujocos_force_and_moment(name, cone):
    geom, height, turn = THINGS[name]
    model, data = scene(geom, height, turn, cone=cone)
    skin = GeomSkin(model, "pad", FINGER, "+z")
    for _ in range(5):
        felt = skin.feel(pressed(model, data, 8))
        (y, z), (n, along, across) = felt.points.T, felt.forces.T
        moment = np.array([y @ across - z @ along, z @ n, -(y @ n)])
        expected = wrench(model, data, skin)
        assert expected[0] > 0.1
        assert np.abs(felt.forces.sum(axis=0) - expected[:3]).max() < 1e-9
        assert np.abs(moment - expected[3:]).max() < 1e-11
        assert np.allclose(felt.force, expected[:3], rtol=0, atol=1e-9)
        assert np.allclose(felt.moment, expected[3:], rtol=0, atol=1e-11)
        assert (n >= 0).all()
        y0, z0 = n @ felt.points / n.sum()
        assert felt.torsion == pytest.approx((y - y0) @ across - (z - z0) @ along, abs=1e-12)
        assert not felt.beside.any()


def off(felt, truth) -> float:
    """Largest error of the readings under normal forces alone, over the largest reading."""
    expected = FINGER.read(truth)
    forces = felt.forces * [1.0, 0.0, 0.0]
    return float(np.abs(felt.skin.read(felt.points, forces) - expected).max() / np.abs(expected).max())


def centre(felt) -> np.ndarray:
    return felt.forces[:, 0] @ felt.points / felt.force[0]


def hertz_radius(force: float, radius: float) -> float:
    return (0.75 * force * radius / RUBBER.plane_strain_modulus) ** (1 / 3)


def test_a_ball_presses_as_hertz_says():
    felt = contact_to_skin(*settled("ball"), "pad", FINGER, "+z")
    n = felt.force[0]
    assert off(felt, ss.RoundHertz(force=n, position=centre(felt), half_width=hertz_radius(n, 0.02))) < 5e-3


def test_an_egg_presses_an_ellipse():
    felt = contact_to_skin(*settled("egg"), "pad", FINGER, "+z")
    model_radii = 0.02**2 / 0.015, 0.03**2 / 0.015
    body = ss.pressing.Ellipsoid(*model_radii)
    # the skin's y is the world's -x here: an ellipse is the same either way
    solved = ss.press(FINGER.skin, body, force=felt.force[0], nodes=128, max_strain=None)
    assert off(felt, moved(solved, centre(felt))) < 1e-2


def test_a_bottle_upright_presses_as_a_punch_that_leans():
    model, data = settled("bottle upright")
    felt = contact_to_skin(model, data, "pad", FINGER, "+z")
    middle = foot(data, 0.03)
    leans, n, radius = centre(felt) - middle, felt.force[0], 6e-3
    assert np.abs(leans).max() > 1e-4
    # rings of a flat punch, whose pressure leans by 3 e.r / a^2 (Johnson, section 3.5), as points
    u, w = np.polynomial.legendre.leggauss(40)
    angle = 2 * np.pi / 64 * np.arange(64)
    r = radius * np.sin(np.pi / 4 * (u + 1))[:, None]
    share = (np.pi / 4 * w * np.sin(np.pi / 4 * (u + 1)))[:, None] / 64
    y, z = r * np.cos(angle), r * np.sin(angle)
    forces = n * share * (1 + 3 * (leans[0] * y + leans[1] * z) / radius**2)
    points = middle + np.stack([y, z], axis=-1).reshape(-1, 2)
    normal = np.outer(forces.ravel(), [1.0, 0.0, 0.0])
    expected = FINGER.read(ss.PointLoad(components=normal, position=points), sum_over=0)
    found = felt.skin.read(felt.points, felt.forces * [1.0, 0.0, 0.0])
    assert np.abs(found - expected).max() < 0.015 * np.abs(expected).max()


def foot(data, height: float) -> np.ndarray:
    """Where the middle of the thing's lower face is, (y, z) of the skin; it leans a little."""
    return (FINGER_AXES @ (data.geom_xpos[1] - data.geom_xmat[1].reshape(3, 3)[:, 2] * height))[1:]


def moved(solved, position):
    """What `press` found about 0, elsewhere."""
    grid = solved.contact
    return ss.PressureGrid(grid.nodes_y + position[0], grid.nodes_z + position[1], grid.node_pressure)


def settled(name: str, push: tuple = (0.0, 0.0, -2.0)):
    geom, height, turn = THINGS[name]
    model, data = scene(geom, height, turn)
    return model, pressed(model, data, 20, np.array([*push, 0.0, 0.0, 0.0]))


def test_a_box_presses_as_press_says_where_it_leans():
    model, data = settled("box inside", (0.25, 0.0, -2.0))
    felt = GeomSkin(model, "pad", FINGER, "+z").feel(data)
    middle = foot(data, 0.01)
    leans = centre(felt) - middle
    assert np.abs(leans).max() > 2e-4
    n, sides = felt.force[0], np.abs(FINGER_AXES[1:, :2]) @ [5e-3, 4e-3]
    solved = ss.press(
        FINGER.skin, ss.pressing.Box(*sides), force=n, moment=tuple(n * leans), nodes=512, max_strain=None
    )
    assert off(felt, moved(solved, middle)) < 0.012


FINGER_AXES = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Of a skin on a face +z: x down, z along the geom's y."""


def test_the_axes_of_a_skin_are_right_handed_and_x_goes_in():
    model, _ = scene(*THINGS["ball"])
    for face in ("+x", "-x", "+y", "-y", "+z", "-z"):
        axes = GeomSkin(model, "pad", FINGER, face).surface.axes
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert axes[0]["xyz".index(face[1])] == (-1.0 if face[0] == "+" else 1.0)
    assert np.array_equal(GeomSkin(model, "pad", FINGER, "+z").surface.axes, FINGER_AXES)


def test_a_box_that_tips_lifts_off_as_press_says():
    model, data = settled("box inside", (1.3, 0.0, -3.0))
    felt = GeomSkin(model, "pad", FINGER, "+z").feel(data)
    middle = foot(data, 0.01)
    leans = centre(felt) - middle
    sides = np.abs(FINGER_AXES[1:, :2]) @ [5e-3, 4e-3]
    n = felt.force[0]
    solved = ss.press(
        FINGER.skin, ss.pressing.Box(*sides), force=n, moment=tuple(n * leans), nodes=512, max_strain=None
    )
    assert (solved.pressure <= 0).mean() > 0.05
    assert off(felt, moved(solved, middle)) < 0.02


def test_readings_are_those_of_the_points_by_the_closed_form():
    for name in ("ball", "box beyond", "egg", "bottle on its side"):
        felt = contact_to_skin(*settled(name, (0.3, 0.2, -2.0)), "pad", FINGER, "+z")
        exact = FINGER.read(ss.PointLoad(components=felt.forces, position=felt.points), sum_over=0)
        assert np.abs(felt.read() - exact).max() < 8e-3 * np.abs(exact).max()


def test_a_sensor_that_is_not_linear_reads_the_sum_of_the_fields():
    array = ss.SensorArray.grid((2, 2), 4e-3, depth=2.5e-3, transducer=ss.EnergyDensity())
    finger = ss.Finger(ss.HalfSpace(RUBBER), array)
    felt = contact_to_skin(*settled("ball"), "pad", finger, "+z")
    n = felt.force[0]
    truth = finger.read(ss.RoundHertz(force=n, position=centre(felt), half_width=hertz_radius(n, 0.02)))
    assert np.allclose(felt.read(), truth, rtol=0.02)


def test_a_round_tip_on_a_plate_presses_as_a_ball_does():
    model, data = scene('type="box" size=".03 .03 .005"', 0.0099, pad='type="sphere" size=".005"')
    felt = GeomSkin(model, "pad", FINGER, "+z").feel(pressed(model, data, 6, np.array([0, 0, -0.3, 0, 0, 0.0])))
    n = felt.force[0]
    assert n > 0.1
    assert off(felt, ss.RoundHertz(force=n, position=centre(felt), half_width=hertz_radius(n, 5e-3))) < 5e-3


def test_positions_on_what_is_round_are_arc_lengths():
    model, _ = scene('type="sphere" size=".004"', 0.02, pad='type="cylinder" size=".01 .02" euler="0 90 0"')
    skin = GeomSkin(model, "pad", FINGER, "+x")
    for angle, along in ((0.3, 5e-3), (-0.5, -2e-3)):
        out = skin.surface.axes.T @ np.array([-np.cos(angle), np.sin(angle), 0.0])
        point = 0.01 * out + along * skin.surface.axes[2]
        origin, axes, at = skin.surface.frame(point)
        assert np.allclose(origin, point)
        assert np.allclose(axes[0], -out)
        assert np.allclose(axes @ axes.T, np.eye(3))
        assert np.allclose(at, (0.01 * angle, along))


def test_a_mesh_has_the_footing_of_the_body_that_it_is():
    box = np.array(np.meshgrid([-0.005, 0.005], [-0.004, 0.004], [-0.01, 0.01])).reshape(3, -1).T
    directions = np.random.default_rng(0).normal(size=(3000, 3))
    egg = directions / np.linalg.norm(directions, axis=1, keepdims=True) * [0.02, 0.03, 0.015]
    rod = np.array(
        [(0.02 * np.cos(t), 0.02 * np.sin(t), z) for t in np.linspace(0, 2 * np.pi, 240) for z in (-0.03, 0.03)]
    )
    for name, vertices, tilt in (("box inside", box, 0), ("egg", egg, 20), ("bottle upright", rod, 0)):
        asset = f'<asset><mesh name="m" vertex="{" ".join(f"{v:.7f}" for v in vertices.ravel())}"/></asset>'
        known = {
            "box inside": THINGS["box inside"][0],
            "egg": THINGS["egg"][0],
            "bottle upright": 'type="cylinder" size=".02 .03"',
        }
        found = []
        for geom in ('type="mesh" mesh="m"', known[name]):
            model = mujoco.MjModel.from_xml_string(
                f'<mujoco>{asset}<worldbody><body euler="{tilt} 0 10"><geom {geom}/></body></worldbody></mujoco>'
            )
            data = mujoco.MjData(model)
            mujoco.mj_kinematics(model, data)
            found.append(
                footing_of(
                    model, 0, FINGER_AXES @ data.geom_xmat[0].reshape(3, 3), FINGER_AXES @ data.geom_xpos[0], 5e-4
                )
            )
        mesh, body = found
        assert np.allclose(mesh.curvature, body.curvature, rtol=0.03, atol=0.01 * np.abs(body.curvature).max())
        if name != "egg":
            assert np.allclose(extent(mesh.outline), extent(body.outline), rtol=0.01)


def extent(outline) -> tuple[float, ...]:
    """Area and sides of a polygon."""
    y, z = outline.T
    return abs(0.5 * (y * np.roll(z, -1) - z * np.roll(y, -1)).sum()), np.ptp(y), np.ptp(z)


def test_rollers_of_any_size_and_load_press_as_press_says():
    feet = PressedFeet(FINGER.skin, 2.5e-3)
    for radius, half_length, force, shift in (
        (30e-3, 7e-3, 1.0, 0.0),
        (30e-3, 7e-3, 1.09, 1e-3),
        (12e-3, 3e-3, 2.3, 0.0),
    ):
        at, share = feet.of(
            np.array([1 / radius, 0.0]), Outline(np.array([1.0, half_length])), force, np.array([0, shift])
        )
        moment = (0.0, force * shift) if shift else None
        body = ss.pressing.Roller(radius, half_length)
        solved = ss.press(FINGER.skin, body, force=force, moment=moment, nodes=256, max_strain=None)
        expected = FINGER.read(solved.contact)
        loads = ss.PointLoad(components=np.outer(force * share, [1.0, 0.0, 0.0]), position=at)
        assert np.abs(FINGER.read(loads, sum_over=0) - expected).max() < 0.015 * np.abs(expected).max()


@pytest.mark.parametrize(("curvature", "half", "power"), [((50.0, 50.0), 1.0, 1 / 3), ((50.0, 0.0), 7e-3, 1 / 2)])
def test_a_contact_between_presses_grows_as_hertz_says(curvature, half, power):
    feet, outline = PressedFeet(FINGER.skin, 2.5e-3), Outline(np.array([1.0, half]))
    wide = [feet.of(np.array(curvature), outline, force, np.zeros(2)) for force in np.geomspace(1.0, 1.3, 14)]
    alike = [(i, i + 1) for i in range(13) if np.array_equal(wide[i][1], wide[i + 1][1])]  # of one press
    assert len(alike) > 5
    for i, j in alike:
        one, two = (share @ at[:, 0] ** 2 for at, share in (wide[i], wide[j]))
        assert two / one == pytest.approx(1.3 ** (2 * power / 13), rel=1e-9)


def test_forces_on_what_is_round_have_their_moment_where_they_act():
    model, data = scene('type="box" size=".03 .03 .005"', 0.0099, 'euler="12 8 0"', pad='type="sphere" size=".005"')
    felt = GeomSkin(model, "pad", FINGER, "+z").feel(pressed(model, data, 6, np.array([0, 0, -0.3, 0, 0, 0.0])))
    (y, z), (n, along, across) = felt.points.T, felt.forces.T
    assert np.abs(n @ felt.points / n.sum()).min() > 1e-4
    assert np.allclose(felt.moment, [y @ across - z @ along, z @ n, -(y @ n)], rtol=0, atol=1e-11)


def test_balls_scale_with_load_and_radius_on_a_layer_too():
    layer = ss.Layered(ss.Layer(RUBBER, thickness=4e-3))
    feet, finger = PressedFeet(layer, 2.5e-3), ss.Finger(layer, ARRAY)
    for radius, force in ((20e-3, 1.0), (20e-3, 1.05), (8e-3, 0.4)):
        at, share = feet.of(np.full(2, 1 / radius), Outline(np.ones(2)), force, np.array([1e-3, 0.0]))
        solved = ss.press(layer, ss.pressing.Sphere(radius), force=force, nodes=128, max_strain=None)
        expected = finger.read(moved(solved, (1e-3, 0.0)))
        loads = ss.PointLoad(components=np.outer(force * share, [1.0, 0.0, 0.0]), position=at)
        assert np.abs(finger.read(loads, sum_over=0) - expected).max() < 0.005 * np.abs(expected).max()


def test_the_rim_of_a_cylinder_is_a_torus():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="cylinder" size=".02 .03"/></worldbody></mujoco>'
    )
    for tilt in (20, 45, 70):
        c, s = np.cos(np.deg2rad(tilt)), np.sin(np.deg2rad(tilt))
        axes = np.array([[0.0, s, c], [1.0, 0.0, 0.0], [0.0, c, -s]])  # its axis leans by so much from x
        found = footing_of(model, 0, axes, np.zeros(3), 1e-3)
        # a ring of radius R with a small radius r: the lowest points as it leans in both directions a little
        ring = 2 * np.pi / 4000 * np.arange(4000)
        tube = 2 * np.pi / 400 * np.arange(400)[:, None]
        x = (
            (0.02 + 1e-3 * np.cos(tube)) * np.cos(ring),
            (0.02 + 1e-3 * np.cos(tube)) * np.sin(ring),
            1e-3 * np.sin(tube),
        )
        height, y, z = np.tensordot(axes, np.stack(np.broadcast_arrays(*x)), 1).reshape(3, -1)
        near = height > height.max() - 2e-6
        y, z, gap = y[near], z[near], height.max() - height[near]
        y, z = y - y[np.argmin(gap)], z - z[np.argmin(gap)]
        terms = np.stack([y**2 / 2, y * z, z**2 / 2], axis=-1)
        fitted = np.linalg.lstsq(terms, gap, rcond=None)[0]
        # the tube adds its radius to that of the ring
        assert np.allclose(np.diag(found.curvature), fitted[[0, 2]], rtol=0.08)


def test_footings_that_no_press_reaches_still_carry_their_load():
    feet, rng = PressedFeet(FINGER.skin, 2.5e-3), np.random.default_rng(0)
    for i in range(60):
        half = 10 ** rng.uniform(-5, -2, 2)
        curvature = 10 ** rng.uniform(0, 3.5, 2) * (rng.random(2) < (0.5, 0.8))
        centre, force = half * rng.normal(0, 3, 2), 10 ** rng.uniform(-3, 1.5)
        corners = half * np.array([(-1.0, -0.2), (0.3, -1.0), (1.0, 0.5), (-0.5, 1.0)]) if i % 2 else None
        at, share = feet.of(curvature, Outline(np.maximum(half, 0.05 * half.max()), corners), force, centre)
        assert np.isfinite(at).all()
        assert share.sum() == pytest.approx(1.0)
        assert np.allclose(share @ at, centre, rtol=0, atol=1e-15)


def test_contacts_beside_the_face_are_told_apart():
    model, data = scene('type="sphere" size=".01"', 0.003)
    data.qpos[0] = 0.0199
    data.xfrc_applied[1, 0] = -3.0
    mujoco.mj_step(model, data, 3)
    felt = GeomSkin(model, "pad", FINGER, "+z").feel(data)
    assert not felt.touches
    assert np.linalg.norm(felt.beside) > 0.1
    assert np.array_equal(felt.read(), FINGER.array.digitise(np.zeros(16)))


def test_what_cannot_be_is_refused_with_what_may():
    model, _ = scene(*THINGS["ball"])
    with pytest.raises(ss.SubskinError, match=r"geom 'pat'.*'pad', 'thing'"):
        GeomSkin(model, "pat", FINGER, "+z")
    with pytest.raises(ss.SubskinError, match="face"):
        GeomSkin(model, "pad", FINGER, "up")
    row = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(4, 2e-3, 2e-3))
    with pytest.raises(ss.SubskinError, match="solved in a plane"):
        GeomSkin(model, "pad", row, "+z")
    wide, _ = scene('type="sphere" size=".02"', 1.0, pad='type="box" size="1 1 .005"')
    with pytest.raises(ss.SubskinError, match="2000 x 2000 mm"):
        GeomSkin(wide, "pad", FINGER, "+z")
    egg, _ = scene('type="sphere" size=".02"', 1.0, pad='type="ellipsoid" size=".01 .01 .005"')
    with pytest.raises(ss.SubskinError, match="type ellipsoid"):
        GeomSkin(egg, "pad", FINGER, "+z")
