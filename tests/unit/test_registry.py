"""A contact or a transducer of one's own is found by its name, wherever names are taken."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import subskin as ss
from subskin.cli.main import main
from subskin.contact import Contact, Hertz, contact_of, families, family_of
from subskin.errors import FileError, InvalidValueError
from subskin.io.finger_file import parse_finger
from subskin.transducer import Transducer, kind_of, kinds, transducer_of

FILE = '[skin]\nyoung = "0.4 MPa"\n[sensors]\ncount = 6\npitch = "1 mm"\ndepth = "2 mm"\nnoise = 1e-5\nkind = {}\n'


@pytest.fixture(autouse=True)
def names(monkeypatch):
    """What a test registers is gone after it."""
    for root in (Contact, Transducer):
        monkeypatch.setattr(root, "_by_name", dict(root._by_name))


@pytest.fixture
def round_tip():
    class RoundTip(Hertz, name="round_tip"):
        """A Hertz contact under another name."""

    return RoundTip


def test_a_contact_of_ones_own_is_fitted_decided_and_simulated_by_name(round_tip, tmp_path, capsys):
    assert families()["round_tip"] is round_tip is family_of("round_tip")
    assert type(contact_of("round_tip", 1e-3)(force=40.0)) is round_tip
    tip = parse_finger(FILE.format('"normal_strain"')).finger
    reading = tip.read(ss.Hertz(40.0, 0.2, 0.3e-3, half_width=1.5e-3))
    assert float(tip.fit(reading, "round_tip").half_width) == pytest.approx(1.5e-3, rel=1e-3)
    said = ss.decide.contact_type(
        tip, reading, [ss.decide.Kind("tip", "round_tip", (1e-3, 2e-3)), ss.decide.Kind("knife", "line")]
    )
    assert str(said.name) == "tip"
    assert float(ss.decide.slip(tip.fit(reading), 0.8, contact="round_tip").stick) > 0.5
    finger, table = tmp_path / "finger.toml", tmp_path / "r.csv"
    finger.write_text(FILE.format('"normal_strain"'))
    load = ("--contact", "round_tip", "--half-width", "1.5 mm", "--count", "3", "--position", "0 mm")
    assert main(["simulate", str(finger), "-o", str(table), *load]) == 0
    assert main(["fit", str(finger), str(table), "--family", "round_tip", "--json"]) == 0
    assert '"family": "round_tip"' in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["fit", "--help"])
    assert "hertz,line,punch,round_tip" in capsys.readouterr().out


def test_a_new_contact_is_one_file(tmp_path):
    """A file that nothing imports by hand, put into a copy of the folder."""
    tree = tmp_path / "subskin"
    shutil.copytree(Path(ss.__file__).parent, tree, ignore=shutil.ignore_patterns("__pycache__"))
    new = "from .hertz import Hertz\n\n\nclass RoundTip(Hertz, name='round_tip'):\n    pass\n"
    (tree / "contact" / "round_tip.py").write_text(new)
    code = "from subskin.contact import families; print(*families())"
    env = {**os.environ, "PYTHONPATH": str(tmp_path)}
    ran = subprocess.run(
        [sys.executable, "-c", code], env=env, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert ran.stdout.split() == ["hertz", "line", "punch", "round_tip", "strip", "wedge"]


def test_a_class_without_a_name_is_none_of_them():
    assert ss.PartialSlip not in families().values()
    assert family_of(ss.PartialSlip) is ss.PartialSlip


def test_one_name_for_two_is_refused():
    with pytest.raises(InvalidValueError, match=r"contact\.hertz\.Hertz has that name"):

        class Other(Hertz, name="hertz"):
            pass


@dataclass(frozen=True)
class Tilt(Transducer):
    """A transducer that is named by its module."""

    unit = ""
    component = "strain.xy"

    def measure(self, state):
        return state.strain.xy - state.strain.xx


@dataclass(frozen=True)
class Needy(Tilt):
    angle: float


class Unfinished(Transducer):
    unit = ""


OWN = f"{__name__}:Tilt"
MAGNET = "magnet_displacement"  # it has no moment by itself


def test_a_transducer_of_ones_own_in_a_file():
    class Stretch(Tilt, name="stretch"):
        pass

    touch = ss.LineLoad(40.0, 0.3)
    for name, kind in (("stretch", Stretch), (OWN, Tilt), (OWN.replace(":", "."), Tilt)):
        finger = parse_finger(FILE.format(f'["normal_strain", {", ".join(5 * [repr(name)])}]')).finger
        assert finger.array.transducers[1:] == 5 * (kind(),)
        state = finger.skin.state(touch, 2e-3, np.asarray(finger.array.y)[1:])
        assert finger.read(touch)[1:] == pytest.approx(state.strain.xy - state.strain.xx, rel=1e-12)
    assert [kind_of(kind()) for kind in (Stretch, Tilt)] == ["stretch", OWN]
    assert [kind_of(kind()) for name, kind in kinds().items() if name != MAGNET] == [k for k in kinds() if k != MAGNET]
    assert kind_of(transducer_of(MAGNET, axis="y", moment=5e-3, gap=3e-3)) == MAGNET


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("normal_strian", 'did you mean "normal_strain"'),
        ("tilt", "known: normal_strain"),
        ("strain", "one of normal_strain (strain along the depth, eps_x), "),
        ("no_such_package.gauges:Tilt", "no_such_package.gauges cannot be imported (No module named"),
        (f"{__name__}:Slant", "has no Slant"),
        (f"{__name__}.Slant", "has no Slant"),
        ("numpy:pi", "it is no Transducer"),
        ("subskin.Material", "it is no Transducer"),
        (f"{__name__}:Unfinished", "it lacks measure"),
        (f"{__name__}:Needy", "it needs arguments"),
        (
            MAGNET,
            'kind = {name = "magnet_displacement", axis = ..., moment = ..., gap = ..., exact = ..., tilts = ...}',
        ),
    ],
)
def test_a_transducer_that_cannot_be_had_is_refused_with_its_line(name, said):
    with pytest.raises(InvalidValueError) as refused:
        transducer_of(name)
    assert said in str(refused.value)
    with pytest.raises(FileError) as refused:
        parse_finger(FILE.format(f'"{name}"'))
    assert said in str(refused.value)
    assert "line 8" in str(refused.value)


def test_a_module_that_fails_when_imported(tmp_path, monkeypatch):
    (tmp_path / "broken_gauge.py").write_text("1 / 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InvalidValueError, match=r"broken_gauge cannot be imported \(division by zero\)"):
        transducer_of("broken_gauge:Tilt")
