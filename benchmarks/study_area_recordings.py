"""Calibrating on an area, on recordings of real skins: from few touches at known positions, all the others located.

    python benchmarks/study_area_recordings.py [--data FOLDER] [--draws 8] [--first 0] [--json FILE]

FOLDER (../shared/data) holds the recordings, which do not ship with this package. A recording that is absent is left
out, and so are the learned peers where scikit-learn is (`pip install subskin[bench]`).

underwater/: eight barometers in a grid of 2 x 4 under silicone, pressed with one force at every half millimetre. The
touched rectangle is cut into 4 x 4 cells, and in the middle half of each one touch is drawn; these 16 calibrate, all
others are located as straight loads. The finger is drawn as a half space with sensors of strain along the depth,
which fits both boards best of the fields with one depth alone. Cells: medians over the draws. R^2 is the least
sensor's, with all readings and without those that lie more than 15 % of the sensor's range off the median of their
eight neighbours (1 of 22 400 and 6 of 27 104: a reading lost). "inside" is the rectangle of the sensors. A touch is
wrong where it is OK, more than 2 mm off, and by more than three of its own standard errors along y or z. "held"
counts the 95 % intervals, along y and along z, of OK answers inside.

A second table calibrates by 4, 8 and 16 touches, one in the middle half of each of 2 x 2, 2 x 4 and 4 x 4 cells, and
locates every fifth of the others. There an answer is wrong where it is OK and more than 2 mm or five of its standard
errors off. Cells: means over the draws, of all frames inside or beyond the rectangle of the sensors as drawn about the
middle of the touched one. "called weak": sensors a draw that are said to be weak or dead; all eight work.

The same boards are calibrated blind: of 100 touches drawn within the rectangle of the sensors the positions are hidden
(`calibrate_blind`, straight loads; gains alike to 20 %, depth to 20 %, positions to 2 % of it). Positions of all
touches within are found up to a shift and a turn, which are taken out, and on a half space up to a scale, which is
told: "scale" is the spread of the touches over that of the positions found. Beside it `calibrate` with the same 100
touches at their positions, by the field alone, its positions treated alike. "held" is as above, with the scale left in
and taken out; "gains" is the rms difference of the blind gains to the known ones, each over its own mean; "force" the
spread of the forces found over their mean, which with one load is an error. Medians over draws.

eflesh/spatial_20250317/: five magnetometers of three axes beneath magnets in a printed lattice, 480 positions, five
touches each. The table is made of every second position, and each touch at the others is located by itself; then the
mean of the five is.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.estimate.area import InPlaceLocator
from subskin.measured import MeasuredResponse

PSI = 6894.757  # Pa
BOARDS = {
    "2 x 4, pitch 6.75 mm": ("DS10_atm_6.75_10_samples_cast-bond_trial1.csv", 1, 6.75e-3),
    "2 x 4, pitch 9.9 mm": ("DS20_25PSI_9.9_10_samples_cast-bond_trial1.csv", 0, 9.9e-3),
}
FIT = ("gain", "depth", "origin", "turn")
NOISE, DEPTH = 20.0, 6e-3  # Pa: 0.003 PSI, the steps of the readings at rest; m, of a skin 8 mm thick
CELLS, LOST = 4, 0.15
BLIND = 100
DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def board(data: Path, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions (m, 2) [m], readings (m, 8) [Pa], and which of these are no lost reading."""
    from scipy.spatial import KDTree

    file, header, _ = BOARDS[name]
    raw = np.loadtxt(data / "underwater" / file, delimiter=",", skiprows=header)
    at, readings = 1e-3 * raw[:, :2], PSI * raw[:, 2:]
    near = KDTree(at).query(at, k=9)[1][:, 1:]
    return at, readings, np.abs(readings - np.median(readings[near], axis=1)) < LOST * readings.max(axis=0)


def drawn(name: str) -> ss.Finger:
    """The board as drawn: s0 to s3 up the right column, s4 to s7 down the left one."""
    pitch = BOARDS[name][2]
    y = pitch * np.repeat([0.5, -0.5], 4)
    z = pitch * np.array([-1.5, -0.5, 0.5, 1.5, 1.5, 0.5, -0.5, -1.5])
    array = ss.SensorArray(y=y, z=z, depth=DEPTH, transducer=ss.NormalStrain(), noise=NOISE)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.3e6)), array)


