"""`subskin check`: what a finger cannot object to, and how wrong the half plane or flat layers are for it."""

from __future__ import annotations

import argparse
import math
import textwrap
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from .. import design, io
from ..errors import InvalidValueError
from ..io.units import quantity
from .common import give, note_orientation, number, progress_bar, said_of, show
from .options import JSON, command, option

if TYPE_CHECKING:
    from ..design.blind_spots import BlindSpots
    from ..design.tip import TipError
    from ..finger import Finger
    from ..io.finger_file import FingerFile

_EXAMPLES = """\
  subskin check finger.toml
  subskin check finger.toml --family hertz --snr 200       what a fit of rollers lets pass, at more noise
  subskin check finger.toml --thickness "6 mm"             what if my half plane were 6 mm of rubber on bone?
  subskin check finger.toml --radius "8 mm" --half-width "1 mm" --map error.png
  subskin check pad.toml --tip-map tip.png                 what [tip] radius = "9 mm" costs, rows and areas
"""
_NOTES = """\
First the blind spots: how often readings outside the model (two touches, a wide roller, a pull, another skin, a faulty
sensor, ...) are OK, and how often the position is then wrong. A status objects with the readings that are left over, so
a finger with few sensors lets more pass. Of sensors on an area the touches are points, all over their rectangle.

Then, of sensors in a row, the half plane. The finger's own skin (kind = "layers" or "round") is compared with the half
plane of the material around its sensors: the readings, and the errors of `locate`, over touches all along the row at
angles of -23, 0 and 23 degrees, free of noise. If finger.toml describes a half plane, give --thickness, --radius or
both: it is then compared with that skin. With a radius alone the core has half of it. The sensors of the map are of
normal strain, at a pitch of one depth.

If the file has [tip] with a radius, the layers lie flat in the model and round on the finger. The last table says what
that costs, on a cylinder under long contacts or on a ball under touches.
"""
_MODELS = (("as_drawn", "half plane as drawn"), ("calibrated", "half plane, calibrated"), ("own", "its own skin"))

_ROUNDING = 1e-4
"""Errors below this, in the unit shown, are those of receptive fields tabulated to 1e-9."""

_LITTLE = 0.02
"""Errors, in depths and in rad, that nobody minds."""

_TIPS = {"sphere": "ball", "cylinder": "cylinder"}
_PEOPLE = {"normal_strain": "normal strain", "mean_pressure": "pressure"}


@command(
    _EXAMPLES,
    option("finger", "finger.toml"),
    option("--thickness LENGTH", "thickness of the skin, bonded to a rigid base or core"),
    option("--radius LENGTH", "radius of the finger"),
    option("--half-width LENGTH", "half width of the touches (0: line loads)", "0 mm"),
    option("--snr N", "largest reading of the touches over its noise (1000)", 1000.0),
    option("--family NAME", "family fitted for the blind spots (what locate seeks)"),
    option("--touches N", "touches for each blind spot (1000)", 1000),
    option("--map FILE", "draw the error over thickness and radius; .svg, .png or .pdf"),
    option("--tip-map FILE", "draw what a round tip costs, over its radius and the depth"),
    JSON,
    notes=_NOTES,
)
def run_check(options: argparse.Namespace) -> int:
    """Run the command."""
    file = io.load(options.finger)
    bent = None
    with said_of(options.finger):
        if file.tip is not None:
            bent = design.tip.tip_error(file.finger, *file.tip)
    if options.tip_map is not None:
        if bent is None:
            raise InvalidValueError("--tip-map without a tip", "the file says of no radius", '[tip] radius = "9 mm"')
        _draw_tip(options.tip_map, bent)
    width = quantity(options.half_width, "m", "--half-width")
    finger = _meant(options, file.finger)
    compared = None
    if finger is not None:
        compared = design.half_plane_error(finger, half_width=width, snr=options.snr)
        if options.map is not None:
            _draw(options.map, finger, width)
    with said_of(options.finger):
        passed = _blind_spots(options, file, file.finger if finger is None else finger)

    note_orientation(file)

    def people(out: TextIO) -> None:
        _show_blind_spots(out, passed)
        if compared is not None:
            print(file=out)
            _show(out, options, compared)
        if bent is not None:
            print(file=out)
            _show_tip(out, bent)

    def data() -> dict[str, Any]:
        more = {} if bent is None else _tip_as_json(bent)
        return {"blind_spots": passed.to_dict(), **({} if compared is None else _as_json(compared)), **more}

    return give(options, data, people)


def _blind_spots(options: argparse.Namespace, file: FingerFile, finger: Finger) -> BlindSpots:
    """Those of the finger with the options of its file; where it has no noise, that of --snr."""
    if not np.all(np.asarray(finger.array.noise)[finger.array.live]):
        at = finger.array.points if finger.array.on_area else np.asarray(finger.array.y)
        fields = finger.receptive_field(at)[..., 0]
        noise = float(np.abs(fields).max()) / options.snr
        finger = replace(finger, array=replace(finger.array, noise=noise))
    settings: dict[str, Any] = {"search": file.search, **file.options}
    return finger.blind_spots(family=options.family, snr=options.snr, count=options.touches, **settings)


