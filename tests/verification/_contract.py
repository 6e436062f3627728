"""Points, differences and integrals by which any skin is tried under any contact; nothing here knows a closed form."""

from __future__ import annotations

from functools import cache
from itertools import cycle, pairwise
from typing import NamedTuple

import numpy as np

import subskin as ss

from .._tables import CONTACTS, SKINS, A

FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEPS = np.arange(-4, 5)
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(16)

PAIRS = [
    (skin, contact)
    for i, skin in enumerate(SKINS)
    for j, contact in enumerate(CONTACTS)
    if (i + j) % 3 == 0  # each contact meets every third skin: of half planes, of layers and of round fingers
]
ONCE = list(zip(SKINS, cycle(CONTACTS)))  # each at least once, where a law is not about skins and contacts


def interfaces(skin):
    """Depths between which the field is smooth: the surface, where the material changes, and a rigid base."""
    depths = np.array([0.0, *skin.interfaces, skin.thickness])
    return depths[np.isfinite(depths)]


def bonds(skin):
    """How a skin holds together at each of its interfaces beneath the surface."""
    stack = getattr(skin, "stack", None)
    return [layer.bond for layer in stack] if stack else ["bonded"] * (interfaces(skin).size - 1)


def slides(skin):
    """Depth of the first interface that does not hold a drag; 0 where all do."""
    loose = [depth for depth, bond in zip(interfaces(skin)[1:], bonds(skin)) if bond == "frictionless"]
    return loose[0] if loose else 0.0


def points(skin, each=3):
    """Points in the middle of each layer, and how far the next interface is; below the last one if there is no base."""
    rng = np.random.default_rng(1)
    ends = interfaces(skin)
    bounds = ends if np.isfinite(skin.thickness) else np.append(ends, ends[-1] + 4 * A)
    x = np.concatenate([a + (b - a) * rng.uniform(0.15, 0.85, each) for a, b in pairwise(bounds)])
    return x, A * rng.uniform(-3.0, 3.0, x.size), np.abs(x[:, None] - ends).min(axis=1)


class Field(NamedTuple):
    """A state on 9 x 9 points about each of some points, and how to differentiate there."""

    state: ss.tensor.State
    x: np.ndarray
    room: np.ndarray
    bend: np.ndarray  # 1/r at each point
    arc: np.ndarray  # metres along the arc through the point, a metre of y

    def by_x(self, f, weights=FIRST, order=1):
        return np.einsum("i,i...->...", weights, f[:, 4]) / self._step**order

    def by_s(self, f, weights=FIRST, order=1):
        return np.einsum("i,i...->...", weights, f[4]) / (self._step * self.arc) ** order

    def by_xs(self, f):
        return np.einsum("i,j,ij...->...", FIRST, FIRST, f) / (self._step**2 * self.arc)

    @property
    def _step(self):
        return self.room / 32

    def scale(self, tensor):
        """Largest component at each point, and a little of the largest anywhere."""
        at = np.max([np.abs(c[4, 4]) for c in (tensor.xx, tensor.yy, tensor.xy)], axis=0)
        return at + 1e-3 * at.max()


@cache
def field(skin_name, contact_name):
    skin = SKINS[skin_name]
    x, y, room = points(skin, each=6)
    h = room / 32
    state = skin.state(CONTACTS[contact_name](), x + h * STEPS[:, None, None], y + h * STEPS[:, None])
    r = 1 - skin.curvature * x
    return Field(state, x, room, skin.curvature / r, r)


def panels(edges):
    """Gauss nodes and weights on the stretches between `edges`."""
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * GAUSS).ravel(), (half * WEIGHTS).ravel()


class Cut(NamedTuple):
    """Tractions on a piece of a cut through a skin: where, how long, and their components along x and along y there."""

    x: np.ndarray
    y: np.ndarray
    size: np.ndarray
    down: np.ndarray
    along: np.ndarray


