"""Skins beside finite elements, refined: the model of tests/verification/_fem.py, which shares nothing with subskin.

    python benchmarks/study_fem.py [--finest 8] [--json FILE]

Strains on a grid of places beneath a contact, from four fifths of its half width a down to the base: the rms
difference over the largest strain there, anywhere and at the points where such elements are one order better. It
falls by 4 and by 8 where elements are halved, until the tractions' jumps or the interfaces show. The second table has a
round contact of Hertz's pressure, pressed, dragged along a slant and twisted: elements in depth and radius, times cos
and sin of m theta, m = 0 and 1; its displacements fall by 8. The third presses a rigid cylinder on a very thick layer,
where the contact that elements find has to be Hertz's.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

import subskin as ss
from _common import arguments, show

sys.path.append(str(Path(__file__).resolve().parents[1]))
from tests.verification._fem import Body, along, split
from tests.verification._fem_round import Touched

A = 1.25e-3
SOFT, HARD = ss.Material(0.4e6, 0.5), ss.Material(0.4e6, 0.3)
SKINS = {
    "layer 4 a, nu = 1/2": ss.Layered(ss.Layer(SOFT, 4 * A)),
    "layer 4 a, nu = 0.3": ss.Layered(ss.Layer(HARD, 4 * A)),
    "a of 2 MPa, 0.3 on 3 a of 0.4 MPa, 1/2": ss.Layered([ss.Layer(ss.Material(2e6, 0.3), A), ss.Layer(SOFT, 3 * A)]),
    "round 8 a, core 4 a, nu = 1/2": ss.Round(SOFT, 8 * A, 4 * A),
    "round 8 a, core 4 a, nu = 0.3": ss.Round(HARD, 8 * A, 4 * A),
    "round 8 a: a of 2 MPa, 0.3 on 3 a of 0.4 MPa, 1/2": ss.Round(
        SOFT, 8 * A, 4 * A, ss.Layer(ss.Material(2e6, 0.3), A)
    ),
}
CONTACTS = {
    "strip": ss.Strip(40.0, half_width=A),
    "strip, 34 degrees": ss.Strip(40.0, 0.6, half_width=A),
    "Hertz": ss.Hertz(40.0, half_width=A),
    "Hertz, -34 degrees": ss.Hertz(40.0, -0.6, half_width=A),
}


def elements(skin: ss.Layered | ss.Round, parts: int) -> Body:
    """Half a contact's half width by an eighth of the thickness, growing aside, cut into `parts` either way."""
    depths = split(skin.thickness * np.linspace(0, 1, 9), parts)
    positions = np.cumsum([layer.thickness for layer in skin.stack]) * (1 - 1e-9)
    bottoms, materials = depths[np.searchsorted(depths, positions)], skin.materials
    radius, half = np.inf, 20 * skin.thickness
    if isinstance(skin, ss.Round):
        radius, half = skin.radius, np.pi * skin.radius
    layers = [(d, m.young, m.poisson) for d, m in zip(bottoms, materials, strict=True)]
    return Body(depths, split(along(-A, A, 4, -half, half), parts), layers, radius)


def strains(skin: ss.Layered | ss.Round | ss.HalfPlane, contact: ss.Hertz, x: np.ndarray, y: np.ndarray):
    """Strains (3, ...) by subskin."""
    e = skin.strain(contact, x, y)
    return np.stack([e.xx, e.yy, e.xy])


def tractions(finest: int) -> list[list[str]]:
    """Errors of every skin under every contact, mesh by mesh."""
    rows = []
    for title, skin in SKINS.items():
        x = A * np.linspace(0.8, 4.0, 17)[:, None]
        y = A * np.linspace(-2.93, 3.07, 31)
        errors: dict[str, list[np.ndarray]] = {name: [] for name in CONTACTS}
        sizes, times = [], []
        for parts in 2 ** np.arange(int(np.log2(finest)) + 1):
            start = perf_counter()
            body = elements(skin, int(parts))
            body.solve(np.zeros(body.basis.N))  # meshed and factorised
            times.append(perf_counter() - start)
            sizes.append(body.unknowns)
            for name, contact in CONTACTS.items():
                found, both = body.pull(contact.pressure, contact.shear), []
                for at in ((x, y), body.best(x, y)):
                    ours = strains(skin, contact, *at)
                    both.append(np.sqrt(((found.strain(*at) - ours) ** 2).mean()) / np.abs(ours).max())
                errors[name].append(np.array(both))
        for name, seen in errors.items():
            for i, (size, seconds, error) in enumerate(zip(sizes, times, seen, strict=True)):
                falls = seen[i - 1] / error if i else None
                cells = [f"{e:.1e}" for e in error]
                gains = ["", ""] if falls is None else [f"{f:.1f}" for f in falls]
                first = f"{title}; {name}" if i == 0 else ""
                rows.append([first, f"{size}", f"{seconds:.2f}", cells[0], gains[0], cells[1], gains[1]])
    return rows


