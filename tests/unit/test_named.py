"""Compiled loops say what they take and give by name: no number stands for a name, and no list of parameters is long.

A type checker does not see into these loops, and a reader does not know what `fit[23]` is.
"""

import ast
from pathlib import Path

import pytest

import subskin

HOUSE = Path(subskin.__file__).parent
MOST = 12
"""Parameters of a compiled function."""
LAST = 4
"""Numbers up to this one say which of a few alike is meant (an axis, a side, a power); others stand for a name."""
RECORDS = {"fit", "found", "options", "row", "state", "work"}
"""Of these no part is alike: every number stands for a name."""


def compiled_functions(tree):
    """Functions with a decorator `@compiled(...)`, and those inside them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and any("compiled" in ast.dump(each) for each in node.decorator_list):
            yield node


def numbers(index, most):
    """The numbers above `most` by which an index picks: of `5`, of `5:9`, of `i, 5`; above LAST of `k + 5`."""
    if isinstance(index, ast.Constant):
        yield from [index.value] if type(index.value) is int and index.value > most else []
    elif isinstance(index, ast.BinOp) and isinstance(index.op, ast.Add):
        yield from (n for side in (index.left, index.right) for n in numbers(side, LAST))
    elif isinstance(index, ast.Slice):
        yield from (n for end in (index.lower, index.upper) if end is not None for n in numbers(end, most))
    elif isinstance(index, ast.Tuple):
        yield from (n for part in index.elts for n in numbers(part, most))


def name_of(node):
    """`fit` of `fit[...]` and of `fit[k][...]`, `options` of `self.options[...]`."""
    while isinstance(node, ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def faults(source):
    """What a stranger could not read in the compiled functions of a file."""
    for function in compiled_functions(ast.parse(source)):
        given = function.args
        count = len([*given.posonlyargs, *given.args, *given.kwonlyargs])
        if count > MOST:
            yield f"{function.name} takes {count} parameters"
        for node in ast.walk(function):
            most = -1 if isinstance(node, ast.Subscript) and name_of(node.value) in RECORDS else LAST
            if isinstance(node, ast.Subscript) and list(numbers(node.slice, most)):
                yield f"{function.name}, line {node.lineno}: {ast.unparse(node)}"


FILES = sorted(str(path.relative_to(HOUSE)) for path in HOUSE.rglob("*.py") if "@compiled(" in path.read_text("utf-8"))


def test_what_a_stranger_could_not_read_is_seen():
    lines = [
        "row[RESIDUAL] = row[first + 1] + table[cell, 4, i]",
        "return fit[2]",
        "return a[5]",
        "return row[k + 5]",
        "return options[3:5]",
    ]
    wanted = [0, 1, 1, 1, 1]
    assert [len(list(faults(f"@compiled()\ndef loop(a, b):\n    {line}"))) for line in lines] == wanted
    many = ", ".join(f"a{i}" for i in range(MOST + 1))
    assert list(faults(f"@compiled()\ndef loop({many}):\n    pass")) == ["loop takes 13 parameters"]
    assert not list(faults(f"def plain({many}):\n    return fit[7]"))


@pytest.mark.parametrize("file", FILES)
def test_no_number_stands_for_a_name_and_no_list_of_parameters_is_long(file):
    found = list(faults((HOUSE / file).read_text("utf-8")))
    assert not found, "\n".join(found)
