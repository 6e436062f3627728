"""A map of the state beneath a local contact: what a skin makes of a point load, folded with the contact's spectrum.

Both repeat where they are sums of waves, and what a point load makes has no end. It is therefore multiplied by a window
that is 1 wherever a point of the map sees the contact and falls to 0 beyond, before its waves are taken: then nothing
of it comes back from the next period, and the map is that of the endless skin (Vico, Greengard and Ferrando, 2016, cut
it off sharply). At a depth x waves fall at least as exp(-k x): those shorter than a fifteenth of x are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..contact import LocalContact, PointLoad
from ..errors import GeometryError
from ..tensor import Deferred, Displacements, State, Strain, Stress, Tilt

__all__ = ["state_map"]

_FINEST = np.pi / 30
"""Most distance of the samples, in depths: exp(-30) is left out."""
_FALL = 4.0
"""Length over which the window falls, in depths."""
_STEEP = 5.0
"""The window is erfc between -5 and 5."""
_MOST = 1 << 23
"""Most samples of a component."""

Field = Callable[[State], tuple[FloatArray, ...]]


class _Axis(NamedTuple):
    """One axis: points of the map, distances at which a point load is sampled, window, waves and their phases."""

    taken: slice
    distances: FloatArray
    window: FloatArray
    k: FloatArray
    phase: ComplexArray


def state_map(
    skin: Callable[..., State], contact: LocalContact, depth: float, y: npt.ArrayLike, z: npt.ArrayLike
) -> State:
    """The state at one depth on a grid of points, shape (..., n, k); see `Skin.map`.

    Parameters
    ----------
    skin : callable
        `Skin.state` of a skin that takes local contacts.
    contact : LocalContact
        What presses; a batch of any shape.
    depth : float
        Depth [m], > 0.
    y, z : array_like, shape (n,), (k,)
        Points along y and along z [m], evenly apart.
    """
    x = _check.scalar("x", depth, unit="m", above=0.0, fix="skin.state(contact, x, y, z) for points of the surface")
    low, high = (np.asarray(end).reshape(-1, 2) for end in contact.support)
    ends = [(low[:, i].min(), high[:, i].max()) for i in (0, 1)] if low.size else [(0.0, 0.0)] * 2
    along, across = (
        _axis(name, at, x, *end, real) for name, at, end, real in zip("yz", (y, z), ends, (False, True), strict=True)
    )
    samples = along.distances.size * across.distances.size * max(int(np.prod(contact.shape)), 1)
    if samples > _MOST:
        seen = f"a map that takes {samples:.3g} samples at the depth {x:.3g} m"
        rule = f"at most {_MOST:.3g} are handled, ten a depth along y and z"
        raise GeometryError(seen, rule, "a smaller map, fewer contacts at once, or skin.state for so shallow points")
    spectrum = contact.expand(2).spectrum(along.k[:, None], across.k)
    loads = [(np.eye(3)[i], part) for i, part in enumerate(spectrum) if part.any()] or [(np.eye(3)[0], spectrum.p)]
    states = [skin(PointLoad(components=unit), x, along.distances[:, None], across.distances) for unit, _ in loads]
    window, phase = along.window[:, None] * across.window, along.phase[:, None] * across.phase
    parts = [part * phase for _, part in loads]

    def mapped(field: Field) -> list[FloatArray]:
        from scipy.fft import irfft2, rfft2

        shape = (along.distances.size, across.distances.size)
        out = []
        for each in zip(*(field(state) for state in states), strict=True):
            waves = np.sum([rfft2(one * window) * part for one, part in zip(each, parts, strict=True)], axis=0)
            out.append(_check.read_only(irfft2(waves, s=shape)[..., along.taken, across.taken].copy()))
        return out

    def moved() -> Displacements | None:
        known = all(state.displacement is not None for state in states)
        return Displacements(*mapped(_moved)) if known else None

    def tilt() -> Tilt | None:
        return Tilt(*mapped(_tilted)) if all(state.tilt is not None for state in states) else None

    return Deferred(lambda: Stress(*mapped(_stress)), lambda: Strain(*mapped(_strain)), moved, tilt)


def _components(tensor: Stress | Strain) -> tuple[FloatArray, ...]:
    return tensor.xx, tensor.yy, tensor.zz, tensor.xy, tensor.xz, tensor.yz


def _stress(state: State) -> tuple[FloatArray, ...]:
    return _components(state.stress)


def _strain(state: State) -> tuple[FloatArray, ...]:
    return _components(state.strain)


def _moved(state: State) -> tuple[FloatArray, ...]:
    moved = state.moved("")
    return moved.x, moved.y, moved.z


def _tilted(state: State) -> tuple[FloatArray, ...]:
    leans = state.tilted("")
    return leans.y, leans.z


def _axis(name: str, at: npt.ArrayLike, x: float, low: float, high: float, real: bool) -> _Axis:
    """The axis of a map's points `at`, of a contact from `low` to `high`; `real` keeps waves k >= 0 alone."""
    from scipy.fft import next_fast_len
    from scipy.special import erfc

    points = _check.real(name, at, unit="m")
    fix = "np.linspace(first, last, count), or skin.state at any points"
    if points.ndim != 1 or not points.size:
        raise GeometryError(f"{name} of shape {points.shape}", "a map has a row of points", fix)
    steps = np.diff(points)
    if steps.size and not (steps[0] > 0 and np.allclose(steps, steps[0], rtol=1e-6, atol=0.0)):
        seen = f"steps of {name} from {steps.min():.6g} to {steps.max():.6g} m"
        raise GeometryError(seen, "a map has points that ascend evenly", fix)
    step = (points[-1] - points[0]) / steps.size if steps.size else _FINEST * x
    fall, nearest, farthest = _FALL * x, points[0] - high, points[-1] - low
    if not (farthest - nearest + 2 * fall) * max(1 / (_FINEST * x), 1 / step) < _MOST:
        seen = f"a map over {farthest - nearest:.3g} m of {name} at the depth {x:.3g} m, in steps of {step:.3g} m"
        rule = f"at most {_MOST:.3g} samples are handled, ten a depth"
        raise GeometryError(seen, rule, "a smaller map, or skin.state for so shallow points")
    finer = int(np.ceil(step / (_FINEST * x)))
    pitch = step / finer
    count = next_fast_len(int(np.ceil((farthest - nearest + 2 * fall) / pitch)) + 1, True)
    distances = nearest - fall + pitch * np.arange(count)
    beyond = np.maximum(np.maximum(nearest - distances, distances - farthest), 0.0) / fall
    window = np.where(beyond <= 1, 0.5 * erfc(_STEEP * (2 * beyond - 1)), 0.0)
    k = 2 * np.pi * (np.fft.rfftfreq if real else np.fft.fftfreq)(count, pitch)
    phase = np.exp(1j * k * (points[0] - distances[0]))
    return _Axis(slice(0, steps.size * finer + 1, finer), distances, window, k, phase)
