"""Machine code that Numba keeps is made anew when what it was made of changes.

Numba looks at the text of the file that a function stands in, and not at the files it imports from: code that was kept
would go on calling the functions, and holding the constants, as they were.
"""

import gc
import os
import subprocess
import sys

import numba as nb
import pytest
from numba.core.event import Listener, install_listener

from subskin._compiled import is_cached

FILES = {
    "__init__": "",
    "constants": "FACTOR = 2\n",
    "below": "from subskin._compiled import compiled\n\n@compiled()\ndef number():\n    return 1\n",
    "between": "from subskin._compiled import compiled\nfrom . import constants\nfrom .below import number\n\n"
    "@compiled()\ndef twice():\n    return constants.FACTOR * number()\n",
    "above": "from subskin._compiled import compiled, is_cached\nfrom .between import (\n    twice as double,\n)\n\n"
    "@compiled()\ndef again():\n    return 2 * double()\n\nprint(is_cached(again), again())\n",
}


def test_a_loop_in_plain_python_need_not_be_compiled():
    assert is_cached(lambda: None)


def test_what_was_kept_is_used_until_what_it_is_built_on_changes(tmp_path):
    (tmp_path / "room").mkdir()
    for name, source in FILES.items():
        (tmp_path / "room" / f"{name}.py").write_text(source)

    def run():
        command = [sys.executable, "-m", "room.above"]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip()

    assert [run(), run()] == ["False 4", "True 4"]
    for changed, text, other, seen in (("below", "1", "5", "20"), ("constants", "2", "10", "100")):
        path = tmp_path / "room" / f"{changed}.py"
        before = path.stat().st_mtime
        path.write_text(path.read_text().replace(text, other))
        later = path.stat().st_mtime + 5  # clocks of files are coarse
        os.utime(path, (later, later))
        assert run().split()[-1] == seen
        os.utime(path, (before, before))  # so that the next change is not seen by this one
    path = tmp_path / "room" / "below.py"
    path.write_text(path.read_text().replace("compiled()", "compiled(exact=True)"))
    assert run() == "False 100"  # how a function is compiled counts too


class _Seen(Listener):
    """Whether Python searches for garbage when the compiling of a loop begins and has ended."""

    def __init__(self):
        self.searched = []

    def on_start(self, event):
        self.searched.append(gc.isenabled())

    on_end = on_start


@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize(("module", "meanwhile"), [("subskin.room", False), ("subskinned", True)])
def test_no_search_for_garbage_while_a_loop_of_ours_is_compiled(module, meanwhile, before):
    def below(x):
        return x + 1

    def above(x):
        return 2 * inner(x)

    def wrong(x):
        return inner(x).no_such_part

    for function in (below, above, wrong):
        function.__module__ = module
    was, seen, inner = gc.isenabled(), _Seen(), nb.njit(below)
    (gc.enable if before else gc.disable)()
    try:
        with install_listener("numba:compile", seen):
            with pytest.raises(nb.TypingError):
                nb.njit(wrong)(1)
            assert gc.isenabled() == before
            assert nb.njit(above)(1) == 4
            assert gc.isenabled() == before
    finally:
        (gc.enable if was else gc.disable)()
    during = before and meanwhile
    assert seen.searched == [during, during, during, before, during, before]  # wrong, below within it; above
