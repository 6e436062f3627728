"""`subskin simulate`: readings, or a whole raw recording, of a finger."""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import replace
from functools import partial
from typing import Any, TextIO

from .. import io, stream
from .._lazy import np
from ..contact import contact_of, families, local_families, local_family_of
from ..errors import InvalidValueError
from ..io.units import quantity
from .cluster import DASK, cluster
from .common import AREA_COLUMNS, give, number, progress_bar, show
from .options import command, group, option, quantity_range, shared

_EXAMPLES = """\
  subskin simulate finger.toml -o readings.csv --count 1000 --force "10..60 N/m" --angle "-30..30 deg" --seed 1
  subskin simulate finger.toml -o line.csv --count 61 --grid --position "-9..9 mm" --contact hertz --half-width "1 mm"
  subskin simulate area.toml -o touches.csv --force "1 N" --angle "0..30 deg" --azimuth "0..360 deg"
  subskin simulate real.toml -o raw.csv --recording --count 31 --drift 40 --relaxation 0.2 --dead 2 --spread 0.2
"""
_MOST = 100_000_000  # readings: more would not fit into memory


def _known() -> tuple[str, ...]:
    """The families that there are now, one's own among them."""
    return (*families(), *local_families())


def _said() -> str:
    """What they are called."""
    what = f"family of the contact: {', '.join(families())}, or local: {', '.join(local_families())}"
    return f"{what} (line; on an area point)"


@command(
    _EXAMPLES,
    option("finger", "finger.toml"),
    group(
        "loads",
        'each a value or a range, "40 N/m" or "10..60 N/m"',
        option("--count N", "number of loads, or of presses (100)", 100),
        option("--position RANGE", "positions of the loads (default: over the row of sensors)"),
        option("--across RANGE", "their z, of local contacts (default: over the sensors)"),
        option("--force RANGE", 'forces of the loads ("40 N/m"; of local contacts "1 N")'),
        option("--angle RANGE", 'angles of the loads ("0 deg")', "0 deg"),
        option("--azimuth RANGE", 'where local contacts lean, from +y towards +z ("0 deg")'),
        option("--moment RANGE", 'moments about the normal, of local contacts ("0 N*mm")'),
        option("--grid", "positions evenly spaced, not random"),
        option("--contact FAMILY", _said, choices=_known),
        option("--half-width LENGTH", "half width of a contact of such a family"),
    ),
    option("--seed N", "seed of the random numbers (0)", 0),
    option("--spread SHARE", "gains differ by about this share (0)", 0.0),
    option("--dead LIST", "sensors, from 0, that read nothing: 2 or 0,3", ""),
    DASK,
    group(
        "a raw recording",
        "an indenter steps along the skin and presses at each position",
        option("--recording", "write raw frames, as [recording] of the file reads them"),
        option("--origin LENGTH", "y = 0 on the motor's axis, on an area y,z (default: that of the file, or 0)"),
        option("--drift SIZE", "slow drift, in readings (0)", 0.0),
        option("--relaxation SHARE", "share of a load lost in time (0.2)", 0.2),
        option("--stroke LENGTH", 'approach of the indenter ("4 mm")', "4 mm"),
        option("--hold TIME", 'how long a press is held ("1.5 s")', "1.5 s"),
        option("--rate RATE", 'frames a second ("50 Hz")', "50 Hz"),
    ),
    shared("table of readings, or of frames"),
)
def run_simulate(options: argparse.Namespace) -> int:
    """Run the command."""
    file = io.load(options.finger)
    n = len(file.finger.array)
    if options.count < 1 or options.count * n > _MOST:
        raise InvalidValueError(f"--count {options.count}", f"has to be between 1 and {_MOST // n}", "--count 100")
    if options.seed < 0:
        raise InvalidValueError(f"--seed {options.seed}", "has to be >= 0", "--seed 0")
    if options.contact is None:
        options.contact = "point" if file.finger.array.on_area else "line"
    local = options.contact in local_families()
    if local and options.recording and not file.finger.array.on_area:
        rule, fix = "a recording of a row is of long contacts", "leave --contact out"
        raise InvalidValueError(f"--recording of a {options.contact} load", rule, fix)
    for name in ("across", "azimuth", "moment") if not local else ("moment",) if options.recording else ():
        if getattr(options, name):
            rule = "a recording is of presses without one" if local else "a long contact is the same at every z"
            raise InvalidValueError(f"--{name} of a {options.contact} load", rule, "leave it out, or --contact point")
    if options.force is None:
        options.force = "1 N" if local else "40 N/m"
    rng = np.random.default_rng(options.seed)
    file = _moved(options, _worn(options, file, rng))
    if file.finger.measured is not None:
        what = f"{options.finger} has a response in place, and readings are simulated by the field of its skin"
        print(f"subskin: warning: {what}", file=sys.stderr)
    made = _frames if options.recording else _local_loads if local else _loads
    with cluster(options) as executor, progress_bar("loads", None) as advance:
        columns = made(options, file, rng, executor, advance)
    count = len(next(iter(columns.values())))
    if options.out is not None:
        io.write_table(options.out, columns)

    def people(out: TextIO) -> None:
        what = f"{options.count} presses in {count} frames" if options.recording else f"{count} loads"
        print(f"{what}, {n} sensors" + (f" -> {options.out}" if options.out else ""), file=out)
        if options.out is None:
            rows = [[str(i), *(number(values[i]) for values in columns.values())] for i in range(min(count, 20))]
            show(out, "the first rows, in SI; -o writes them all", ["row", *columns], rows)

    return give(options, lambda: {"rows": count, "columns": columns}, people)


