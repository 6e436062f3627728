"""Do the 95 % intervals of positions hold the truth on real skins? Presses held out of a calibration, located by it.

    python benchmarks/study_coverage.py [--data FOLDER] [--recordings full,day,10R,10L,20R,20L]
                                        [--skins "half plane"] [--json FILE]

FOLDER (../shared/data) holds the recordings, which do not ship with this package: barotact/ (four barometers in a row)
and underwater/ (two columns of four barometers each; the presses above a column are taken for a row's). Of each
recording every second press calibrates, then the others do; then five blocks of neighbours are left out one after the
other, so that the presses left out lie in a gap of the calibration, or beyond its end. The presses left out are located
with the finger's own search, once as straight loads (friction 0) and once as loads that may lean (friction 1). Cells:
share of the presses held out and OK whose 95 % interval holds the truth, as if misfit were white noise ("before") and
with the spread that `calibrate` measures, and how many they are; calibrations that were refused.

A second table holds the depths that recordings of one skin give, by the same numbers fitted, and how many standard
errors they are from that of the first.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show

PSI = 6894.757  # Pa
BASE = ("gain", "lift", "depth", "origin", "position")
RUBBER = ss.Material(young=0.4e6)
SKINS = {
    "half plane": (ss.HalfPlane(RUBBER), BASE),
    "layer": (ss.Layered(ss.Layer(RUBBER, 15e-3)), (*BASE, "thickness")),
}
KINDS = {"strain": ss.NormalStrain(), "stress": ss.NormalStress()}
COLUMNS = {"10R": 17.45, "10L": 10.45, "20R": 19.05, "20L": 9.05}  # mm, where the column's readings are largest
WATER = {
    "10": ("DS10_atm_6.75_10_samples_cast-bond_trial1.csv", 1, 6.75e-3),
    "20": ("DS20_25PSI_9.9_10_samples_cast-bond_trial1.csv", 0, 9.9e-3),
}
AIR = {"full": "test_full_20230706_175400.csv", "day": "test_20230706_162352.csv", "next": "test_20230707_143819.csv"}
NOISE = 10.0  # Pa, as docs/recording.md states it
Q95 = 1.959964
DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def presses(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and readings [Pa]: the first 40 % of each plateau of z, less the rest before it."""
    raw = np.genfromtxt(path, delimiter=",", skip_header=1)
    pressure, x, z = raw[:, :4], raw[:, 4] * 1e-6, raw[:, 5]
    steps = np.flatnonzero(np.diff(np.concatenate([[0], (z > 0.99 * z.max()).astype(int), [0]])))
    positions, readings = [], []
    for start, stop in zip(steps[::2], steps[1::2], strict=True):
        leaving = start
        while z[leaving - 1] < z[leaving]:
            leaving -= 1
        early = start + max(int(0.4 * (stop - start)), 1)
        readings.append(pressure[start:early].mean(0) - pressure[max(leaving - 10, 0) : leaving].mean(0))
        positions.append(x[start])
    return np.array(positions), np.array(readings)