def _show_blind_spots(out: TextIO, found: BlindSpots) -> None:
    """The table, and the sentence that sums it up."""
    columns = ["readings from", "OK", "wrong", "far", "force", "unexplained"]
    shares = ("ok", "wrong", "far", "force", "unexplained")
    rows = [[row.text, *(f"{100 * getattr(row, name):.1f}" for name in shares)] for row in found.rows]
    show(out, f"share of {found.count} touches each [%], answered by a fit of {found.family}", columns, rows)
    print(
        "wrong: OK, and the position is off by more than 5 standard errors or 0.3 depth; far: by more than 0.3 depth;\n"
        "force: OK, and the normal force is off by more than 30 %",
        file=out,
    )
    print(textwrap.fill(f"-> {found.sentence}", 110, subsequent_indent="   "), file=out)


def _meant(options: argparse.Namespace, finger: Finger) -> Finger | None:
    """The finger of the file, its half plane replaced by the skin that --thickness and --radius name; None without."""
    from ..skin import HalfPlane, Layer, Layered, Round

    given = {k: quantity(v, "m", f"--{k}") for k in ("thickness", "radius") if (v := getattr(options, k)) is not None}
    if finger.array.on_area:
        for name in (*given, *(["map"] if options.map is not None else [])):
            rule = "the half plane is compared for sensors in a row"
            raise InvalidValueError(f"--{name} of sensors on an area", rule, "leave it out")
        return None
    if not finger.skin.endless:
        if given:
            seen = f"--{next(iter(given))} beside a skin that is no half plane"
            raise InvalidValueError(seen, "the file says already what the skin is", "change the file, or leave it out")
        return finger
    (material,) = finger.skin.materials
    if given and finger.skin != HalfPlane(material):
        rule = "layers and round fingers are long: plane strain"
        raise InvalidValueError('plane = "stress"', rule, "leave out plane")
    if not given:
        if options.map is None:
            return None
        fix = '--thickness "6 mm", --radius "8 mm" or both, or kind = "layers" or "round" in the file'
        raise InvalidValueError("--map of a half plane", "there is nothing to compare it with", fix)
    if "radius" not in given:
        return replace(finger, skin=Layered(Layer(material, given["thickness"])))
    radius = given["radius"]
    thickness = given.get("thickness", 0.5 * radius)  # without one, the core takes half
    return replace(finger, skin=Round(material, radius, radius - thickness))


def _draw(path: str, finger: Finger, half_width: float) -> None:
    from ..plot import half_plane_map_figure, save

    depth = float(np.asarray(finger.array.depth).mean())
    material = finger.skin.single_material
    poisson = 0.5 if material is None else material.poisson
    with progress_bar("map", len(design.half_plane.MAP_THICKNESS) * len(design.half_plane.MAP_RADIUS)) as advance:
        values = design.half_plane_map(poisson=poisson, half_width=half_width / depth, progress=advance)
    radius = finger.skin.period / (2 * np.pi)
    # a stack of several materials is none of the map's skins
    here = None if material is None else (finger.skin.thickness / depth, radius / depth)
    save(half_plane_map_figure(values, here), path)


def _as_json(found: design.half_plane.HalfPlaneError) -> dict[str, Any]:
    def one(error: design.half_plane.LocatingError) -> dict[str, Any]:
        return {**error.summary(), "unanswered": error.unanswered, "status": error.status}

    return {
        "skin": str(found.finger.skin),
        "half_width": found.half_width,
        "touches": found.positions.size * found.angles.size,
        "beneath": found.beneath,
        "worst_reading": {"normal": found.normal, "tangential": found.tangential},
        "locate": {name: one(getattr(found, name)) for name, _ in _MODELS},
        "calibrated_depth": found.depth,
    }


def _show(out: TextIO, options: argparse.Namespace, found: design.half_plane.HalfPlaneError) -> None:
    array = found.finger.array
    print(f"{found.finger.skin}, read as a half plane\n", file=out)
    depths = np.asarray(array.depth)
    rows = [[f"{i}", number(1e3 * depth), _factor(found.beneath[i])] for i, depth in enumerate(depths.tolist())]
    if len({(row[1], row[2]) for row in rows}) == 1:
        rows = [["all", *rows[0][1:]]]
    show(out, "straight beneath a normal touch", ["sensor", "depth [mm]", "reading / half plane's"], rows)
    print(
        f"anywhere along the row, of the largest reading: the half plane is off by up to {100 * found.normal:.1f} % "
        f"under a normal touch, {100 * found.tangential:.1f} % under a drag\n",
        file=out,
    )
    table = []
    for model, label in _MODELS:
        error: design.half_plane.LocatingError = getattr(found, model)
        sizes, scales = error.summary(), {"position": 1e3, "force": 100.0, "angle": 180 / np.pi}
        errors = [_size(scale * sizes[name][k]) for name, scale in scales.items() for k in ("median", "worst")]
        table.append([label, *errors, str(error.unanswered), str(error.status["unexplained"])])
    heads = ["locate with", "position [mm]", "worst", "force [%]", "worst", "angle [deg]", "worst"]
    count = found.positions.size * found.angles.size
    show(out, f"errors of {count} touches, median and worst", [*heads, "no answer", "unexplained"], table)
    share = number(options.snr)
    print(f"unexplained: number of touches at a noise of 1/{share} of a sensor's largest reading", file=out)
    depth = float(depths.mean())
    taken, true = (f"{1e3 * d:.3g} mm" for d in (found.depth, depth))
    if not np.isfinite(found.depth):
        print("the half plane's gains and depth could not be calibrated", file=out)
    elif taken != true:
        print(
            f"calibrated at known positions, the half plane takes the sensors to be {taken} deep, not {true}:\n"
            "a wrong depth makes up for part of a wrong skin",
            file=out,
        )
    print(f"-> {_verdict(found, depth)}", file=out)
    if options.map is not None:
        print(f"the map is {_map_note(found.finger)}\n-> {options.map}", file=out)