def _angles(options: argparse.Namespace) -> tuple[float, float]:
    """The range of angles [rad], which on the command line is often one of degrees without the unit."""
    low, high = quantity_range(options.angle, "rad", "--angle")
    local = options.contact in local_families()
    if max(-low, high) > np.pi or (local and low < 0):
        seen = f'--angle "{options.angle}"'
        if max(-low, high) > np.pi and re.fullmatch(r"[-+.\d\s]*", options.angle):
            raise InvalidValueError(seen, "a number without a unit is in rad", f'--angle="{options.angle} deg"')
        if local:
            rule = "the angle of a local contact is from 0 to 180 deg; --azimuth says to which side it leans"
            raise InvalidValueError(seen, rule, '--angle "0..30 deg" --azimuth "0..360 deg"')
        raise InvalidValueError(seen, "an angle is from -180 to 180 deg", '--angle="-30..30 deg"')
    return low, high


def _worn(options: argparse.Namespace, file: io.FingerFile, rng: np.random.Generator) -> io.FingerFile:
    """The finger with gains that differ and dead sensors."""
    if not 0 <= options.spread < 1:
        raise InvalidValueError(f"--spread {options.spread:g}", "has to be in [0, 1)", "--spread 0.2")
    array = file.finger.array
    gain = np.asarray(array.gain) * (1 + options.spread * rng.uniform(-1, 1, len(array)))
    for part in options.dead.split(",") if options.dead else ():
        if not part.strip().isdecimal() or int(part) >= len(array):
            rule = f"sensors are numbered from 0 to {len(array) - 1}"
            raise InvalidValueError(f'--dead "{options.dead}"', rule, "--dead 2")
        gain[int(part)] = 0.0
    return replace(file, finger=replace(file.finger, array=replace(array, gain=gain)))


def _contact(options: argparse.Namespace) -> Any:
    width = None if options.half_width is None else quantity(options.half_width, "m", "--half-width")
    return contact_of(options.contact, width)


def _positions(options: argparse.Namespace, file: io.FingerFile, origin: float) -> tuple[float, float]:
    """The range of positions, on the axis of the tables."""
    if options.position is not None:
        return quantity_range(options.position, "m", "--position")
    y = np.asarray(file.finger.array.y)
    return float(y.min()) + origin, float(y.max()) + origin


