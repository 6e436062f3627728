"""Compile the loops before the tests start, on two cores: `make test` does, while pip installs what tests need.

Each worker of pytest and the gallery of the docs would else compile the same loops at the same time. A loop that is
missing here is compiled by the first test that needs it.
"""

from __future__ import annotations

from collections.abc import Callable
from multiprocessing import get_context

import numpy as np

import subskin as ss
from subskin._cold import at_once
from subskin.estimate.area import InPlaceLocator
from subskin.measured import MeasuredResponse


def finger(count: int = 6, pitch: float = 1e-3) -> ss.Finger:
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    return ss.Finger(skin, ss.SensorArray.line(count=count, pitch=pitch, depth=2e-3, noise=2e-5))


def a_kind_of_each() -> None:
    tip = finger()
    frame = tip.read(ss.Hertz(force=30.0, half_width=1.5e-3))
    ss.decide.contact_type(tip, frame)


def wide() -> None:  # and the plain fit, which this one calls
    tip = finger()
    tip.fit(tip.read(ss.Hertz(force=[30.0, 20.0], half_width=1.5e-3)), stick=0.6)


def pad() -> ss.Finger:
    array = ss.SensorArray.grid(shape=(3, 3), pitch=1.5e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=10.0)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)


def area() -> None:
    tip = pad()
    ss.decide.slip(tip.locate(tip.read(ss.PointLoad(force=[1.0, 2.0]))), ss.decide.Friction.between(0.4, 0.6))


def settled_on_area() -> None:
    tip = pad()
    told = ss.Finger(tip.skin, tip.array, tolerances=ss.Tolerances(gain=0.02, depth=0.05, poisson=0.05))
    told.locate(tip.read(ss.PointLoad(force=[1.0, 2.0])))


def several_on_area() -> None:
    tip = pad()
    tip.locate(tip.read(ss.PointLoad(force=[1.0, 2.0])), touches=2)


def settled_on_row() -> None:
    drawn = finger()
    told = ss.Finger(drawn.skin, drawn.array, tolerances=ss.Tolerances(gain=0.02, depth=0.05, poisson=0.05))
    told.locate(drawn.read(ss.LineLoad(force=[20.0, 40.0])))


def round_on_area() -> None:
    tip = pad()
    tip.fit(tip.read(ss.RoundHertz(force=[1.0, 2.0], half_width=1e-3)), "round_hertz")
    ss.decide.contact_type(tip, tip.read(ss.PointLoad(force=[1.0, 2.0])))


def patches() -> None:
    tip = pad()
    tip.fit(tip.read(ss.Patch(force=[1.0, 2.0], half_widths=(1e-3, 1.5e-3))), "patch")


def in_place() -> None:
    tip = pad()
    lines = np.linspace(-2e-3, 2e-3, 4)
    at = np.stack(np.meshgrid(lines, lines), axis=-1).reshape(-1, 2)
    touches = tip.read(ss.PointLoad(2.0, position=at), np.random.default_rng(0))
    InPlaceLocator(MeasuredResponse.from_touches(touches, at), friction=0)(touches[:2])


def line() -> None:
    tip = finger()
    ss.decide.slip(tip.locate(tip.read(ss.LineLoad(force=[30.0, 20.0]))), ss.decide.Friction.between(0.4, 0.6))


def doubted() -> None:
    tip = finger()
    frames = tip.read(ss.LineLoad(force=[30.0, 20.0]))
    tip.locate(frames, doubt=np.full(frames.shape, 1e-4))
    frames = tip.read(ss.Hertz(force=[30.0, 20.0], half_width=1.5e-3))
    tip.locator("hertz")(frames, doubt=np.full(frames.shape, 1e-4))


def placement() -> None:
    skin, touches = ss.HalfPlane(ss.Material(young=0.4e6)), ss.design.Touches(force=40.0)
    kind = ss.design.placement.Channel(ss.NormalStrain(), noise=5e-5)
    ss.design.placement.study_at_depth(skin, kind, 2e-3, [1e-3, 2e-3], [4], touches, samples=200)
    ss.design.placement_quality(finger(), touches)


def placement_on_area() -> None:
    touches = ss.design.Touches(force=1.0, area=((-1e-3, 1e-3), (-1e-3, 1e-3)))
    ss.design.placement_quality(pad(), touches, grid=(3, 2))


def pressure() -> None:
    tip = finger(25, 0.5e-3)
    frames = tip.read(ss.Hertz(force=[40.0, 30.0], half_width=2e-3), rng=np.random.default_rng(0))
    for shear in ("none", "proportional"):
        ss.pressure_map(tip, frames, shear=shear)


def image() -> None:
    tip = pad()
    ss.pressure_map(tip, tip.read(ss.RoundHertz(force=[1.0, 2.0], half_width=1e-3)))


def image_of_a_free_drag() -> None:
    moves = [ss.transducer.Displacement(axis) for axis in "xyz"]
    array = ss.SensorArray.grid(shape=(4, 4), pitch=1.5e-3, depth=2e-3, channels=moves, noise=1e-7)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    ss.pressure_map(tip, tip.read(ss.RoundHertz(force=[1.0, 2.0], half_width=1e-3)), shear="free")


def pressing() -> None:
    ss.press(ss.HalfPlane(ss.Material(young=0.4e6)), ss.pressing.Cylinder(radius=10e-3), force=20.0)


def pressing_on_area() -> None:
    half, ball = ss.HalfSpace(ss.Material(young=0.4e6)), ss.pressing.Sphere(radius=8e-3)
    for drag in ((0.05, 0.02), (0.05, 0.0)):  # on the whole grid, and on a quarter of it
        ss.press(half, ball, force=0.3, friction=0.5, tangential=drag, nodes=64)


def streams() -> None:
    tip, time = finger(), np.arange(0.0, 4.0, 0.01)
    raw = tip.read(ss.LineLoad(40.0 * (time > 2.0)), np.random.default_rng(0))
    ss.Tare(tip, drift=2e-5)(raw, time)
    rubber = ss.stream.Relaxation(share=[0.1, 0.05], time=[0.5, 5.0])
    rubber.undo(rubber.apply(raw, time), time)


JOBS = (  # longest first
    *(image, image_of_a_free_drag, a_kind_of_each, round_on_area, patches, in_place, pressing_on_area),
    *(
        area,
        settled_on_area,
        several_on_area,
        settled_on_row,
        line,
        doubted,
        placement,
        pressure,
        placement_on_area,
        pressing,
        streams,
    ),
)


def run(job: Callable[[], None]) -> None:
    job()


if __name__ == "__main__":
    with at_once():
        wide()  # first, by itself: the others are built on much of it, and need not compile it twice
        with get_context("fork").Pool(2) as pool:
            pool.map(run, JOBS, chunksize=1)
