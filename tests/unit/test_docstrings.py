"""Every public docstring says all that a caller needs: parameters, units, shapes, errors, an example, the source.

A method may leave a parameter to the function that its text names in backticks; so may a class its errors.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from functools import cached_property
from importlib import import_module
from pathlib import Path

import pytest
from numpydoc.docscrape import NumpyDocString

import subskin

ROOT = Path(subskin.__file__).parent
EDGE = {"cli", "__main__"}
NUMBER = re.compile(r"\b(float|array_like|ndarray|FloatArray)\b")
COUNTED = re.compile(r"\b(bool|of int|of str)\b")
UNIT = re.compile(r"\[[^\[\]]+\]")
PURE = re.compile(  # what has no unit, in words
    r"\[-\]|\b(shares?|ratios?|factors?|probabilit\w+|chances?|number|numbers|counts?|levels?|parts?|gains?|"
    r"chi-square|sigmas?|standard deviations|quantiles?|percentiles?|poisson|friction|mu|nu|units?|as in|of shape|"
    r"multiples?|times|columns?|rows?|index|indices|scores?|weights?|odds|in order|relative)\b",
    re.IGNORECASE,
)
SHAPE = re.compile(r"\bshapes?\b|\(\.\.\.|scalars?\b|one for (all|each)|\bfor each\b|\beach\b|as in `", re.IGNORECASE)
FORMULA = re.compile(r"[\w)\]] = [^=\n]*[\w)]\s*(\*\*|\^|/|\bsqrt|\bexp|\blog)")
SOURCE = re.compile(
    r"eq\. ?\(|Equation \(\d|eqs\. ?\(|\bmemo\b|\b(18|19|20)\d\d\b|section \d|Fig\. \d|docs/|chapter|\bby definition\b"
)
WORD = re.compile(r"\w+")
NAMED = re.compile(r"`~?\.?([\w.]+)`")


@dataclass(frozen=True, eq=False)
class Public:
    """A public class, function, method or property, with its docstring taken to pieces."""

    name: str
    thing: object
    owner: type | None = None

    @cached_property
    def function(self):
        """What is called: of a class its constructor, of a property its getter."""
        thing = self.thing
        if isinstance(thing, property):
            return thing.fget
        if isinstance(thing, cached_property):
            return thing.func
        return getattr(thing, "__func__", thing)

    @cached_property
    def text(self):
        return inspect.cleandoc(self.function.__doc__ or "")

    @cached_property
    def parsed(self):
        return NumpyDocString(self.text)

    @cached_property
    def entries(self):
        """(names, all that is said of them) of what goes in and what the fields are."""
        return [
            ([name.strip(" *") for name in entry.name.split(",")], f"{entry.type} {' '.join(entry.desc)}")
            for section in ("Parameters", "Other Parameters", "Attributes")
            for entry in self.parsed[section]
        ]

    @cached_property
    def described(self):
        return {name for names, _ in self.entries for name in names} | set(NAMED.findall(self.text))

    @cached_property
    def parameters(self):
        if isinstance(self.thing, property | cached_property):
            return []
        if isinstance(self.thing, type):
            if issubclass(self.thing, Exception | Enum) or getattr(self.thing, "_is_protocol", False):
                return []
            if is_dataclass(self.thing):
                return [f.name for f in fields(self.thing) if f.init and not f.name.startswith("_")]
        try:
            signature = inspect.signature(self.function)
        except ValueError:
            return []
        return [name for name in signature.parameters if name not in {"self", "cls"} and name[0] != "_"]

    @cached_property
    def raises(self):
        """Errors that its own lines raise."""
        bodies = [self.function]
        if isinstance(self.thing, type):
            if issubclass(self.thing, Enum) or getattr(self.thing, "_is_protocol", False):
                return set()
            bodies = [vars(self.thing).get(name) for name in ("__init__", "__post_init__", "__new__")]
        found = set()
        for body in filter(inspect.isfunction, bodies):
            try:
                tree = ast.parse(textwrap.dedent(inspect.getsource(body)))
            except (OSError, SyntaxError):  # made by dataclass
                continue
            for node in ast.walk(tree):
                if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
                    found.add(ast.unparse(node.exc.func).split(".")[-1])
        return {name for name in found if name.endswith(("Error", "Exit"))} - {"AttributeError", "NotImplementedError"}


def rooms():
    """Rooms and packages within them; what these do not hand on is their own affair."""
    for path in sorted(ROOT.rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        if len(parts) > 1 and parts[-1] != "__init__":
            continue
        parts = parts[:-1] if parts[-1] == "__init__" else parts
        if not EDGE & set(parts) and not any(part.startswith("_") for part in parts):
            module = import_module(".".join(("subskin", *parts)))
            if hasattr(module, "__all__"):
                yield module


def public():
    found = {}
    for module in rooms():
        for name in module.__all__:
            thing = getattr(module, name)
            if not isinstance(thing, type) and not inspect.isfunction(thing):
                continue
            if not thing.__module__.startswith("subskin") or id(thing) in found:
                continue
            found[id(thing)] = Public(f"{thing.__module__}.{thing.__qualname__}", thing)
            if isinstance(thing, type):
                for member, value in vars(thing).items():
                    kind = property | cached_property | staticmethod | classmethod
                    if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, kind)):
                        method = Public(f"{thing.__module__}.{thing.__qualname__}.{member}", value, thing)
                        if not inherits(method):
                            found[id(value)] = method
    return list(found.values())


def inherits(method):
    """Whether a base has the same method, with a docstring that serves both."""
    name = method.name.rsplit(".", 1)[1]
    return not method.text and any(getattr(base, name, None) is not None for base in method.owner.__mro__[1:])


THINGS = public()
BY_NAME = {}
for one in THINGS:
    BY_NAME.setdefault(one.name.rsplit(".", 1)[1], []).append(one)


def helpers(one):
    """Public things that a docstring names in backticks, the class of a method, and itself."""
    named = [other for name in NAMED.findall(one.text) for other in BY_NAME.get(name.rsplit(".", 1)[-1], ())]
    owner = [other for other in THINGS if one.owner is not None and other.thing is one.owner]
    return [one, *owner, *named]


def returned(one):
    """Names of classes that a function with an example gives back; what those hold is shown with them."""
    return set(re.findall(r"\w+", str(getattr(one.function, "__annotations__", {}).get("return", ""))))


def parts(name):
    """Names of classes that the fields of a class hold, or that its methods give back."""
    kinds = [one.thing for one in BY_NAME.get(name, ()) if isinstance(one.thing, type)]
    notes = [note for kind in kinds for note in vars(kind).get("__annotations__", {}).values()]
    notes += [note for one in THINGS if one.owner in kinds for note in returned(one)]
    return {word for note in notes for word in WORD.findall(str(note))}


def filled_in(kind):
    """Whether a class only fills in what a base, which has an example, asks for."""
    own = {name for name in vars(kind) if not name.startswith("_")} if isinstance(kind, type) else {""}
    return any(">>>" in (base.__doc__ or "") and own <= set(dir(base)) for base in getattr(kind, "__mro__", ())[1:])


def built(one):
    """Classes of its own file that an example makes."""
    example = "\n".join(re.findall(r"^\s*(?:>>>|\.\.\.) (.*)$", one.text, re.MULTILINE))
    return {f"{one.function.__module__}.{name}" for name in re.findall(r"\b([A-Z]\w+)\(", example)}


BUILT = {name for one in THINGS for name in built(one)}
SHOWN = {name for one in THINGS if ">>>" in one.text for name in (*returned(one), one.name.rsplit(".", 1)[1])}
while more := {part for name in SHOWN for part in parts(name)} - SHOWN:
    SHOWN |= more


def lacks(one):
    """What is missing in one docstring, in words."""
    missing = []
    if not one.text:
        return ["a docstring"]
    known = set().union(*(other.described for other in helpers(one)))
    missing += [f"parameter {name}" for name in one.parameters if name not in known]
    for names, said in one.entries:
        if NUMBER.search(said) and not (COUNTED.search(said) or UNIT.search(said) or PURE.search(said)):
            missing.append(f"unit of {', '.join(names)}")
    arrays = [names for names, said in one.entries if re.search(r"array_like|ndarray|FloatArray", said)]
    if arrays and not any(SHAPE.search(other.text) for other in helpers(one)):
        missing.append(f"shape of {', '.join(name for names in arrays for name in names)}")
    said = " ".join(other.text for other in helpers(one))
    missing += [f"Raises {name}" for name in sorted(one.raises) if name not in said]
    if one.owner is None and not issubclass(type(one.thing), type(Enum)):
        is_error = isinstance(one.thing, type) and issubclass(one.thing, Exception)
        name = one.name.rsplit(".", 1)[1]
        calls = re.compile(rf"^(>>>|\.\.\.) .*\b{name}\(", re.MULTILINE)  # in an example of what it names
        shown = ">>>" in one.text or name in SHOWN or filled_in(one.thing) or one.name in BUILT
        if not (shown or is_error or any(calls.search(other.text) for other in helpers(one))):
            missing.append("an example")
    prose = one.text.split(">>>")[0]
    if FORMULA.search(prose) and not SOURCE.search(" ".join(other.text for other in helpers(one)[:2])):
        missing.append("the source of its formula")
    return missing


@pytest.mark.parametrize("one", THINGS, ids=lambda one: one.name)
def test_it_says_all(one):
    assert lacks(one) == []