def _ranges(options: argparse.Namespace, file: io.FingerFile) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ranges of y and of z of local contacts, on the axes of the tables."""
    points = file.on_touches(file.finger.array.points) if file.finger.array.on_area else file.finger.array.points
    ends: Any = [(float(c.min()), float(c.max())) for c in points.T]
    if not file.finger.array.on_area:
        ends[0] = _positions(options, file, file.origin)
    for i, name in enumerate(("position", "across")):
        if getattr(options, name) is not None:
            ends[i] = quantity_range(getattr(options, name), "m", f"--{name}")
    return ends[0], ends[1]


def _lattice(options: argparse.Namespace, file: io.FingerFile) -> Any:
    """Positions evenly spaced over the ranges, as many as are wanted, (count, 2)."""
    side = int(np.ceil(np.sqrt(options.count)))
    lattice = np.meshgrid(*(np.linspace(*ends, side) for ends in _ranges(options, file)), indexing="ij")
    return np.stack(lattice, axis=-1).reshape(-1, 2)[: options.count]


def _local(options: argparse.Namespace) -> Any:
    """What makes a local contact of its load and position."""
    more: dict[str, Any] = {}
    if options.half_width is not None and options.contact != "point":
        more["half_width"] = quantity(options.half_width, "m", "--half-width")
    elif (options.half_width is None) != (options.contact == "point"):
        rule = "a point has none" if options.contact == "point" else f"a {options.contact} contact needs one"
        raise InvalidValueError(f"--half-width {options.half_width}", rule, '--contact round_hertz --half-width "1 mm"')
    return partial(local_family_of(options.contact), **more)


def _loads(
    options: argparse.Namespace, file: io.FingerFile, rng: np.random.Generator, executor: Any, advance: Any
) -> dict[str, Any]:
    from ..synthetic import simulate_readings

    origin = file.origin
    low, high = _positions(options, file, origin)
    random = rng.uniform(low, high, options.count)
    position = np.linspace(low, high, options.count) if options.grid else random
    force = rng.uniform(*quantity_range(options.force, "N/m", "--force", file.length), options.count)
    angle = rng.uniform(*_angles(options), options.count)
    loads = {"force": force, "angle": angle, "position": position - origin}
    readings = simulate_readings(
        file.finger, _contact(options), loads, rng=rng, executor=executor, progress=lambda n: advance(n, options.count)
    )
    columns: dict[str, Any] = {"position": position, "force": force, "angle": angle}
    return columns | {name: readings[:, i] for i, name in enumerate(file.names)}


def _local_loads(
    options: argparse.Namespace, file: io.FingerFile, rng: np.random.Generator, executor: Any, advance: Any
) -> dict[str, Any]:
    """Local contacts over the sensors, forces in N."""
    from ..synthetic import simulate_readings

    count = options.count
    at = np.stack([rng.uniform(*ends, count) for ends in _ranges(options, file)], axis=-1)
    if options.grid:
        at = _lattice(options, file)
    columns: dict[str, Any] = {"position_y": at[:, 0], "position_z": at[:, 1]}
    asked = (("moment", "N m"),) if options.moment else ()
    for name, unit in (("force", "N"), ("angle", "rad"), ("azimuth", "rad"), *asked):
        ends = _angles(options) if name == "angle" else quantity_range(getattr(options, name) or "0", unit, f"--{name}")
        columns[name] = rng.uniform(*ends, count)
    load = {name: values for name, values in columns.items() if name in ("force", "angle", "moment")}
    load["azimuth"] = columns["azimuth"] - file.turn
    own = file.on_finger(at) if file.finger.array.on_area else at - [file.origin, 0.0]
    readings = simulate_readings(
        file.finger, _local(options), load | {"position": own},
        rng=rng, executor=executor, progress=lambda n: advance(n, count),
    )  # fmt: skip
    return columns | {name: readings[:, i] for i, name in enumerate(file.names)}


def _moved(options: argparse.Namespace, file: io.FingerFile) -> io.FingerFile:
    """The finger where --origin says that it lies."""
    if options.origin is None:
        return file

    each = [quantity(part, "m", "--origin") for part in options.origin.split(",")]
    on_area = file.finger.array.on_area
    if len(each) != 1 + on_area:
        rule = "y and z are needed, of a row one value"
        raise InvalidValueError(f'--origin "{options.origin}"', rule, '--origin "5 mm, 8 mm"')
    return replace(file, origin=np.array(each) if on_area else each[0])


def _frames(
    options: argparse.Namespace, file: io.FingerFile, rng: np.random.Generator, executor: Any, advance: Any
) -> dict[str, Any]:
    from ..synthetic import simulate_recording

    on_area = file.finger.array.on_area
    ranges = {"force": "N" if on_area else "N/m", "azimuth": "rad"}
    ends = {k: quantity_range(getattr(options, k) or "0", u, f"--{k}", file.length) for k, u in ranges.items()}
    ends["angle"] = _angles(options)
    if any(low != high for low, high in ends.values()):
        rule = "an indenter presses alike everywhere"
        raise InvalidValueError("a range of --force or --angle", rule, "give one value")
    hold, rate = quantity(options.hold, "s", "--hold"), quantity(options.rate, "Hz", "--rate")
    if not 0 < rate * (hold + 2) * options.count * len(file.names) < _MOST:
        raise InvalidValueError(
            f"{options.count} presses at {rate:g} Hz",
            "that is too long a recording",
            "a smaller --count, --rate or --hold",
        )
    raw = simulate_recording(
        file.finger,
        _lattice(options, file) if on_area else np.linspace(*_positions(options, file, file.origin), options.count),
        force=ends["force"][0],
        contact=partial(_local(options), azimuth=ends["azimuth"][0] - file.turn) if on_area else _contact(options),
        angle=ends["angle"][0],
        origin=file.origin,
        turn=file.turn,
        stroke=quantity(options.stroke, "m", "--stroke"),
        hold=hold,
        rate=rate,
        relaxation=options.relaxation,
        drift=options.drift,
        rng=rng,
        executor=executor,
        progress=advance,
    )
    how = file.recording or stream.RecordingFormat(file.names)
    usual = replace(how, press=how.press or stream.Column("press"))
    if how.position is None:
        y, z = map(stream.Column, AREA_COLUMNS)
        usual = replace(usual, position=(y, z) if on_area else stream.Column("position"))
    columns: dict[str, Any] = {name: raw.readings[:, i] / how.scale for i, name in enumerate(file.names)}
    each = [(how.time, raw.time), *zip(usual.tracks["position"], np.atleast_2d(raw.position.T), strict=True)]
    each += [] if how.force is None else [(how.force, raw.force)]
    for column, values in [*each, (usual.tracks["press"][0], raw.press)]:
        columns[column.name] = np.round(values / column.scale, 9)
    return columns
