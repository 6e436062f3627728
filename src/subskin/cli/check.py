"""`subskin check`: how wrong the half plane is for a finger."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from .common import add_command, number, say, show, write_json

if TYPE_CHECKING:
    from ..design import HalfPlaneError, LocatingError
    from ..finger import Finger

_EXAMPLES = """\
  subskin check finger.toml
  subskin check finger.toml --thickness "6 mm"             what if my half plane were 6 mm of rubber on bone?
  subskin check finger.toml --radius "8 mm" --half-width "1 mm" --map error.png
"""
_NOTES = """\
Compares the finger's own skin (kind = "layers" or "round") with the half plane of the material around its sensors:
what the sensors read, and what `locate` makes of it, over touches all along the row at angles of -23, 0 and 23
degrees, free of noise. A finger.toml that describes a half plane is tried as a skin of the thickness and the radius
given. The sensors of the map are of normal strain, one depth apart.
"""
_MODELS = (
    ("as_drawn", "half plane as drawn"),
    ("calibrated", "half plane, calibrated"),
    ("own", "its own skin"),
)

_SMALL_PLACE, _SMALL_ANGLE = 0.02, 0.02  # depths, rad: errors that nobody minds
_ROUNDING = 1e-5


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(commands, "check", run, "say how wrong the half plane is for a finger", _EXAMPLES)
    parser.description = f"{parser.description}\n\n{_NOTES}"
    parser.add_argument("finger", help="finger.toml")
    parser.add_argument(
        "--thickness", metavar="LENGTH", help="thickness of the skin, bonded to a rigid base or core"
    )
    parser.add_argument("--radius", metavar="LENGTH", help="radius of the finger")
    parser.add_argument(
        "--half-width", metavar="LENGTH", default="0 mm", help="half width of the touches (line loads)"
    )
    parser.add_argument(
        "--snr", type=float, default=1000.0, metavar="N", help="largest reading over the noise (1000)"
    )
    parser.add_argument(
        "--map", metavar="FILE", help="draw the error over thickness and radius; .svg, .png or .pdf"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..design import half_plane_error
    from ..io.files import check_target
    from ..io.finger_file import load_finger
    from ..io.units import quantity

    file = load_finger(options.finger)
    if options.map is not None:
        from ..errors import FileError

        if not options.map.lower().endswith((".svg", ".png", ".pdf")):
            raise FileError(f"--map {options.map}", "a figure is .svg, .png or .pdf", "--map error.png")
        check_target(options.map)
    width = quantity(options.half_width, "m", "--half-width")
    finger = _meant(options, file.finger)
    found = half_plane_error(finger, half_width=width, snr=options.snr)
    if options.map is not None:
        _draw(options.map, finger, width)
    if options.json:
        write_json(_as_json(found))
    else:
        _show(options, found)
    return 0


def _meant(options: argparse.Namespace, finger: Finger) -> Finger:
    """The finger of the file, its half plane replaced by the skin that --thickness and --radius name."""
    from dataclasses import replace

    from ..errors import InvalidValueError
    from ..io.units import quantity
    from ..skin import HalfPlane, Layer, Layered, Round

    given = {
        k: quantity(v, "m", f"--{k}")
        for k in ("thickness", "radius")
        if (v := getattr(options, k)) is not None
    }
    if not isinstance(finger.skin, HalfPlane):
        if given:
            seen = f"--{next(iter(given))} beside a skin that is no half plane"
            raise InvalidValueError(
                seen, "the file says already what the skin is", "change the file, or leave it out"
            )
        return finger
    if not given:
        raise InvalidValueError(
            "a finger whose skin is a half plane",
            "there is nothing to compare it with",
            '--thickness "6 mm", --radius "8 mm" or both, or kind = "layers" or "round" in the file',
        )
    material = finger.skin.material
    if "radius" not in given:
        return replace(finger, skin=Layered(Layer(material, given["thickness"])))
    radius = given["radius"]
    thickness = given.get("thickness", 0.5 * radius)  # without one, the core takes half
    return replace(finger, skin=Round(material, radius, radius - thickness))


def _draw(path: str, finger: Finger, half_width: float) -> None:
    import numpy as np

    from ..design import half_plane_map
    from ..plot import half_plane_map_figure, save
    from ..skin import Round

    depth = float(np.asarray(finger.array.depth).mean())
    material = finger.skin.single_material
    thickness = np.array([1.1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5, 7, 10, 20, 50])
    radius = np.array([2.5, 3, 4, 5, 7, 10, 15, 20, 30, 50, 100, np.inf])
    with _progress(thickness.size * radius.size) as advance:
        values = half_plane_map(
            thickness,
            radius,
            poisson=0.5 if material is None else material.poisson,
            half_width=half_width / depth,
            progress=advance,
        )
    here = (
        finger.skin.thickness / depth,
        (finger.skin.radius if isinstance(finger.skin, Round) else np.inf) / depth,
    )
    save(half_plane_map_figure(thickness, radius, values, here if np.isfinite(here[0]) else None), path)


@contextmanager
def _progress(total: int) -> Iterator[Callable[[], object]]:
    if not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    bar = Progress(
        "map", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=Console(stderr=True)
    )
    with bar:
        task = bar.add_task("", total=total)
        yield lambda: bar.advance(task)


def _as_json(found: HalfPlaneError) -> dict[str, Any]:
    def one(error: LocatingError) -> dict[str, Any]:
        return {**error.summary(), "status": error.status}

    return {
        "half_width": found.half_width,
        "touches": found.places.size * found.angles.size,
        "beneath": found.beneath,
        "worst_reading": {"normal": found.normal, "tangential": found.tangential},
        "locate": {name: one(getattr(found, name)) for name, _ in _MODELS},
        "calibrated_depth": found.depth,
    }


def _show(options: argparse.Namespace, found: HalfPlaneError) -> None:
    import numpy as np

    out = say(options)
    array = found.finger.array
    rows = [
        [f"{i}", number(1e3 * float(np.asarray(array.depth)[i]), 4), f"{found.beneath[i]:.3f}"]
        for i in range(len(array))
    ]
    same = len({(row[1], row[2]) for row in rows}) == 1
    if same:
        rows = [["all", *rows[0][1:]]]
    show(out, "straight beneath a normal touch", ["sensor", "depth [mm]", "reading / half plane's"], rows)
    print(
        f"anywhere along the row the half plane's readings are off by up to {100 * found.normal:.1f} % of the largest "
        f"under a normal touch, {100 * found.tangential:.1f} % under a drag\n",
        file=out,
    )
    table = []
    for name, label in _MODELS:
        error: LocatingError = getattr(found, name)
        s = error.summary()
        table.append(
            [
                label,
                *(_size(1e3 * s["position"][k]) for k in ("median", "worst")),
                *(_size(100 * s["force"][k]) for k in ("median", "worst")),
                *(_size(float(np.rad2deg(s["angle"][k]))) for k in ("median", "worst")),
                str(error.status["unexplained"]),
            ]
        )
    count = found.places.size * found.angles.size
    heads = [
        "locate with",
        "place [mm]",
        "worst",
        "force [%]",
        "worst",
        "angle [deg]",
        "worst",
        "unexplained",
    ]
    show(
        out, f"errors of {count} touches: median and worst; how many are said to be unexplained", heads, table
    )
    drawn, own = found.as_drawn.summary(), found.own.summary()
    depth = float(np.asarray(array.depth).mean())
    print(
        f"calibrated at known places, the half plane takes the sensors to be {1e3 * found.depth:.3g} mm deep, not "
        f"{1e3 * depth:.3g} mm: a wrong depth makes up for part of a wrong skin",
        file=out,
    )
    place, angle = drawn["position"]["worst"], drawn["angle"]["worst"]
    off = f"misplaces touches by up to {1e3 * place:.2g} mm and turns them by {np.rad2deg(angle):.2g} deg"
    said = f"the half plane {off}"
    worse = (place > max(2 * own["position"]["worst"], _SMALL_PLACE * depth)) or (
        angle > max(2 * own["angle"]["worst"], _SMALL_ANGLE)
    )
    print(
        f"-> use the finger's own skin: {said}" if worse else f"-> the half plane will do: {said}", file=out
    )
    if options.map is not None:
        print(f"-> {options.map}", file=out)


def _size(value: float) -> str:
    """An error for people: what is only rounding is 0."""
    return "0" if value < _ROUNDING else number(value, 2)
