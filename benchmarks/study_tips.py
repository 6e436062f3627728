"""How wrong a flat layer is on a round tip: on a cylinder under long contacts, and on a ball under touches.

    python benchmarks/study_tips.py [--parts 2] [--json FILE] [--write 1]

A layer of an incompressible rubber on a rigid core, of thickness 1. The cylinder's field is that of `Round`. The
ball's is that of finite elements in Fourier modes m = 0 and 1 about the touch (tests/verification/_fem_round.py),
less the same elements' on a flat layer, plus the flat layer's closed field: so most of the elements' error cancels.
The readings are located with the flat layer. With `--write 1` the errors go to src/subskin/design/tips.json, where
`subskin check` finds them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import subskin as ss
from _common import arguments, show

sys.path.append(str(Path(__file__).resolve().parents[1]))
from tests.verification._fem import along, split
from tests.verification._fem_round import RoundBody, RoundSolution

TABLE = Path(ss.__file__).parent / "design" / "tips.json"
RADII = (2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
DEPTHS = (0.2, 0.4, 0.6, 0.8)
KINDS: dict[str, ss.Transducer] = {"normal_strain": ss.NormalStrain(), "mean_pressure": ss.MeanPressure()}
QUANTITIES = ("reading", "position", "force", "angle")
MATERIAL = ss.Material(1.0, 0.5)
FLAT = ss.Layered(ss.Layer(MATERIAL, 1.0))
A = 0.1
"""Radius of the touch on the elements: of their difference only."""
ANGLES = (0.0, 0.4)


def hertz(r: np.ndarray) -> np.ndarray:
    """Hertz's pressure of unit force."""
    return 3 / (2 * np.pi * A**2) * np.sqrt(np.maximum(1 - (r / A) ** 2, 0.0))


def elements(radius: float, parts: int) -> list[RoundSolution]:
    """The fields of a unit pressure and of a unit drag."""
    depths = split(np.linspace(0, 1, 21), parts)
    radii = split(along(0, A, 3, 0, min(12.0, 0.9 * np.pi * radius), 1.25), parts)
    bodies = [RoundBody(depths, radii, [(1.0, 1.0, 0.5)], m, radius) for m in (0, 1)]
    return [bodies[0].pull(pressure=hertz), bodies[1].pull(drag=hertz)]


def errors(true: np.ndarray, flat: np.ndarray, found: ss.Estimate, position: np.ndarray, depth: float) -> list[float]:
    """Largest difference of a reading, and the worst position [depths], force and angle [rad] that were found."""
    off = np.abs(true - flat).max(axis=0) / np.abs(true).max(axis=0)
    away = (found.position - position[..., 0]) if found.position.ndim == position.ndim - 1 else None
    distance = np.abs(away) if away is not None else np.hypot(*np.moveaxis(found.position - position, -1, 0))
    angle = np.abs(found.angle) - np.array([abs(a) for a in ANGLES])
    return [float(off.max()), *(float(np.nanmax(np.abs(v))) for v in (distance / depth, found.force - 1, angle))]


def noisy(array: ss.SensorArray, readings: np.ndarray) -> ss.SensorArray:
    """The array with a noise of 5 % of the largest reading: a wrong skin then still explains the readings."""
    from dataclasses import replace

    return replace(array, noise=0.05 * np.abs(readings).max())


def on_cylinder(radius: float, depth: float, kind: ss.Transducer) -> list[float]:
    """A row of six sensors one depth apart under line loads."""
    array = ss.SensorArray.line(6, pitch=depth, depth=depth, transducer=kind)
    true, flat = (ss.Finger(skin, array) for skin in (ss.Round(MATERIAL, radius, radius - 1), FLAT))
    y = np.linspace(-2.5, 2.5, 41) * depth
    readings = true.read(ss.LineLoad(1.0, np.array(ANGLES), y[:, None]))
    fields = [f.receptive_field(y).reshape(-1, 2) for f in (true, flat)]
    found = ss.Finger(FLAT, noisy(array, readings)).locate(readings)
    return errors(*fields, found, y[:, None, None], depth)