def local(finest: int) -> list[list[str]]:
    """Errors of every flat skin under a round contact: strains anywhere and at the best points, displacements."""
    touch, rows = ss.RoundHertz(components=(1.0, 0.375, -0.25), moment=0.3 * A, half_width=A), []
    x, r = (a.ravel() for a in np.meshgrid(A * np.linspace(0.8, 4.0, 17), A * np.linspace(0.05, 3.0, 31)))
    theta = np.random.default_rng(0).uniform(-np.pi, np.pi, x.size)

    def shape(r: np.ndarray) -> np.ndarray:
        return 3 / (2 * np.pi * A**2) * np.sqrt(np.maximum(1 - (r / A) ** 2, 0.0))

    def differences(skin: ss.Layered, body: Touched, x: np.ndarray, r: np.ndarray) -> list[float]:
        state = skin.state(touch, x, r * np.cos(theta), r * np.sin(theta))
        strain = np.array([getattr(state.strain, name) for name in ("xx", "yy", "zz", "xy", "xz", "yz")])
        moved = np.array([state.displacement.x, state.displacement.y, state.displacement.z])
        found = zip((strain, moved), body.at(x, r, theta), strict=True)
        return [float(np.sqrt(((a - b) ** 2).mean()) / np.abs(a).max()) for a, b in found]

    for title, skin in SKINS.items():
        if isinstance(skin, ss.Round):
            continue
        before: np.ndarray | None = None
        for parts in 2 ** np.arange(int(np.log2(finest)) + 1):
            start = perf_counter()
            flat = elements(skin, int(parts))
            radii = split(along(0, A, 2, 0, 16 * skin.thickness, 1.4), int(parts))
            body = Touched(flat.depths, radii, flat.layers, shape, touch.components, float(touch.moment))
            seconds = perf_counter() - start
            anywhere, best = (differences(skin, body, *at) for at in ((x, r), body.even.best(x, r)))
            errors = np.array([anywhere[0], best[0], anywhere[1]])
            falls = [""] * 3 if before is None else [f"{f:.1f}" for f in before / errors]
            cells = [cell for pair in zip((f"{e:.1e}" for e in errors), falls, strict=True) for cell in pair]
            rows.append(["" if before is not None else title, f"{body.even.unknowns}", f"{seconds:.2f}", *cells])
            before = errors
    return rows


def pressed() -> list[list[str]]:
    """A rigid parabola on a layer a thousand half widths thick, beside Hertz."""
    rows, young, radius, force = [], 0.4e6, 20e-3, 40.0
    for nu in (0.5, 0.3):
        a = np.sqrt(4 * force * radius * (1 - nu**2) / (np.pi * young))
        hertz, half_plane = ss.Hertz(force, half_width=a), ss.HalfPlane(ss.Material(young, nu))
        for count in (12, 24, 48):
            start = perf_counter()
            depths = along(0, a, count // 4, 0, 1000 * a, 1.3)
            positions = along(-1.25 * a, 1.25 * a, int(2.5 * count), -4000 * a, 4000 * a, 1.3)
            body = Body(depths, positions, [(depths[-1], young, nu)])
            found = body.press(lambda y: y * y / (2 * radius), force, (-1.15 * a, 1.15 * a))
            seconds = perf_counter() - start
            x, y = body.best(a * np.array([0.5, 1.0, 2.0])[:, None], a * np.linspace(-2, 2, 9))
            ours = strains(half_plane, hertz, x, y)
            error = np.abs(found.solution.strain(x, y) - ours).max() / np.abs(ours).max()
            within = np.abs(found.y) < 0.8 * a
            middle = np.abs(found.pressure / np.where(within, hertz.pressure(found.y), 1.0) - 1)[within].max()
            width = 0.5 * (found.edges[1] - found.edges[0]) / a - 1
            rows.append([f"nu = {nu}, elements of a / {count}", f"{body.unknowns}", f"{seconds:.2f}"])
            rows[-1] += [f"{width:+.1e}", f"{middle:.1e}", f"{error:.1e}"]
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, finest=8)
    columns = ["skin; contact", "unknowns", "s", "anywhere", "falls by", "best points", "falls by"]
    title = "subskin less finite elements, rms over the largest strain"
    show(title, columns, tractions(options.finest), options.json)
    columns = ["skin", "unknowns of a mode", "s", "strains anywhere", "falls by", "best points", "falls by"]
    columns += ["displacements", "falls by"]
    show("A round contact less finite elements in Fourier modes", columns, local(options.finest), options.json)
    columns = ["rigid cylinder, no friction", "unknowns", "s", "half width", "pressure, |y| < 0.8 a", "strains"]
    show("Finite elements beside Hertz on a half plane", columns, pressed(), options.json)


if __name__ == "__main__":
    main()
