"""What the tests are tried on: every skin, every contact and every transducer, in one table of each.

A new skin is one line here, and every law of tests/verification/test_contract.py is then tried on it. So is a contact
or a transducer; one that the library finds by its name is here by itself. A contact is built by its `side` (-1 mirrors
it in y = 0), its half width `a` [m] and the size of its force `p` [N/m], which may be a batch.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import subskin as ss
from subskin.contact import contact_of, families
from subskin.transducer import Displacement, MagnetDisplacement, kinds

A = 1.25e-3  # half width [m], the length scale of all that is built here
FORCE = 40.0
MU = 0.6
SOFT, FIRM, PLAIN = ss.Material(0.4e6, 0.5), ss.Material(3e6, 0.3), ss.Material(0.4e6, 0.3)

SKINS: dict[str, ss.Skin] = {
    "half plane-0.5": ss.HalfPlane(SOFT),
    "half plane-0.3": ss.HalfPlane(PLAIN),
    "half plane-0.0": ss.HalfPlane(ss.Material(0.4e6, 0.0)),
    "slice-0.5": ss.HalfPlane(SOFT, plane="stress"),
    "slice-0.3": ss.HalfPlane(PLAIN, plane="stress"),
    "layer-0.5": ss.Layered(ss.Layer(SOFT, 4 * A)),
    "layer-0.3": ss.Layered(ss.Layer(PLAIN, 4 * A)),
    "loose layer": ss.Layered(ss.Layer(SOFT, 4 * A, bond="frictionless")),
    "epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A), ss.Layer(SOFT, 3 * A)]),
    "sliding epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A, bond="frictionless"), ss.Layer(SOFT, 3 * A)]),
    "on a half plane": ss.Layered(
        [ss.Layer(FIRM, 0.4 * A), ss.Layer(SOFT, 2 * A), ss.Layer(ss.Material(1e6, 0.45), A)], base=FIRM
    ),
    "round-0.5": ss.Round(SOFT, 8 * A, 4 * A),
    "round-0.3": ss.Round(PLAIN, 8 * A, 1.5 * A),
    "thin round": ss.Round(SOFT, 8 * A, 7 * A),
    "round layers": ss.Round(
        SOFT, 8 * A, 4 * A, layers=ss.Layer(FIRM, A, bond="frictionless"), core=ss.Material(1e6, 0.45)
    ),
    "half space": ss.HalfSpace(PLAIN),
}


def _profile(side: int, a: float, p: np.ndarray | float) -> ss.PressureProfile:
    nodes, pressure, shear = np.array([[-1.0, -0.4, 0.1, 1.0], [2.0, 9.0, 4.0, 0.0], [0.0, 1.0, -4.0, 0.0]])
    size = np.expand_dims(0.25 * np.asarray(p) / a, -1)
    return ss.PressureProfile(a * side * nodes[::side], size * pressure[::side], size * side * shear[::side])


def _family(name: str) -> Callable[..., ss.Contact]:
    def build(side: int = 1, a: float = A, p: np.ndarray | float = FORCE) -> ss.Contact:
        return contact_of(name, None if name == "line" else a)(p, 0.4 * side, 0.2e-3 * side)

    return build


CONTACTS: dict[str, Callable[..., ss.Contact]] = {
    **{name: _family(name) for name in families()},  # those that are found by name, a new one too
    "slip": lambda side=1, a=A, p=FORCE: ss.PartialSlip(p, 0.4 * side, 0.2e-3 * side, half_width=a, friction=MU),
    "almost sticks": lambda side=1, a=A, p=FORCE: ss.PartialSlip(
        p, 1e-6 * side, 0.2e-3 * side, half_width=a, friction=MU
    ),
    "pull": lambda side=1, a=A, p=FORCE: ss.Hertz(p, 2.6 * side, 0.0, half_width=a),
    "tilted": lambda side=1, a=A, p=FORCE: ss.FlatPunch(
        p, -0.3 * side, 0.2e-3 * side, half_width=a, moment=0.2 * side * a * p
    ),
    "profile": lambda side=1, a=A, p=FORCE: _profile(side, a, p),
    "sum": lambda side=1, a=A, p=FORCE: (
        ss.Strip(p, 0.3 * side, -a * side, half_width=a)
        + ss.Hertz(0.25 * np.asarray(p), -0.5 * side, a * side, half_width=0.5 * a)
    ),
}

LOAD = np.array([1.0, 0.375, -0.25])  # N
MIRROR = np.array([1.0, 1.0, -1.0])


def _turned(components: np.ndarray, turn: float) -> np.ndarray:
    """(N, Ty, Tz) after a turn about the inward normal [rad], from +y to +z."""
    drag = (components[1] + 1j * components[2]) * np.exp(1j * turn)
    return np.array([components[0], drag.real, drag.imag])


def _local(kind: Callable[..., ss.LocalContact], **lengths: float) -> Callable[..., ss.LocalContact]:
    """A round contact beside the origin: `side` -1 mirrors it in z = 0, `turn` turns it about the origin [rad]."""

    def build(side: int = 1, turn: float = 0.0, a: float = A, p: float = 1.0) -> ss.LocalContact:
        at = 0.3 * a * (1 - 0.5j * side) * np.exp(1j * turn)
        sizes = {name: a * value for name, value in lengths.items() if name != "moment"}
        moment = side * p * a * lengths.get("moment", 0.0)
        components = p * _turned(LOAD * MIRROR if side < 0 else LOAD, turn)
        return kind(components=components, position=(at.real, at.imag), moment=moment, **sizes)

    return build


def _ellipse(side: int = 1, turn: float = 0.0, a: float = A, p: float = 1.0) -> ss.EllipticHertz:
    components = p * _turned(LOAD * MIRROR if side < 0 else LOAD, turn)
    return ss.EllipticHertz(
        components=components, half_widths=(a, 0.4 * a), turn=0.5 * side + turn, moment=0.1 * side * a * p
    )


def _patch(side: int = 1, a: float = A, p: float = 1.0) -> ss.Patch:
    slopes = np.array([0.3, -0.2 * side, 0.4 * side / a]) / a
    components = p * LOAD * MIRROR if side < 0 else p * LOAD
    return ss.Patch(components=components, position=(0.2 * a, -0.1 * a * side), half_widths=(a, 0.6 * a), slopes=slopes)


def _grid(side: int = 1, a: float = A, p: float = 1.0) -> ss.PressureGrid:
    y, z = a * np.array([-1.0, -0.2, 0.3, 1.1]), a * np.array([-0.9, 0.1, 0.8])
    pressure = p / a**2 * np.array([[0.0, 0.0, 0.0], [0.2, 0.9, 0.1], [0.4, 0.5, 0.3], [0.0, 0.1, 0.0]])
    shear = np.stack([0.3 * pressure[::-1], side * (0.1 * pressure - 0.2 * pressure[:, ::-1])], axis=-1)
    if side < 0:
        z, pressure, shear = -z[::-1], pressure[:, ::-1], shear[:, ::-1]
    return ss.PressureGrid(y, z, pressure, shear)


LOCAL: dict[str, Callable[..., ss.LocalContact]] = {
    "point": _local(ss.PointLoad),
    "point torque": _local(ss.PointLoad, moment=0.3),
    "round hertz": _local(ss.RoundHertz, half_width=1.0),
    "slip": _local(ss.RoundHertz, half_width=1.0, stick=0.6),
    "almost sticks": _local(ss.RoundHertz, half_width=1.0, stick=1 - 1e-6),
    "twisted": _local(ss.RoundHertz, half_width=1.0, moment=0.3),
    "round punch": _local(ss.RoundPunch, half_width=1.0),
    "cone": _local(ss.Cone, half_width=1.0, moment=0.1),
    "ellipse": _ellipse,
    "patch": _patch,
    "grid": _grid,
    "projections": _local(
        lambda half_width, **more: ss.FromProjections(ss.Strip(1.0, half_width=half_width), **more), half_width=1.0
    ),
    "local sum": lambda side=1, turn=0.0, a=A, p=1.0: (
        LOCAL["cone"](side, turn, a, p) + LOCAL["point"](side, turn, 0.5 * a, 0.3 * p)
    ),
}
"""Local contacts: a new one is one line here, and every law of tests/verification/test_local_contacts.py meets it."""

_MOVED = {"displacement", "magnet_displacement"}  # they need a skin that knows its displacement

TRANSDUCERS: dict[str, ss.Transducer] = {
    # those that are found by name, a new one too
    **{name: kind() for name, kind in kinds().items() if name not in _MOVED},
    "exact resistance": ss.VolumeResistance(exact=True),
    "slanting gauge": ss.LateralStrain(0.7),
}

LOCAL_TRANSDUCERS: dict[str, ss.Transducer] = {
    **TRANSDUCERS,
    **{f"shear {plane}": ss.ShearStrain(plane) for plane in ("xz", "yz")},
    **{f"displacement {axis}": Displacement(axis) for axis in "xyz"},
    **{f"magnet {axis}": MagnetDisplacement(axis, moment=5e-3, gap=4e-3) for axis in "xyz"},
    **{f"whole magnet {axis}": MagnetDisplacement(axis, moment=5e-3, gap=4e-3, exact=True) for axis in "xyz"},
}
"""Under local contacts: a new one is one line here, and meets the laws of tests/verification/test_local_sensors.py."""