def spread_out(at: np.ndarray, rng: np.random.Generator, sides: tuple[int, int] = (CELLS, CELLS)) -> np.ndarray:
    """One touch in the middle half of each of so many cells; of two unlike sides the longer has more."""
    low, size = at.min(axis=0), np.ptp(at, axis=0)
    many = np.array(sides if size[0] <= size[1] else sides[::-1])
    cells = np.stack(np.meshgrid(*[np.arange(k) for k in many], indexing="ij"), axis=-1).reshape(-1, 2)
    chosen = low + (cells + rng.uniform(0.25, 0.75, cells.shape)) / many * size
    return np.argmin(((at - chosen[:, None]) ** 2).sum(axis=-1), axis=1)


def learned() -> dict[str, Callable[[], object]]:
    """Peers that learn positions from readings, each made anew; none without scikit-learn."""
    try:
        from sklearn.compose import TransformedTargetRegressor
        from sklearn.gaussian_process import GaussianProcessRegressor, kernels
        from sklearn.linear_model import RidgeCV
        from sklearn.neighbors import KNeighborsRegressor
        from sklearn.neural_network import MLPRegressor
        from sklearn.pipeline import make_pipeline
        from sklearn.preprocessing import PolynomialFeatures, StandardScaler
    except ImportError:
        return {}
    kernel = kernels.ConstantKernel() * kernels.RBF(3.0, (0.1, 100.0)) + kernels.WhiteKernel(1e-2)
    steps = np.logspace(-4, 4, 17)
    settings = {"hidden_layer_sizes": (64, 64), "max_iter": 3000, "random_state": 0, "alpha": 1e-3}
    return {
        "neural network": lambda: make_pipeline(StandardScaler(), MLPRegressor(**settings)),
        "neural network, targets scaled": lambda: TransformedTargetRegressor(
            make_pipeline(StandardScaler(), MLPRegressor(**settings)), transformer=StandardScaler()
        ),
        "Gaussian process": lambda: make_pipeline(
            StandardScaler(), GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=2)
        ),
        "nearest neighbours": lambda: make_pipeline(StandardScaler(), KNeighborsRegressor(3, weights="distance")),
        "ridge": lambda: make_pipeline(StandardScaler(), RidgeCV(steps)),
        "ridge, squares too": lambda: make_pipeline(StandardScaler(), PolynomialFeatures(2), RidgeCV(steps)),
    }


def r2(model: np.ndarray, readings: np.ndarray, kept: np.ndarray) -> float:
    """The least sensor's, of the readings `kept`."""
    return min(1 - np.mean((m - r)[k] ** 2) / np.var(r[k]) for m, r, k in zip(model.T, readings.T, kept.T, strict=True))


def ours(name: str, at: np.ndarray, readings: np.ndarray, kept: np.ndarray, used: np.ndarray) -> list[float]:
    """Numbers of one draw, in the order of the table; `calibrate` may refuse, which is NaN."""
    rest = np.setdiff1d(np.arange(len(at)), used)
    found = ss.calibrate(drawn(name), readings[used], at[used], fit=FIT)
    truth, points = found.on_finger(at[rest]), found.finger.array.points
    inside = ((truth >= points.min(axis=0)) & (truth <= points.max(axis=0))).all(axis=1)
    located = found.finger.locate(readings[rest], friction=0)
    off = located.position - truth
    far, ok = np.linalg.norm(off, axis=1), located.status == ss.Status.OK
    std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[:, :2])
    wrong = ok & (far > 2e-3) & (np.abs(off) > 3 * std).any(axis=1)
    both, measured = ok & inside, found.finger.measured
    model = (measured or found.finger.receptive_field)(truth)[..., 0]
    return [
        r2(model, readings[rest], np.ones_like(kept[rest])),
        r2(model, readings[rest], kept[rest]),
        *(1e3 * np.nanquantile(far[inside], [0.5, 0.95])),
        100 * both.sum() / inside.sum(),
        *(1e3 * np.quantile(far[both], [0.5, 0.95])),
        100 * wrong[inside].mean(),
        100 * wrong.mean(),
        100 * np.mean(np.abs(off[both]) <= 1.959964 * std[both]),
    ]


