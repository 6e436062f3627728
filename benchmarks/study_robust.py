"""What drift, relaxation, a weak or dead sensor and wild readings cost, without the remedy and with it.

    python benchmarks/study_robust.py [--seconds 240] [--json FILE]

A simulated stream first: six sensors at a depth of 2 mm, 1.5 mm apart, noise 0.1 % of the full scale, 100 frames a
second; touches of 2 s with 1.5 s between them, anywhere over the row, 20 to 60 N/m, leaning up to 34 degrees. Errors
are over the frames in which a held touch is OK; a frame is wrong that is OK while place, force or angle is off by more
than five of the standard deviations it states, and by more than 0.1 mm, 5 % or 3 degrees. Then the recording of a real
skin (four barometers under silicone) from ../shared/data, where it is at hand; wrong is there what is OK and off by
more than five standard deviations and 0.2 mm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.stream.presses import segment

RECORDING = Path(__file__).resolve().parents[2] / "shared/data/barotact/test_full_20230706_175400.csv"
RATE, DEPTH, PITCH, SENSORS = 100.0, 2e-3, 1.5e-3, 6
SKIN = ss.HalfPlane(ss.Material(0.4e6))
RUBBER = ss.Relaxation([0.07, 0.08], [0.5, 6.0])
DRIFT = 0.04  # of the full scale, largest, over the stream
WILD = 0.01  # of the readings


@dataclass
class Stream:
    """Frames and the truth behind them; `held` are the frames of touches at their full force."""

    finger: ss.Finger
    time: np.ndarray
    load: ss.LineLoad
    held: np.ndarray
    readings: np.ndarray
    scale: float


def simulate(seconds: float, faults: set[str], seed: int = 0) -> Stream:
    """A stream with some of the faults drift, relaxation, weak, dead, wild."""
    rng = np.random.default_rng(seed)
    field = ss.Finger(SKIN, ss.SensorArray.line(SENSORS, PITCH, DEPTH)).receptive_field(np.linspace(-4e-3, 4e-3, 81))
    scale = 60 * float(np.abs(field[..., 0]).max())
    tip = ss.Finger(SKIN, ss.SensorArray.line(SENSORS, PITCH, DEPTH, noise=1e-3 * scale, offset=0.5 * scale))
    time = np.arange(round(seconds * RATE)) / RATE
    which, phase = np.divmod(time, 3.5)
    which = which.astype(int)
    count = which[-1] + 1
    reach = 0.5 * (SENSORS - 1) * PITCH
    position = rng.uniform(-reach, reach, count)[which]
    angle, force = rng.uniform(-0.6, 0.6, count)[which], rng.uniform(20, 60, count)[which]
    ramp = np.clip(10 * np.minimum(phase - 1.3, 3.5 - phase), 0, 1)
    load = ss.LineLoad(force * ramp, angle, position)
    gain = np.ones(SENSORS)
    gain[2] = 0.6 if "weak" in faults else 0.0 if "dead" in faults else 1.0
    clean = replace(tip, array=replace(tip.array, gain=gain)).read(load)
    if "relaxation" in faults:
        clean = replace(RUBBER, rest=tip.array.offset).apply(clean, time)
    if "drift" in faults:
        phase = rng.uniform(0, 2 * np.pi, SENSORS)
        slow = np.sin(2 * np.pi * time[:, None] / 150 + phase) - np.sin(phase)
        clean = clean + DRIFT * scale * slow / np.abs(slow).max()
    readings = clean + 1e-3 * scale * rng.standard_normal(clean.shape)
    if "wild" in faults:
        at = rng.random(readings.shape) < WILD
        readings[at] += scale * rng.choice([-1, 1], at.sum()) * rng.uniform(0.05, 1, at.sum())
    return Stream(tip, time, load, ramp == 1, readings, scale)


def tared(stream: Stream) -> np.ndarray:
    """Drift off; the fastest that is believed is twice that of the stream."""
    return ss.Tare(stream.finger, drift=2 * DRIFT * stream.scale * 2 * np.pi / 150)(
        stream.readings, stream.time
    ).readings


def relaxed(stream: Stream) -> tuple[np.ndarray, str]:
    """Relaxation undone, as fitted to a recording of held touches of its own."""
    own = simulate(60, {"relaxation"}, seed=9)
    held = np.array([[3.5 * k + 1.45, 3.5 * k + 3.35] for k in range(17)])
    free = np.array([[3.5 * k + 0.1, 3.5 * k + 1.25] for k in range(17)])
    rest = own.finger.array.offset
    fit = ss.stream.fit_relaxation(own.readings, own.time, np.concatenate([held, free]), terms=2, rest=rest)
    found = fit.relaxation
    said = ", ".join(f"{100 * p:.1f} % in {t:.2f} s" for p, t in zip(found.share, found.time, strict=True))
    return found.undo(stream.readings, stream.time), said


def errors(stream: Stream, finger: ss.Finger, readings: np.ndarray, outliers: int = 0) -> list[str]:
    """Of the held frames: share OK, wrong, and rms and 95 % errors of place, force and angle."""
    at, load = stream.held, stream.load
    found = finger.locate(readings[at], outliers=outliers)
    ok = found.status == ss.Status.OK
    away = np.stack(
        [
            1e3 * (found.position - load.position[at]),
            100 * (found.force / load.force[at] - 1),
            np.rad2deg(found.angle - load.angle[at]),
        ],
        axis=-1,
    )
    std = found.std * np.stack([np.full(ok.size, 1e3), 100 / load.force[at], np.full(ok.size, 57.3)], axis=-1)
    wrong = ok & ((np.abs(away) > 5 * std) & (np.abs(away) > [0.1, 5, 3])).any(axis=-1)
    cells = [f"{100 * ok.mean():.1f}", f"{100 * wrong.mean():.2f}"]
    for k, digits in enumerate((3, 2, 2)):
        e = away[ok, k]
        cells.append(
            f"{np.sqrt((e**2).mean()):.{digits}f} / {np.quantile(np.abs(e), 0.95):.{digits}f}" if ok.any() else "-"
        )
    return cells


def simulated(seconds: float) -> list[list[str]]:
    """Each fault, without and with its remedy."""
    clean = simulate(seconds, set())
    rows = [["none", *errors(clean, clean.finger, clean.readings)]]
    drift = simulate(seconds, {"drift"})
    rows.append([f"drift, up to {100 * DRIFT:.0f} % of the full scale", *errors(drift, drift.finger, drift.readings)])
    rows.append(["  Tare", *errors(drift, drift.finger, tared(drift))])
    creep = simulate(seconds, {"relaxation"})
    rows.append(["relaxation, 15 %", *errors(creep, creep.finger, creep.readings)])
    undone, said = relaxed(creep)
    rows.append([f"  undone (fitted: {said})", *errors(creep, creep.finger, undone)])
    for fault in ("weak", "dead"):
        bad = simulate(seconds, {fault})
        health = ss.calibration.sensor_health(bad.finger, bad.readings[: len(bad.time) // 4])
        told = f"{health.health[2].name}, gain {health.gain_ratio[2] + 0:.4f} ± {health.std[2]:.4f}"
        rows.append([{"weak": "sensor 2 weakened to 60 %", "dead": "sensor 2 dead"}[fault]])
        rows[-1] += errors(bad, bad.finger, bad.readings)
        rows.append(["  outliers=1", *errors(bad, bad.finger, bad.readings, 1)])
        rows.append([f"  sensor_health: {told}", *errors(bad, health.finger, bad.readings)])
    wild = simulate(seconds, {"wild"})
    rows.append([f"{100 * WILD:.0f} % of the readings wild", *errors(wild, wild.finger, wild.readings)])
    rows.append(["  outliers=1", *errors(wild, wild.finger, wild.readings, 1)])
    every = simulate(seconds, {"drift", "relaxation", "weak", "wild"})
    rows.append(["drift, relaxation, weak, wild", *errors(every, every.finger, every.readings)])
    every.readings = relaxed(every)[0]
    every.readings = tared(every)
    health = ss.calibration.sensor_health(every.finger, every.readings)
    rows.append(["  all four remedies", *errors(every, health.finger, every.readings, 1)])
    return rows


class Barotact:
    """The recording: presses, calibrated on every second one; see tests/validation/test_barotact.py."""

    search = (-25e-3, 25e-3)
    fit = ("gain", "offset", "depth", "origin", "position", "poisson")

    def __init__(self) -> None:
        raw = np.genfromtxt(RECORDING, delimiter=",", skip_header=1)
        self.pressure, self.x, self.z, self.time = raw[:, :4], raw[:, 4] * 1e-6, raw[:, 5] / 320e3, raw[:, 6]
        self.presses = segment(self.pressure, self.time, position=self.x, press=self.z)
        self.positions = np.asarray(self.presses.position)
        drawn = ss.Finger(SKIN, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
        self.calibration = ss.calibrate(drawn, self.presses.reading[::2], self.positions[::2], fit=self.fit)
        self.finger = self.calibration.finger
        self.truth = self.positions - self.calibration.origin

    def mean(self, readings: np.ndarray, first: float, last: float) -> np.ndarray:
        """Mean reading over a part of each plateau, given by shares of it."""
        a, b = self.presses.start, self.presses.stop
        ends = np.stack([a + first * (b - a), a + last * (b - a)], axis=-1)
        at = np.searchsorted(self.time, ends)
        return np.stack([readings[i:j].mean(axis=0) for i, j in at])

    def rests(self, stop: float = 3e-3) -> np.ndarray:
        """First and last time of the stretches between presses with the indenter clear of the skin."""
        ends = zip(self.presses.stop[:-1], self.presses.start[1:], strict=True)
        clear = [self.time[(self.time > a) & (self.time < b) & (self.z < stop)] for a, b in ends]
        return np.array([[t[0], t[-1]] for t in clear])

    def locate(self, readings: np.ndarray, finger: ss.Finger | None = None, **options: int) -> ss.Estimate:
        """Presses go straight down."""
        return (finger or self.finger).locate(readings, friction=0, search=self.search, **options)

    def row(
        self, name: str, found: ss.Estimate, force: np.ndarray | None = None, truth: np.ndarray | None = None
    ) -> list[str]:
        """Share OK, wrong, median and 95 % error of place, and the forces' ratio to those of `force`."""
        away = 1e3 * np.abs(found.position - (self.truth[1::2] if truth is None else truth))
        ok = found.status == ss.Status.OK
        wrong = ok & (away > np.maximum(5e3 * found.std[:, 0], 0.2))
        ratio = "-" if force is None else f"{np.nanmedian(found.force[ok] / force[ok]):.3f}"
        worst = f"{np.median(away[ok]):.3f} / {np.quantile(away[ok], 0.95):.3f}" if ok.any() else "-"
        return [name, f"{ok.sum()} of {ok.size}", f"{wrong.sum()}", worst, ratio]


