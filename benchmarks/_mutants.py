"""Mutants of lines drawn at random, by the operators of cosmic-ray."""

from __future__ import annotations

import difflib
import random
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ALIKE = [
    set(words.split())
    for words in ("Add Sub Mul Div FloorDiv Mod Pow", "Eq NotEq Lt LtE Gt GtE", "Is IsNot", "UAdd USub")
] + [{"LShift", "RShift", "BitAnd", "BitOr", "BitXor"}]
LEFT_OUT = {"RemoveDecorator", "VariableReplacer", "VariableInserter", "NoOp"}


class Mutant(NamedTuple):
    """A file, its text with the fault, the line of the fault, and what was there and is."""

    path: Path
    text: str
    line: int
    change: str


def operators() -> dict:
    """Those that exchange like for like: what stops with an error wherever it is run tells nothing about a test."""
    chosen = {}
    for name in operator_names():
        kind, *pair = name.split("/")[1].split("_")
        if kind not in LEFT_OUT and (not pair or "Delete" in pair or any(set(pair) <= words for words in ALIKE)):
            chosen[name] = get_operator(name)()
    return chosen


def idle(node) -> bool:
    """Whether a change here changes nothing that runs, or only the words of a message or options of the compiler."""
    while (above := node.parent) is not None:
        at = above.children.index(node)
        if (
            above.type in {"decorator", "tfpdef", "import_from"}
            or above.type.startswith("fstring")
            or (above.type == "annassign" and at == 1)
            or (above.type == "funcdef" and above.children[at - 1] == "->")
            or (above.type == "expr_stmt" and "njit(" in above.get_code())
        ):
            return True
        node = above
    return False


def mutants(files: list[Path], seed: int) -> Iterator[Mutant]:
    """One of each line, lines in random order; any place on a line, and any change there, is as likely as another."""
    draw, parsed, chosen = random.Random(seed), {}, operators()
    lines = [(path, i) for path in files for i, _ in enumerate(path.read_text().splitlines(), 1)]
    draw.shuffle(lines)
    for path, line in lines:
        text = path.read_text()
        if path not in parsed:
            parsed[path] = list(ast_nodes(get_ast(text)))
        places: dict[tuple, list[tuple[str, int, int]]] = {}
        for k, node in enumerate(parsed[path]):
            if node.start_pos[0] == line and not idle(node):
                for name, operator in chosen.items():
                    for i, (start, _) in enumerate(operator.mutation_positions(node)):
                        places.setdefault((start, node.type), []).append((name, k, i))
        if not places:
            continue
        name, k, i = draw.choice(places[draw.choice(sorted(places))])
        before = sum(len(list(chosen[name].mutation_positions(node))) for node in parsed[path][:k])
        new = mutate_code(text, chosen[name], before + i)
        with suppress(SyntaxError):
            compile(new, path, "exec")
            pair = list(difflib.unified_diff(text.splitlines(), new.splitlines(), n=0))[3:]
            yield Mutant(path, new, line, "  ->  ".join(part[1:].strip() for part in pair))