def box(skin, contact, depth, reach):
    """The cuts that free what lies above `depth` and within `reach` of y = 0: beneath it, and at its two sides."""
    y, dy = panels(np.linspace(-reach, reach, 2 + int(2 * reach / min(1.5 * depth, A))))
    s = skin.stress(contact, depth, y)
    cuts = [Cut(np.full_like(y, depth), y, (1 - skin.curvature * depth) * dy, s.xx, s.xy)]
    ends = interfaces(skin)
    x, dx = panels(np.append(ends[ends < depth], depth))
    for side in (-1, 1):
        s = skin.stress(contact, x, side * reach)
        cuts.append(Cut(x, np.full_like(x, side * reach), dx, side * s.xy, side * s.yy))
    return Cut(*(np.concatenate(parts) for parts in zip(*cuts, strict=True)))


def resultants(skin, cut):
    """Force on a cut along the inward normal at y = 0, along +y there, and its moment.

    The moment is about the surface at y = 0 in a flat skin and about the centre of a round one.
    """
    bend = skin.curvature
    c, s = np.cos(bend * cut.y), np.sin(bend * cut.y)
    force = (cut.down * c + cut.along * s) @ cut.size, (cut.along * c - cut.down * s) @ cut.size
    arms = cut.x * cut.along - cut.y * cut.down if bend == 0 else (cut.x - 1 / bend) * cut.along
    return np.array([*force, arms @ cut.size])


def load(skin, contact):
    """What `resultants` has to be for the tractions on the surface, from the contact's spectrum."""
    bend = skin.curvature
    p, q = contact.spectrum(np.array(bend))
    if bend > 0:
        moment = -contact.tangential_force / bend
    else:  # the first moment of the pressure is the slope of its spectrum at k = 0, to the fourth power of k
        slopes = [contact.spectrum(np.array(k)).p.imag / k for k in (0.01 / A, 0.02 / A)]
        moment = (4 * slopes[0] - slopes[1]) / 3
    return np.array([p.real - q.imag, q.real + p.imag, moment])


def traction(contact, weight):
    """Integrals over the contact of pressure and shear times weight(y).

    Between its kinks by Gauss's rule, in an angle that takes the roots at the ends in its stride and a variable that is
    flat at every kink.
    """
    low, high = (float(end) for end in contact.support)
    centre, r = 0.5 * (low + high), 0.5 * (high - low)
    stick = float(getattr(contact, "stick_half_width", 0.0)) / r
    kinks = (np.asarray(getattr(contact, "nodes", [low, centre, high])) - centre) / r
    kinks = np.unique(np.clip([*kinks, -stick, stick], -1.0, 1.0))
    t, w = np.polynomial.legendre.leggauss(200)
    u = 0.5 * (1 + t)
    share = u**5 * (126 - 420 * u + 540 * u**2 - 315 * u**3 + 70 * u**4)
    slope = 0.5 * w * 630 * u**4 * (1 - u) ** 4
    total = np.zeros(2, dtype=complex)
    for a, b in pairwise(np.arcsin(kinks)):
        theta = a + (b - a) * share
        y = centre + r * np.sin(theta)
        inside = (y > low) & (y < high)
        size = (weight(y) * slope * (b - a) * r * np.cos(theta))[inside]
        total += [(contact.pressure(y[inside]) * size).sum(), (contact.shear(y[inside]) * size).sum()]
    return total


def is_even(contact):
    """Whether pressure and shear are the same on either side of the contact's middle."""
    low, high = contact.support
    t = (high - low) * np.array([0.07, 0.23, 0.31, 0.44])
    middle = 0.5 * (low + high)
    return all(np.allclose(f(middle + t), f(middle - t)) for f in (contact.pressure, contact.shear))


def components(state):
    """Stress and strain, shape (8, ...)."""
    return np.array([getattr(t, c) for t in (state.stress, state.strain) for c in ("xx", "yy", "zz", "xy")])


def largest(tensor):
    return np.max([np.abs(tensor.xx), np.abs(tensor.yy), np.abs(tensor.xy)], axis=0)


def slope(h, error):
    """Power of h with which the error falls."""
    return np.polyfit(np.log(h), np.log(error), 1)[0]
