"""What stands at the top, what stands in the rooms, and that each is found."""

from __future__ import annotations

import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

import subskin as ss

SOURCE = Path(ss.__file__).parent
LAZY = [import_module(".".join(("subskin", *p.parent.relative_to(SOURCE).parts))) for p in SOURCE.rglob("__init__.pyi")]
EDGE = {"cli", "__main__", "__init__"}  # what is no room for programs


def by_name(package: ModuleType) -> str:
    return package.__name__


def folders(package: ModuleType) -> set[str]:
    """Names of the modules and packages in a package that are not private."""
    inside = Path(package.__file__).parent.iterdir()
    names = {path.stem for path in inside if path.suffix == ".py" or (path / "__init__.py").is_file()}
    return {name for name in names if not name.startswith("_")}


def rooms(package: ModuleType) -> list[ModuleType]:
    return [getattr(package, name) for name in sorted(folders(package) - EDGE)]


def lost_names() -> list[tuple[ModuleType, str]]:
    """(package, name) for names of a room that the package does not have itself."""
    return [
        (package, name)
        for package in (ss, ss.design)
        for room in rooms(package)
        for name in getattr(room, "__all__", ())
        if name not in package.__all__ and name not in folders(package)
    ]


def test_there_are_few_enough_to_be_learned():
    """46 of a finger under long contacts, and 10 more for touches on an area: a skin, a base, and eight contacts."""
    assert 30 <= len(ss.__all__) <= 56
    assert 15 <= len(ss.design.__all__) <= 25


@pytest.mark.parametrize("package", LAZY, ids=by_name)
def test_what_is_listed_loads(package):
    assert len(set(package.__all__)) == len(package.__all__)
    assert dir(package) == sorted(package.__all__)
    for name in package.__all__:
        assert getattr(package, name) is getattr(package, name)


@pytest.mark.parametrize("package", [ss, ss.design], ids=by_name)
def test_every_room_is_reached_from_the_package(package):
    for name in folders(package) - EDGE:  # asked of the stub: that it is loaded already would hide its absence
        assert package.__getattr__(name) is import_module(f"{package.__name__}.{name}")


@pytest.mark.parametrize("package", LAZY, ids=by_name)
def test_no_name_is_hidden_by_a_file(package):
    """Importing `package.name` would put the module in the place of the function of that name."""
    objects = {name for name in package.__all__ if not isinstance(getattr(package, name), ModuleType)}
    assert objects & folders(package) == set()


def test_a_name_in_a_room_is_told_where_it_is():
    lost = lost_names()
    assert len(lost) > 100
    with pytest.raises(AttributeError, match=r"'Cylinder'.*Fix: subskin\.pressing\.Cylinder$"):
        ss.Cylinder  # noqa: B018
    for package, name in lost:
        with pytest.raises(AttributeError) as caught:
            getattr(package, name)
        parts = str(caught.value).partition("Fix: ")[2].split(".")
        home = import_module(".".join(parts[:-1]))
        assert parts[-1] == name
        assert name in home.__all__


@pytest.mark.parametrize("name", ["nonsense", "__wrapped__", "_lazy_", "HalfPlan"])
def test_a_name_that_is_nowhere_is_an_attribute_error(name):
    assert not hasattr(ss, name)
    with pytest.raises(AttributeError, match=rf"'subskin' has no attribute '{name}'$"):
        getattr(ss, name)


def test_a_star_brings_the_public_names_alone():
    space = {}
    exec("from subskin import *", space)
    assert set(space) - {"__builtins__"} == set(ss.__all__)


@pytest.mark.parametrize(
    "first",
    ["import subskin.finger", "from subskin.finger import Finger", "import subskin.array, subskin.pressing.press"],
)
def test_a_name_is_the_same_by_every_way(first):
    code = (
        f"{first}\nimport subskin as ss, subskin.finger, subskin.pressing\n"
        "assert ss.Finger is subskin.finger.Finger and isinstance(ss.Finger, type)\n"
        "assert ss.press is subskin.pressing.press and not hasattr(ss.press, '__path__')"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_comes_from_a_lazy_name_pickles():
    for value in (ss.Finger, ss.design.Goals, ss.press, ss.Material(young=0.4e6)):
        assert pickle.loads(pickle.dumps(value)) == value