def theirs(
    make: Callable[[], object], at: np.ndarray, readings: np.ndarray, used: np.ndarray, name: str
) -> list[float]:
    """Median and 95 % of the errors inside of a learned peer [mm]."""
    rest = np.setdiff1d(np.arange(len(at)), used)
    peer = make().fit(readings[used], 1e3 * at[used])
    far = np.linalg.norm(peer.predict(readings[rest]) - 1e3 * at[rest], axis=1)
    pitch = 1e3 * BOARDS[name][2]
    middle = 1e3 * (at.min(axis=0) + at.max(axis=0)) / 2
    inside = (np.abs(1e3 * at[rest] - middle) < [0.5 * pitch, 1.5 * pitch]).all(axis=1)
    return [*np.quantile(far[inside], [0.5, 0.95])]


def barometers(data: Path, draws: int, first: int) -> list[list[str]]:
    """Rows of the first table."""
    rows = []
    for name in BOARDS:
        at, readings, kept = board(data, name)
        chosen = [spread_out(at, np.random.default_rng(seed)) for seed in range(first, first + draws)]
        each = np.array([ours(name, at, readings, kept, used) for used in chosen])
        for label, numbers in (("subskin", np.median(each, axis=0)), ("subskin, worst draw", worst(each))):
            form = ("{:.3f}", "{:.3f}", "{:.2f}", "{:.2f}", "{:.0f}", "{:.2f}", "{:.2f}", "{:.1f}", "{:.1f}", "{:.0f}")
            rows.append([name, label, *(f.format(x) for f, x in zip(form, numbers, strict=True))])
        for label, make in learned().items():
            numbers = np.median([theirs(make, at, readings, used, name) for used in chosen], axis=0)
            rows.append([name, label, "", "", *(f"{x:.2f}" for x in numbers), *[""] * 6])
    return rows


def few(data: Path, draws: int, first: int) -> list[list[str]]:
    """Rows of the table of calibrations on few touches."""
    rows = []
    for name, (_, _, pitch) in BOARDS.items():
        at, readings, _ = board(data, name)
        middle = (at.min(axis=0) + at.max(axis=0)) / 2
        for sides in ((2, 2), (2, 4), (4, 4)):
            numbers = []
            for seed in range(first, first + draws):
                used = spread_out(at, np.random.default_rng(seed), sides)
                rest = np.setdiff1d(np.arange(len(at)), used)[seed % 5 :: 5]
                found = ss.calibrate(drawn(name), readings[used], at[used], fit=FIT)
                located, inside = found.finger.locate(readings[rest], friction=0), np.abs(at[rest] - middle)
                inside = (inside < [0.5 * pitch, 1.5 * pitch]).all(axis=1)
                off, ok = located.position - found.on_finger(at[rest]), located.ok
                std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[:, :2])
                far, held = np.linalg.norm(off, axis=1), np.abs(off) <= 1.959964 * std
                wrong = ok & ((far > 2e-3) | (np.abs(off) > 5 * std).any(axis=1))
                numbers.append([found.weak.sum(), 1e3 * np.median(far[ok & inside])])
                for part in (inside, ~inside):
                    numbers[-1] += [100 * ok[part].mean(), 100 * wrong[part].mean()]
                    numbers[-1] += [100 * held[ok & part].mean() if (ok & part).any() else np.nan]
            means, digits = np.nanmean(numbers, axis=0), (2, 2, 0, 2, 0, 0, 2, 0)
            rows.append([name, str(sides[0] * sides[1]), *(f"{x:.{k}f}" for x, k in zip(means, digits, strict=True))])
    return rows


