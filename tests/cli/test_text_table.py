"""Tables for people: every number is there, whole, however narrow the terminal."""

import io
import re

import pytest

from subskin.cli.common import show

HEADS = ["candidate", "OK [%]", "median [mm]", "worst after all of it [mm]", "in 95 % [%]", "R^2"]
NAMES = ["normal strain of a half plane, Poisson's ratio fitted", "mean pressure of a layer"]
NUMBERS = [[f"{i}1.7", f"0.0{i}131", f"-1.23456e-0{i}", "100.0", f"0.99{i}99"] for i in range(2)]


class Screen(io.StringIO):
    """A terminal of so many columns, or a pipe."""

    def __init__(self, columns, monkeypatch):
        super().__init__()
        self.columns = columns
        monkeypatch.setenv("COLUMNS", str(columns or 10))

    def isatty(self):
        return self.columns is not None

    def lines(self, rows, heads=HEADS):
        show(self, "a title", heads, rows)
        text = self.getvalue()
        assert "…" not in text
        return re.sub(r"\x1b\[[0-9;]*m", "", text).splitlines()


ROWS = [[name, *numbers] for name, numbers in zip(NAMES, NUMBERS, strict=True)]


@pytest.mark.parametrize("columns", [None, 200, 100, 80, 40, 10])
def test_no_number_and_no_heading_is_cut(monkeypatch, columns):
    lines = Screen(columns, monkeypatch).lines(ROWS)
    for numbers in NUMBERS:
        assert any(line.split()[-5:] == numbers for line in lines)
    head = lines[: next(i for i, line in enumerate(lines) if "──" in line)]
    said = " ".join(head).split()
    for word in " ".join(HEADS).split():
        assert word in said
    for word in " ".join(NAMES).split():
        assert any(word in line.split() for line in lines)


def test_a_table_is_no_wider_than_the_terminal_where_words_can_be_wrapped(monkeypatch):
    assert max(map(len, Screen(200, monkeypatch).lines(ROWS))) < 140
    for columns in (100, 88, 80):
        assert max(map(len, Screen(columns, monkeypatch).lines(ROWS))) <= columns


def test_a_pipe_has_no_width_and_wraps_nothing(monkeypatch):
    lines = Screen(None, monkeypatch).lines([[name, *30 * ["0.123456789"]] for name in NAMES], ["name", *30 * ["n"]])
    for name in NAMES:
        assert sum(line.strip().startswith(name) for line in lines) == 1
    assert sum(line.count("0.123456789") for line in lines) == 60