def on_ball(
    radius: float, depth: float, name: str, ball: list[RoundSolution], plain: list[RoundSolution]
) -> list[float]:
    """Four by four sensors one depth apart under touches, both laid out by distance from the middle and direction."""
    kind, s = KINDS[name], np.linspace(2e-3, min(6.0, 0.85 * np.pi * radius), 400)
    sensor = ss.Finger(FLAT, ss.SensorArray.grid((1, 1), pitch=1.0, depth=depth, transducer=kind))
    field = sensor.receptive_field(np.stack([-s, 0 * s], axis=-1), "point")[:, 0]  # the sensor lies at +y of the touch
    which = list(KINDS).index(name)
    x = np.full_like(s, depth)
    more = [a.normal(x, s)[which] - b.normal(x, s)[which] for a, b in zip(ball, plain, strict=True)]
    flat = field[:, :2]
    true = flat + np.stack(more, axis=-1)
    press, drag = (CubicSpline(s, true[:, i]) for i in (0, 1))
    array = ss.SensorArray.grid((4, 4), pitch=depth, depth=depth, transducer=kind)
    line = np.linspace(-1.5, 1.5, 7) * depth
    position = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    here, frame = on_sphere(position, radius)
    there = on_sphere(np.asarray(array.points), radius)[0]
    cosine = np.clip(here @ there.T, -1, 1)
    apart = np.arccos(cosine)
    towards = (there - cosine[..., None] * here[:, None]) / np.maximum(np.sin(apart), 1e-12)[..., None]
    readings = np.empty((len(position), len(ANGLES), 16))
    azimuth = 2 * np.pi * np.arange(len(position)) / 5.0
    for j, angle in enumerate(ANGLES):
        pull = np.cos(azimuth)[:, None] * frame[:, 0] + np.sin(azimuth)[:, None] * frame[:, 1]
        along_it = (towards * pull[:, None]).sum(axis=-1)
        far = radius * np.maximum(apart, s[0] / radius)
        readings[:, j] = np.cos(angle) * press(far) + np.sin(angle) * along_it * drag(far)
    found = ss.Finger(FLAT, noisy(array, readings)).locate(readings)
    return errors(true, flat, found, position[:, None], depth)


def on_sphere(position: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors to points at their distances from the middle and directions, and the axes y and z there, turned
    as they are carried out from the middle.
    """
    r, theta = np.hypot(*position.T), np.arctan2(position[:, 1], position[:, 0])
    phi, c, s = r / radius, np.cos(theta), np.sin(theta)
    point = np.stack([np.cos(phi), np.sin(phi) * c, np.sin(phi) * s], axis=-1)
    out = np.stack([-np.sin(phi), np.cos(phi) * c, np.cos(phi) * s], axis=-1)
    across = np.stack([0 * phi, -s, c], axis=-1)
    y, z = c[:, None] * out - s[:, None] * across, s[:, None] * out + c[:, None] * across
    return point, np.stack([y, z], axis=1)


def main() -> None:
    """Run, print, and write where asked."""
    options = arguments(__doc__, parts=2, write=0)
    table: dict[str, dict[str, np.ndarray]] = {
        shape: {kind: np.empty((len(RADII), len(DEPTHS), len(QUANTITIES))) for kind in KINDS}
        for shape in ("cylinder", "sphere")
    }
    plain = elements(1e6, options.parts)
    for i, radius in enumerate(RADII):
        ball = elements(radius, options.parts)
        for j, depth in enumerate(DEPTHS):
            for name, kind in KINDS.items():
                table["cylinder"][name][i, j] = on_cylinder(radius, depth, kind)
                table["sphere"][name][i, j] = on_ball(radius, depth, name, ball, plain)
    for shape, kinds in table.items():
        for name, values in kinds.items():
            rows = [
                [f"{radius:g}", f"{depth:g}", *(f"{v:.3f}" for v in values[i, j])]
                for i, radius in enumerate(RADII)
                for j, depth in enumerate(DEPTHS)
            ]
            columns = [
                "radius / thickness",
                "depth / thickness",
                "reading",
                "position [depths]",
                "force",
                "angle [rad]",
            ]
            show(f"A flat layer on a {shape}, sensors of {name}: worst errors", columns, rows, options.json)
    if options.write:
        document = {
            "command": "python benchmarks/study_tips.py --write 1",
            "radius": RADII,
            "depth": DEPTHS,
            "quantities": QUANTITIES,
            "errors": {s: {k: np.round(v, 5).tolist() for k, v in kinds.items()} for s, kinds in table.items()},
        }
        TABLE.write_text(json.dumps(document, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