def aligned(found: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Positions found, turned and shifted onto the truth by least squares; the scale beside it; and the turn."""
    a, b = found - found.mean(axis=0), truth - truth.mean(axis=0)
    left, size, right = np.linalg.svd(a.T @ b)
    signs = np.array([1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * signs) @ right
    return a @ turn + truth.mean(axis=0), float((size * signs).sum() / (a**2).sum()), turn


def blind(name: str, at: np.ndarray, readings: np.ndarray, fit: tuple[str, ...], seed: int) -> np.ndarray:
    """Numbers of one draw, blind and with positions known, (2, 12)."""
    pitch, middle = BOARDS[name][2], (at.min(axis=0) + at.max(axis=0)) / 2
    inside = np.flatnonzero((np.abs(at - middle) < [0.5 * pitch, 1.5 * pitch]).all(axis=1))
    rows = np.random.default_rng(seed).choice(inside, BLIND, replace=False)
    finger = drawn(name)
    felt = finger.receptive_field(finger.array.points)[..., 0].diagonal()  # of 1 N straight above
    gain = float(np.median(readings.max(axis=0) / felt))
    finger = ss.Finger(finger.skin, replace(finger.array, gain=gain))
    errors = {"gain_error": 0.2, "depth_error": 0.2, "position_error": 0.02}
    begin = time.process_time()
    found = ss.calibrate_blind(finger, readings[rows], fit=fit, friction=0, **errors)
    took = time.process_time() - begin
    known = ss.calibrate(drawn(name), readings[rows], at[rows], fit=FIT)
    out = []
    own = np.asarray(known.finger.array.gain) / np.mean(known.finger.array.gain)
    for made in (found, known):
        calibrated = made.finger if made is found else replace(made.finger, measured=None)
        located = calibrated.locate(readings[inside], friction=0)
        ok = located.status == ss.Status.OK
        placed, scale, turn = aligned(located.position[ok], at[inside][ok])
        off = placed - at[inside][ok]
        sized = scale * (placed - placed.mean(axis=0)) + placed.mean(axis=0) - at[inside][ok]
        far = 1e3 * np.linalg.norm(off, axis=1)
        covariance = turn.T @ located.load.covariance[ok][:, :2, :2] @ turn
        std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        gains = np.asarray(calibrated.array.gain) / np.mean(calibrated.array.gain)
        force = located.force[ok]
        out.append([
            100 * found.used.mean() if made is found else 100.0,
            found.misfit if made is found else np.nan,
            1e3 * np.mean(calibrated.array.depth),
            scale,
            np.sqrt(np.mean((gains - own) ** 2)),
            100 * ok.mean(),
            np.median(far),
            np.median(1e3 * np.linalg.norm(sized, axis=1)),
            100 * np.mean(np.abs(off) <= 1.959964 * std),
            100 * np.mean(np.abs(sized) <= 1.959964 * std),
            force.std() / force.mean(),
            took if made is found else np.nan,
        ])  # fmt: skip
    return np.array(out)


def blind_rows(data: Path, draws: int) -> list[list[str]]:
    """Rows of the table of blind calibrations."""
    rows = []
    digits = (0, 1, 2, 3, 3, 0, 2, 2, 0, 0, 3, 1)
    for name in BOARDS:
        at, readings, _ = board(data, name)
        for fit in (("gain", "depth"), ("gain", "depth", "position")):
            each = np.median([blind(name, at, readings, fit, seed) for seed in range(draws)], axis=0)
            for label, numbers in zip(("blind: " + ", ".join(fit), "positions known"), each, strict=True):
                told = ("" if np.isnan(x) else f"{x:.{k}f}" for k, x in zip(digits, numbers, strict=True))
                rows.append([name, label, *told])
    return rows


def worst(each: np.ndarray) -> np.ndarray:
    """Of each number, over draws, the worse end: least of R^2, of what is OK and of what is held, else largest."""
    least = [0, 1, 4, 9]
    out = each.max(axis=0)
    out[least] = each.min(axis=0)[least]
    return out


def of_touches(readings: np.ndarray, at: np.ndarray) -> InPlaceLocator:
    """The locator by a table of these touches alone, which carry the same force to a tenth."""
    return InPlaceLocator(MeasuredResponse.from_touches(readings, at), friction=0, normal_force=(0.9, 1.1))


def errors(located: ss.Estimate, at: np.ndarray) -> tuple[str, ...]:
    """OK [%]; of OK answers the median and 95 % of the errors [mm], and how many 95 % intervals hold [%]."""
    off, ok = located.position - at, located.status == ss.Status.OK
    far = 1e3 * np.linalg.norm(off[ok], axis=1)
    std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[ok, :2])
    held = 100 * np.mean(np.abs(off[ok]) <= 1.959964 * std)
    return f"{100 * ok.mean():.0f}", f"{np.median(far):.2f}", f"{np.quantile(far, 0.95):.2f}", f"{held:.0f}"


def bounds(readings: np.ndarray, at: np.ndarray, place: np.ndarray) -> list[list[str]]:
    """Rows of what tables of nearly all positions, and of all, do."""
    tenth = np.random.default_rng(0).permutation(place.max() + 1) % 10
    parts, order = [], []
    for k in range(10):
        out = tenth[place] == k
        parts.append(of_touches(readings[~out], at[~out])(readings[out]))
        order.append(at[out])
    ok = np.concatenate([part.ok for part in parts])
    far = 1e3 * np.concatenate([np.linalg.norm(p.position - a, axis=1) for p, a in zip(parts, order, strict=True)])[ok]
    numbers = (f"{100 * ok.mean():.0f}", f"{np.median(far):.2f}", f"{np.quantile(far, 0.95):.2f}", "", "")
    among = errors(of_touches(readings, at)(readings), at)
    return [["nine tenths of the positions", "subskin, OK", *numbers], ["all positions", "subskin, OK", *among, ""]]


def lattice(data: Path) -> list[list[str]]:
    """Rows of the second table."""
    raw = np.loadtxt(data / "eflesh" / "spatial_20250317" / "touches.csv", delimiter=",", skiprows=1)
    at, readings = 1e-3 * np.round(raw[:, 1:3], 2), raw[:, 4:]
    at -= at.mean(axis=0)
    row = np.round(1e3 * (at - at.min(axis=0))).astype(int)
    rows = []
    splits = {"every second row": row[:, 0] % 2 == 0, "a checkerboard": (row.sum(axis=1) // 2) % 2 == 0}
    for split, used in splits.items():
        begin = time.perf_counter()
        locator = of_touches(readings[used], at[used])
        located = locator(readings[~used])
        took = time.perf_counter() - begin
        rows.append([split, "subskin, OK", *errors(located, at[~used]), f"{took:.1f}"])
        place = np.unique(row[~used], axis=0, return_inverse=True)[1].reshape(-1)
        every = range(place.max() + 1)
        means, there = (np.stack([x[~used][place == k].mean(axis=0) for k in every]) for x in (readings, at))
        located = locator(means)
        far = 1e3 * np.linalg.norm(located.position - there, axis=1)[located.ok]
        numbers = (f"{100 * located.ok.mean():.0f}", f"{np.median(far):.2f}", f"{np.quantile(far, 0.95):.2f}", "", "")
        rows.append([split, "the same, five touches averaged", *numbers])
        for label, make in learned().items():
            peer = make().fit(readings[used], 1e3 * at[used]) if label != "Gaussian process" else None
            if peer is not None:
                numbers = np.linalg.norm(peer.predict(readings[~used]) - 1e3 * at[~used], axis=1)
                rows.append([split, label, "", *(f"{x:.2f}" for x in np.quantile(numbers, [0.5, 0.95])), "", ""])
    return [*rows, *bounds(readings, at, np.unique(row, axis=0, return_inverse=True)[1].reshape(-1))]


def main() -> None:
    """Print both tables."""
    options = arguments(__doc__, data=DATA, draws=8, first=0)
    heads = ["board", "by", "R^2", "R^2, none lost", "inside: median [mm]", "95 % [mm]", "OK [%]", "OK: median [mm]"]
    heads += ["OK: 95 % [mm]", "wrong, inside [%]", "wrong [%]", "held [%]"]
    if (options.data / "underwater").is_dir():
        rows = barometers(options.data, options.draws, options.first)
        show("16 touches at known positions, all others located", heads, rows, options.json)
        more = ["board", "touches", "called weak", "median [mm]", "inside: OK [%]", "wrong [%]", "held [%]"]
        more += ["beyond: OK [%]", "wrong [%]", "held [%]"]
        show("Few touches at known positions", more, few(options.data, options.draws, options.first), options.json)
        more = ["board", "by", "used [%]", "misfit", "depth [mm]", "scale", "gains", "OK [%]", "median [mm]"]
        more += ["scaled: median [mm]", "held [%]", "scaled: held [%]", "force", "time [s]"]
        show("100 touches within the sensors", more, blind_rows(options.data, options.draws), options.json)
    if (options.data / "eflesh" / "spatial_20250317").is_dir():
        more = ["the table is of", "by", "OK [%]", "median [mm]", "95 % [mm]", "held [%]", "time [s]"]
        show("Every second position, the others located", more, lattice(options.data), options.json)


if __name__ == "__main__":
    main()
