"""Every code block of the README and the docs runs, page by page, in an empty folder of its own.

- `python` blocks run one after the other in one namespace, with warnings as errors; a `text` block right
  below one is what it has to print;
- `pycon` blocks are doctests in that namespace;
- `console` blocks: each line after `$ ` runs in bash and has to succeed; lines below are what it has to print
  (`...` stands for anything);
- a block after `<!-- file: name -->` is also written to that file, as every `toml` block has to be;
- `<!-- not run: reason -->` before a block leaves it out.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from subskin.contact import Contact, LocalContact
from subskin.transducer import Transducer

from .._commands import Run, subskin

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    page
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
    if not {"_build", "generated", "gallery"} & set(page.relative_to(ROOT).parts)
)
RUN, SHOWN = {"python", "pycon", "console", "toml"}, {"text", "bibtex", "json", "csv"}
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,})(?P<language>[^`\n]*)$")
MARK = re.compile(r"^<!-- (?P<kind>file|not run): (?P<value>.+) -->$")
MOST_NOT_RUN = 5
WIDEST = 90  # columns that a page shows without a scroll bar


@dataclass(frozen=True)
class Block:
    line: int
    language: str
    code: str
    file: str = ""
    not_run: str = ""
    below: bool = False  # nothing but blank lines between it and the block above


def blocks(text: str) -> list[Block]:
    """The fenced blocks of a page, directives (`{...}`) left aside."""
    found, lines, i = [], text.splitlines(), 0
    mark: dict[str, str] = {}
    below = False
    while i < len(lines):
        fence = FENCE.match(lines[i])
        if not fence:
            comment = MARK.match(lines[i].strip())
            if comment:
                mark = {comment["kind"].replace(" ", "_"): comment["value"]}
            elif lines[i].strip():
                mark, below = {}, False
            i += 1
            continue
        end = next(j for j in range(i + 1, len(lines)) if lines[j].strip() == fence["ticks"])
        language = fence["language"].strip()
        if not language.startswith("{"):
            indent = len(fence["indent"])
            code = "\n".join(line[indent:] for line in lines[i + 1 : end]) + "\n"
            found.append(Block(i + 1, language, code, below=below, **mark))
        mark, below, i = {}, True, end + 1
    return found


def commands(code: str) -> list[tuple[str, str]]:
    """(command, expected output) of each `$ ` line of a console block; a backslash joins the next line."""
    parts: list[list[str]] = []
    joining = False
    for line in code.splitlines():
        if line.startswith("$ "):
            parts.append([line[2:], ""])
        elif joining:
            parts[-1][0] += "\n" + line
        elif parts:
            parts[-1][1] += line + "\n"
        joining = line.endswith("\\") and (line.startswith("$ ") or joining)
    return [(command, output) for command, output in parts]


def run_console(block: Block, folder: Path, page: str) -> None:
    """A line that runs `subskin` alone does so in this process, which saves its start; any other in bash."""
    steps = commands(block.code)
    assert steps, f"{page}:{block.line}: a console block needs a line that starts with '$ '"
    for command, expected in steps:
        words = shlex.split(command.replace("\\\n", " "))
        if words[0] == "subskin" and not set(words) & set("|<>&;"):
            done = subskin(*words[1:])
        else:
            done = in_bash(command, folder)
        where = f"{page}:{block.line}: {command}"
        assert done.code == 0, f"{where}\nexit code {done.code}\n{done.out}\n{done.err}"
        if expected.strip():
            same = doctest.OutputChecker().check_output(expected, done.out, FLAGS)
            assert same, f"{where}\nexpected\n{expected}\nprinted\n{done.out}"


def in_bash(command: str, folder: Path) -> Run:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", "-c", command], cwd=folder, env={**os.environ, "PATH": path},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    return Run(done.returncode, done.stdout, done.stderr)


def run_page(text: str, folder: Path, page: str) -> None:
    """Run every block of a page in `folder`."""
    namespace: dict[str, object] = {"__name__": "__main__"}
    printed: str | None = None
    for block in blocks(text):
        before, printed = printed, None
        if block.language == "text" and block.below and before:
            same = doctest.OutputChecker().check_output(block.code, before, FLAGS)
            assert same, f"{page}:{block.line}: expected\n{block.code}\nprinted\n{before}"
        if block.not_run or block.language in SHOWN:
            continue
        assert block.language in RUN, f"{page}:{block.line}: language {block.language!r} is not one of {RUN | SHOWN}"
        if block.file:
            (folder / block.file).write_text(block.code, encoding="utf-8")
        if block.language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile("\n" * block.line + block.code, page, "exec"), namespace)
            printed = out.getvalue()
        elif block.language == "pycon":
            test = doctest.DocTestParser().get_doctest(block.code, namespace, page, page, block.line)
            report: list[str] = []
            result = doctest.DocTestRunner(optionflags=FLAGS).run(test, out=report.append, clear_globs=False)
            namespace.update(test.globs)
            assert result.failed == 0, "".join(report)
        elif block.language == "console":
            run_console(block, folder, page)
        else:
            assert block.file, f"{page}:{block.line}: say where a toml block belongs: <!-- file: finger.toml -->"


@pytest.mark.parametrize("page", [pytest.param(p, id=str(p.relative_to(ROOT))) for p in PAGES])
def test_page(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for root in (Contact, LocalContact, Transducer):  # what a page names is gone after it
        monkeypatch.setattr(root, "_by_name", dict(root._by_name))
    run_page(page.read_text(encoding="utf-8"), tmp_path, str(page.relative_to(ROOT)))


def test_code_fits_the_page() -> None:
    found = [(page.name, block) for page in PAGES for block in blocks(page.read_text("utf-8"))]
    lines = [(name, line) for name, block in found for line in block.code.splitlines()]
    assert [(name, line) for name, line in lines if len(line) > WIDEST] == []


def test_few_blocks_are_left_out() -> None:
    left_out = [f"{p.name}:{b.line}: {b.not_run}" for p in PAGES for b in blocks(p.read_text("utf-8")) if b.not_run]
    assert len(left_out) <= MOST_NOT_RUN, left_out


@pytest.mark.parametrize(
    ("page", "complaint"),
    [
        ("```python\nassert 1 == 2\n```\n", AssertionError),
        ("```python\na = 1\n```\n\n```python\nassert a == 2\n```\n", AssertionError),
        ("```python\nprint(1)\n```\n\n```text\n2\n```\n", AssertionError),
        ("```pycon\n>>> 1 + 1\n3\n```\n", AssertionError),
        ("```console\n$ echo one; exit 3\n```\n", AssertionError),
        ("```console\n$ echo one \\\n  two\none three\n```\n", AssertionError),
        ("```toml\na = 1\n```\n", AssertionError),
        ("```\nno language\n```\n", AssertionError),
        ("- item\n\n  ```python\n  raise KeyError\n  ```\n", KeyError),
    ],
)
def test_a_bad_block_is_noticed(page: str, complaint: type[Exception], tmp_path: Path) -> None:
    with pytest.raises(complaint):
        run_page(page, tmp_path, "page")


def test_blocks_share_a_namespace_and_a_folder(tmp_path: Path) -> None:
    page = (
        "```python\na = 1\n```\n<!-- file: f.toml -->\n```toml\nb = 2\n```\n"
        "```console\n$ cat f.toml \\\n  f.toml\nb = 2\nb = 2\n```\n```pycon\n>>> a\n1\n```\n"
        "<!-- not run: it fails -->\n```python\nassert False\n```\n"
    )
    run_page(page, tmp_path, "page")
    assert (tmp_path / "f.toml").read_text("utf-8") == "b = 2\n"
