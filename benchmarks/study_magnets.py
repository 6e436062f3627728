"""Three-axis magnetometers beneath magnets in the skin: positions and forces of touches on a point, by `locate`.

    python benchmarks/study_magnets.py [--touches 2000] [--json FILE]

Magnets 2 mm deep, 3 mm apart, 3 mm above their magnetometers, on a half space and on a layer of 6 mm; touches of 1 N
over the array, within 40 degrees of the normal. Noise is in shares of what the most of the field changes beneath 1 N.
The rms error of each unknown is over the Cramer-Rao bound of its own touch, here the largest of the five; 95 %
intervals of all five; gross is a position off by more than the depth. In the last rows the magnets tilt with the skin
and `locate` takes them to stay upright.
"""

from __future__ import annotations

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.estimate import Status
from subskin.transducer import MagnetDisplacement

PITCH, DEPTH, GAP = 3e-3, 2e-3, 3e-3


def finger(skin: ss.Skin, side: int, tilts: bool, share: float) -> ss.Finger:
    """`side` x `side` magnets."""
    kinds = [MagnetDisplacement(axis, moment=7.9e-3, gap=GAP, tilts=tilts) for axis in "xyz"]
    array = ss.SensorArray.grid((side, side), pitch=PITCH, depth=DEPTH, channels=kinds)
    most = np.abs(ss.Finger(skin, array).receptive_field((0.0, 0.0), "point")[:, 0]).max()
    return ss.Finger(
        skin, ss.SensorArray.grid((side, side), pitch=PITCH, depth=DEPTH, channels=kinds, noise=share * most)
    )


def row(skin: ss.Skin, side: int, tilts: bool, share: float, count: int, upright: bool = False) -> list[str]:
    """What `locate` makes of `count` touches."""
    rng = np.random.default_rng(0)
    tip = finger(skin, side, tilts, share)
    at = rng.uniform(-0.5, 0.5, (count, 2)) * (side - 1) * PITCH
    angle, azimuth = rng.uniform(0, np.deg2rad(40), count), rng.uniform(-np.pi, np.pi, count)
    touch = ss.PointLoad(force=np.ones(count), angle=angle, azimuth=azimuth, position=at)
    found = (finger(skin, side, False, share) if upright else tip).locate(tip.read(touch, rng=rng))
    off = np.concatenate([found.position - at, found.load.components - touch.components], axis=1)
    h, field = 1e-6, tip.receptive_field
    moves = [
        (field(at + e, "point") - field(at - e, "point")) @ touch.components[..., None] / (2 * h) for e in h * np.eye(2)
    ]
    jacobian = np.concatenate([*moves, field(at, "point")], axis=-1) / np.asarray(tip.array.noise)[:, None]
    bound = np.sqrt(np.linalg.inv(np.swapaxes(jacobian, 1, 2) @ jacobian).diagonal(axis1=1, axis2=2))
    said = np.sqrt(found.load.covariance.diagonal(axis1=1, axis2=2))
    gross, ok = np.hypot(off[:, 0], off[:, 1]) > DEPTH, found.status == Status.OK
    rms = np.sqrt(np.nanmean((off / bound)[~gross] ** 2, axis=0)).max()
    held = 100 * (np.abs(off) < 1.96 * said)[~gross].mean(axis=0)
    wrong = (np.hypot(off[:, 0], off[:, 1]) > 3 * np.hypot(said[:, 0], said[:, 1])) & ok
    numbers = [f"{rms:.3g}", f"{held.min():.1f} to {held.max():.1f}", f"{100 * gross.mean():.2g}"]
    millimetres = 1e3 * np.sqrt(np.nanmean((off[:, :2] ** 2).sum(axis=1)))
    return [f"{millimetres:.2g}", *numbers, f"{100 * ok.mean():.0f}", f"{100 * wrong.mean():.2g}"]


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, touches=2000)
    soft, rows = ss.Material(young=0.4e6), []
    skins = {"half space": ss.HalfSpace(soft), "layer": ss.Layered(ss.Layer(soft, 6e-3))}
    for where, skin in skins.items():
        for tilts in (False, True):
            for side in (2, 3, 4):
                for share in (1e-3, 1e-2):
                    name = f"{where}, {side} x {side}, {'tilting' if tilts else 'upright'}, {100 * share:g} %"
                    rows.append([name, *row(skin, side, tilts, share, options.touches)])
        for share in (1e-3, 1e-2):
            name = f"{where}, 3 x 3, tilting, taken as upright, {100 * share:g} %"
            rows.append([name, *row(skin, 3, True, share, options.touches, upright=True)])
    columns = ["", "rms of position, mm", "rms over bound", "95 % hold, %", "gross, %", "OK, %", "OK and wrong, %"]
    show("Touches located by magnets", columns, rows, options.json)


if __name__ == "__main__":
    main()