def recording(data: Path, name: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Positions (m,) [m], readings (m, 4) [Pa] and the pitch of the sensors [m]."""
    if name in AIR:
        return *presses(data / "barotact" / AIR[name]), 6e-3
    file, header, pitch = WATER[name[:2]]
    raw = np.genfromtxt(data / "underwater" / file, delimiter=",", skip_header=header)
    rows = raw[np.abs(raw[:, 0] - COLUMNS[name]) < 0.01]
    # s0 to s3 go up the right column, s4 to s7 down the left one
    readings = rows[:, 2:6] if name[-1] == "R" else rows[:, 9:5:-1]
    return rows[:, 1] * 1e-3, PSI * readings, pitch


def splits(count: int) -> list[tuple[str, np.ndarray]]:
    """Which presses calibrate, and how the others lie: between them, or in a gap."""
    every = np.arange(count)
    gaps = [("gap", np.setdiff1d(every, block)) for block in np.array_split(every, 5)]
    return [("between", every[::2]), ("between", every[1::2]), *gaps]


def scores(
    drawn: ss.Finger, fit: tuple[str, ...], readings: np.ndarray, positions: np.ndarray, used: np.ndarray
) -> list[list[tuple[float, float]]]:
    """Errors over stated standard errors, and the spread at each, of presses not `used`: straight, leaning."""
    held = np.setdiff1d(np.arange(len(positions)), used)
    found = ss.calibrate(drawn, readings[used], positions[used], fit=fit)
    out = []
    for friction in (0.0, 1.0):
        at = found.finger.locate(readings[held], friction=friction)
        error = np.abs(at.position - (positions[held] - found.origin)) / at.std[..., 0]
        spread = found.finger.spread.at(at.position, friction) if found.finger.spread else np.ones(len(held))
        out.append([(float(e), float(s)) for e, s in zip(error[at.ok], spread[at.ok], strict=True)])
    return out


def share(z: list[tuple[float, float]]) -> tuple[float, float]:
    """Shares [%] whose interval holds the truth, before and after the spread."""
    if not z:
        return np.nan, np.nan
    e, spread = np.transpose(z)
    return 100 * float(np.mean(e * spread <= Q95)), 100 * float(np.mean(e <= Q95))


def held(data: Path, names: list[str], skins: list[str]) -> list[list[str]]:
    """Rows of the first table."""
    rows, total = [], {(load, lie): [] for load in (0, 1) for lie in ("between", "gap")}
    for name in names:
        positions, readings, pitch = recording(data, name)
        order = np.argsort(positions, kind="stable")
        positions, readings = positions[order], readings[order]
        for skin in skins:
            medium, base = SKINS[skin]
            for kind, fit in (("strain", base), ("strain", (*base, "poisson")), ("stress", base)):
                drawn = ss.Finger(medium, ss.SensorArray.line(4, pitch, 5e-3, transducer=KINDS[kind], noise=NOISE))
                z: dict[tuple[int, str], list] = {key: [] for key in total}
                lost = 0
                for lie, used in splits(len(positions)):
                    try:
                        for load, more in enumerate(scores(drawn, fit, readings, positions, used)):
                            z[load, lie] += more
                    except ss.errors.ConvergenceError:
                        lost += 1
                label = f"{skin}, {kind}{', nu' if 'poisson' in fit else ''}"
                rows += [[name, label, *cells(z, load), str(lost)] for load in (0, 1)]
                for key, more in z.items():
                    total[key] += more
                print(*rows[-2], sep=" | ", flush=True)
                print(*rows[-1], sep=" | ", flush=True)
    return rows + [["all", "all", *cells(total, load), ""] for load in (0, 1)]


def cells(z: dict[tuple[int, str], list], load: int) -> list[str]:
    """Loads, then share before, share held and presses, of those between presses and of those in gaps."""
    out = [("straight", "leaning")[load]]
    for lie in ("between", "gap"):
        before, after = share(z[load, lie])
        out += [f"{before:.0f}", f"{after:.0f}", str(len(z[load, lie]))]
    return out


def one_skin(data: Path) -> list[list[str]]:
    """Rows of the second table: the three recordings of one row of barometers."""
    rows = []
    for kind, fit in (("strain", BASE), ("strain", BASE[:4]), ("stress", BASE[:4])):
        drawn = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(4, 6e-3, 5e-3, transducer=KINDS[kind], noise=NOISE))
        first = None
        for name in AIR:
            positions, readings, _ = recording(data, name)
            found = ss.calibrate(drawn, readings, positions, fit=fit)
            depth = next(p for p in found.parameters if p.name == "depth")
            first = first or depth
            apart = abs(depth.value - first.value) / np.hypot(depth.std, first.std)
            rows.append([
                name, f"half plane, {kind}", ", ".join(fit), str(len(positions)),
                f"{1e3 * depth.value:.2f} ± {1e3 * depth.std:.2f}", f"{apart:.1f}" if depth is not first else "",
            ])  # fmt: skip
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, data=DATA, recordings="full,day," + ",".join(COLUMNS), skins="half plane")
    warnings.simplefilter("ignore", ss.errors.ValidityWarning)
    head = ["recording", "finger", "numbers fitted", "presses", "depth [mm]", "standard errors from the first"]
    show("The depth of one row of sensors, by three recordings", head, one_skin(options.data), options.json)
    rows = held(options.data, options.recordings.split(","), options.skins.split(","))
    head = ["recording", "finger", "loads", "between: before %", "held %", "presses"]
    head += ["in gaps: before %", "held in gaps %", "presses in gaps", "refused"]
    show("95 % intervals of positions of presses held out", head, rows, options.json)


if __name__ == "__main__":
    main()