def recorded() -> list[list[str]]:
    """The same faults on the recording, on the presses that the calibration did not see."""
    b = Barotact()
    odd = slice(1, None, 2)
    tared_each = b.locate(b.presses.reading[odd])
    rows = [b.row("tared before each press, early reading", tared_each)]
    force = tared_each.force
    early = b.mean(b.pressure, 0.0, 0.4)
    first = b.pressure[b.time < 15].mean(axis=0)
    rows.append(b.row("  offsets of the first 15 s throughout", b.locate((early - first)[odd]), force))
    for drift in (5.0, 20.0):
        tare = ss.Tare(b.finger, drift=drift)(b.pressure, b.time)
        followed = b.mean(b.pressure - tare.offset, 0.0, 0.4)
        rows.append(b.row(f"  Tare on the whole stream, up to {drift:.0f} Pa/s", b.locate(followed[odd]), force))
    base = early - b.presses.reading
    late = b.mean(b.pressure, 0.8, 1.0)
    rows.append(b.row("late reading (last fifth of 8 s)", b.locate((late - base)[odd]), force))
    held = np.stack([b.presses.start, b.presses.stop], axis=-1)[::2]
    still = np.concatenate([held, b.rests()[::2]])
    fit = ss.stream.fit_relaxation(b.pressure, b.time, still, terms=2, rest=first)
    alone = [
        ss.stream.fit_relaxation(b.pressure[:, [i]], b.time, still, terms=2, rest=first[i]).relaxation for i in range(4)
    ]
    own = ss.Relaxation(
        np.concatenate([np.outer(k.share, np.eye(4)[i]) for i, k in enumerate(alone)]),
        np.concatenate([k.time for k in alone]),
        rest=first,
    )
    for name, kernel in (("one kernel", fit.relaxation), ("own shares", fit.own), ("own series", own)):
        undone = kernel.undo(b.pressure, b.time)
        clear = b.rests()
        # just before each press, as before, on the corrected stream
        before = np.searchsorted(b.time, np.concatenate([[b.time[0]], clear[:, 0]]))
        leave = np.searchsorted(b.time, b.presses.start)
        rest = []
        for i, j in zip(before, leave, strict=True):
            free = np.flatnonzero(b.z[i:j] < 3e-3)[-20:] + i
            rest.append(undone[free].mean(axis=0))
        for part, span in (("early", (0.0, 0.4)), ("late", (0.8, 1.0))):
            readings = b.mean(undone, *span) - np.array(rest)
            if part == "early":
                again = ss.calibrate(b.finger, readings[::2], b.positions[::2], fit=b.fit).finger
                reference = b.locate(readings[odd], again)
            found = b.locate(readings[odd], again)
            rows.append(b.row(f"  {name} undone, calibrated anew, {part}", found, reference.force))
    for name, gain in (("sensor 1 weakened to 60 %", 0.6), ("sensor 1 dead", 0.0)):
        spoilt = b.presses.reading * np.array([1, gain, 1, 1])
        rows.append(b.row(name, b.locate(spoilt[odd]), force))
        health = ss.calibration.sensor_health(b.finger, spoilt, friction=0, search=b.search)
        told = f"{health.health[1].name}, gain {health.gain_ratio[1]:.2f} ± {health.std[1]:.2f}"
        others = ", ".join(f"{r:.2f}" for r in np.delete(health.gain_ratio, 1))
        rows.append(b.row(f"  sensor_health: {told}; others {others}", b.locate(spoilt[odd], health.finger), force))
    rng = np.random.default_rng(0)
    many, truth = np.tile(b.presses.reading[odd], (100, 1)), np.tile(b.truth[odd], 100)
    at = rng.random(many.shape) < WILD
    many[at] += rng.choice([-1, 1], at.sum()) * rng.uniform(0.05, 1, at.sum()) * np.abs(b.presses.reading).max()
    rows.append(b.row("1 % of the readings wild (100 times over)", b.locate(many), None, truth))
    rows.append(b.row("  outliers=1", b.locate(many, outliers=1), None, truth))
    total, end = fit.relaxation.share.sum(), b.pressure[-100:].mean(axis=0) - first
    print(f"relaxation of each sensor, times the common {total:.3f}: {fit.scale.round(2)}; common: {fit.common}")
    print(f"held readings change by, in noises: {fit.before.round(1)}; the common kernel undone: {fit.after.round(1)}")
    print(f"readings of the free skin at the end, from the beginning [Pa]: {end.round(0)}")
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, seconds=240)
    columns = ["fault and remedy", "OK %", "wrong %", "place [mm]", "force [%]", "angle [deg]"]
    show("Simulated stream; errors rms / 95 %", columns, simulated(options.seconds), options.json)
    if not RECORDING.is_file():
        print(f"no recording at {RECORDING.name}: ../shared/data is not there")
        return
    columns = ["barotact, 30 presses held out", "OK", "wrong", "place, median / 95 % [mm]", "force, to the first"]
    show("A real skin", columns, recorded(), options.json)


if __name__ == "__main__":
    main()