def _map_note(finger: Finger) -> str:
    """What the map is of, and what it is not."""
    note = "for six sensors of normal strain, at a pitch of one depth; your own array's errors are those above"
    return f"{note}; your stack of several materials is not on it" if finger.skin.single_material is None else note


def _verdict(found: design.half_plane.HalfPlaneError, depth: float) -> str:
    """What to do."""
    flat, own = found.as_drawn.summary(), found.own.summary()
    worst, least = ([s[k]["worst"] for k in ("position", "angle")] for s in (flat, own))
    lost, few = found.as_drawn.unanswered, found.own.unanswered
    said = _off(*worst)
    if lost == found.as_drawn.position.size:
        said = "has no answer for any of the touches"
    elif lost > few:
        said += f", and has no answer for {lost} of them"
    minded = (_LITTLE * depth, _LITTLE)
    worse = (not w <= max(2 * e, small) for w, e, small in zip(worst, least, minded, strict=True))
    if lost > 2 * few or any(worse):
        return f"use the finger's own skin: the half plane {said}"
    if any(not e <= small for e, small in zip(least, minded, strict=True)):
        return f"the touches are too wide for either: the half plane {said}; the finger's own skin {_off(*least)}"
    return f"the half plane will do: it {said}"


def _off(position: float, angle: float) -> str:
    return f"misplaces touches by up to {_size(1e3 * position)} mm and turns them by {_size(math.degrees(angle))} deg"


def _factor(value: float) -> str:
    return "-" if value != value else f"{value:.3f}"


def _size(value: float) -> str:
    """An error for people: what is only rounding is 0, and no exponents."""
    if value < _ROUNDING:
        return "0"
    return f"{value:.0f}" if value >= 10 else number(value, 2)


def _tip_as_json(found: TipError) -> dict[str, Any]:
    """The numbers, in SI."""
    return {"tip": asdict(found)}


def _show_tip(out: TextIO, found: TipError) -> None:
    """A table, and the sentence that sums it up."""
    name = _TIPS[found.shape]
    row = [
        *(number(1e3 * v) for v in (found.radius, found.thickness, found.depth)),
        f"{100 * found.reading:.1f}", number(1e3 * found.position, 2), f"{100 * found.force:.1f}",
        number(math.degrees(found.angle), 2),
    ]  # fmt: skip
    columns = ["tip [mm]", "skin [mm]", "depth [mm]", "reading [%]", "position [mm]", "force [%]", "angle [deg]"]
    show(out, f"flat layers on a {name}: worst errors", columns, [row])
    sensors = " or ".join(_PEOPLE[kind] for kind in found.kinds)
    loads = "touches" if found.shape == "sphere" else "long contacts"
    print(
        textwrap.fill(
            f"looked up for sensors of {sensors}, one depth apart, in one incompressible layer on a rigid core", 110
        ),
        file=out,
    )
    print(textwrap.fill(f"-> {_tip_verdict(found, name, loads)}", 110, subsequent_indent="   "), file=out)


def _tip_verdict(found: TipError, name: str, loads: str) -> str:
    size = f"{number(1e3 * found.radius)} mm"
    if found.position < _LITTLE * found.depth and max(found.angle, found.force) < _LITTLE:
        return f"the flat layers will do: on a {name} of {size} they misplace {loads} by less than 0.02 depths"
    said = (
        f"on a {name} of {size} flat layers misplace {loads} by up to {number(1e3 * found.position, 2)} mm, with "
        f"forces off by up to {100 * found.force:.0f} % and angles by up to {math.degrees(found.angle):.0f} deg"
    )
    if found.shape == "cylinder":
        return f'{said}: take kind = "round", the same layers on a round core'
    return f"{said}: no skin here is a ball, so calibrate with touches at known positions, which finds its response"


def _draw_tip(path: str, found: TipError) -> None:
    """The table's map, with this tip ringed."""
    from ..plot import save, tip_map_figure

    at = found.radius / found.thickness, found.depth / found.thickness
    save(tip_map_figure(design.tip.tip_map(found.shape, found.kinds[0]), at), path)
