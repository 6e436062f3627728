"""Files read whole, and written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from ..errors import FileError

__all__ = ["check_target", "read_bytes", "replacing", "write_bytes"]


def read_bytes(path: str | Path) -> bytes:
    """The bytes of the file, or of standard input for "-".

    Raises
    ------
    FileError
        No such file, no permission, a folder.
    """
    if str(path) == "-":
        return sys.stdin.buffer.read()
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise FileError(str(path), "there is no such file", "check the name and the folder") from None
    except (OSError, ValueError) as error:
        raise FileError(str(path), f"it cannot be read ({_reason(error)})") from None


def check_target(path: str | Path) -> None:
    """Refuse a file that could not be written, before the work of making what goes into it.

    Raises
    ------
    FileError
        The path is a folder, or its folder does not exist.
    """
    target = Path(path)
    if target.is_dir():
        raise FileError(str(path), "it is a folder", "name a file")
    if not target.parent.is_dir():
        raise FileError(str(path), f"there is no folder {target.parent}", f"mkdir -p {target.parent}")


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place when the block ends well, and is removed when not.

    Raises
    ------
    FileError
        The folder does not exist, or cannot be written to.
    """
    target = Path(path)
    if target.is_symlink():
        target = target.resolve()
    check_target(target)
    if target.exists() and not target.is_file():  # a device or a pipe: there is nothing to replace
        yield target
        return
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:100]}.", suffix=".part", dir=target.parent)
        os.close(handle)
    except FileNotFoundError:
        raise FileError(str(path), f"there is no folder {target.parent}", f"mkdir -p {target.parent}") from None
    except (OSError, ValueError) as error:
        raise FileError(str(path), f"it cannot be written ({_reason(error)})") from None
    part = Path(name)
    try:
        yield part
        part.chmod(_mode(target))
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(target)
    except OSError as error:
        raise FileError(str(path), f"it cannot be written ({_reason(error)})") from None
    finally:
        part.unlink(missing_ok=True)


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write `data` to `path`, or to standard output for "-"; whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    if str(path) == "-":
        rest = memoryview(data)
        while rest:  # a stream without a buffer may take less than it is given
            rest = rest[sys.stdout.buffer.write(rest) :]
        sys.stdout.buffer.flush()
        return
    with replacing(path) as part:
        part.write_bytes(data)


def _mode(target: Path) -> int:
    """Permissions of the file that is replaced, or those that a new file would get."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
