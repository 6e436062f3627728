"""Files read whole or as a stream, and written whole or not at all; values as JSON has them."""

from __future__ import annotations

import contextlib
import io
import itertools
import math
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import FileError, InvalidValueError

__all__ = [
    "apart",
    "check_target",
    "making",
    "needed",
    "opened",
    "path_of",
    "plain",
    "read_bytes",
    "replacing",
    "size_of",
    "to_standard_output",
    "write_bytes",
]


def path_of(value: object) -> Path:
    """The path that is given: a text or a `Path`, not an open file, nor a number, which Python takes for one."""
    if not isinstance(value, str | os.PathLike) or isinstance(os.fspath(value), bytes):
        seen, rule = f"a {type(value).__name__} for a path", "a text or a pathlib.Path is needed"
        raise InvalidValueError(seen, rule, '"finger.toml"')
    return Path(value)


@contextlib.contextmanager
def opened(path: str | Path) -> Iterator[io.BufferedReader]:
    """The file at `path`, or standard input for "-", to be read as it comes.

    Raises
    ------
    FileError
        No such file, no permission, a folder; it ends with an error while it is read.
    """
    at = path_of(path)
    name = "standard input" if str(path) == "-" else str(path)
    with contextlib.ExitStack() as stack:
        try:
            file = _standard_input() if str(path) == "-" else stack.enter_context(at.open("rb"))
            start = file.peek(4)[:4]
        except FileError:
            raise
        except FileNotFoundError:
            raise FileError(name, "there is no such file", "check the name and the folder") from None
        except (OSError, ValueError) as error:
            raise _unreadable(name, error) from None
        if start == b"PAR1" and not file.seekable():  # Parquet is read from its end
            held = stack.enter_context(tempfile.TemporaryFile())
            shutil.copyfileobj(file, held)
            held.seek(0)
            file = held  # type: ignore[assignment]
        yield file


def _standard_input() -> io.BufferedReader:
    stream = getattr(sys.stdin, "buffer", None)
    if stream is None:
        raise FileError("standard input", "it is closed", "name a file")
    return stream if hasattr(stream, "peek") else io.BufferedReader(stream)


def read_bytes(path: str | Path) -> bytes:
    """The bytes of the file, or of standard input for "-".

    Raises
    ------
    FileError
        No such file, no permission, a folder.
    """
    with opened(path) as file:
        try:
            return file.read()
        except OSError as error:
            raise _unreadable(path, error) from None


def check_target(path: str | Path) -> None:
    """Refuse a file that could not be written, before the work of making what goes into it.

    Raises
    ------
    FileError
        The path is a folder, or its folder does not exist.
    """
    target = path_of(path)
    try:
        if target.is_dir():
            raise FileError(str(path), "it is a folder", "name a file")
        if not target.parent.is_dir():
            raise FileError(str(path), f"there is no folder {target.parent}", f"mkdir -p {target.parent}")
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise _unwritable(path, error) from None


def apart(inputs: Mapping[str, str], outputs: Mapping[str, str]) -> None:
    """Refuse outputs that would fall on an input or on each other, be it by another spelling or through a link.

    Parameters
    ----------
    inputs, outputs : mapping of str to str
        Paths by what they are called; "-" is standard input or output.

    Raises
    ------
    FileError
        Two of them are one file, and one of these would be written.
    """
    before: list[tuple[str, str]] = [item for item in inputs.items() if item[1] != "-"]
    for called, path in outputs.items():
        for other, known in before:
            if _one_file(path, known):
                rule = f"it is the same file as {other}" + (f" {known}" if known != path else "")
                raise FileError(f"{called} {path}", rule, "name another file")
        before.append((called, path))


def _one_file(a: str, b: str) -> bool:
    if "-" in (a, b):
        return a == b
    try:
        if Path(a).exists() and Path(b).exists():
            return Path(a).is_file() and Path(a).samefile(b)  # a device may be named twice
        return os.path.realpath(a) == os.path.realpath(b)
    except (OSError, ValueError):
        return False


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place when the block ends well, and is removed when not.

    For "-" it is copied to standard output when the block ends well.

    Raises
    ------
    FileError
        The folder does not exist, or cannot be written to.
    """
    if str(path) == "-":
        with _spooled() as part:
            yield part
        return
    target = path_of(path)
    if target.is_symlink():
        target = _behind(target)
    check_target(target)
    if target.exists() and not target.is_file():  # a device or a pipe: there is nothing to replace
        try:
            yield target
        except BrokenPipeError:
            raise
        except OSError as error:
            raise _unwritable(path, error) from None
        return
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:100]}.", suffix=".part", dir=target.parent)
        os.close(handle)
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None
    part = Path(name)
    try:
        yield part
        part.chmod(_mode(target))
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(target)
    except OSError as error:
        raise _unwritable(path, error) from None
    finally:
        part.unlink(missing_ok=True)


def _behind(link: Path) -> Path:
    try:
        return link.resolve()
    except (OSError, RuntimeError) as error:  # RuntimeError: a loop of links, before Python 3.13
        raise _unwritable(link, error) from None


@contextlib.contextmanager
def _spooled() -> Iterator[Path]:
    handle, name = tempfile.mkstemp(prefix="subskin.", suffix=".part")
    os.close(handle)
    part = Path(name)
    try:
        yield part
        with part.open("rb") as file:
            to_standard_output(iter(lambda: file.read(1 << 20), b""))
    finally:
        part.unlink(missing_ok=True)


@contextlib.contextmanager
def making(path: Path) -> Iterator[Path]:
    """A name for a new folder beside `path`, which takes its place when the block ends well, and is removed when not.

    Raises
    ------
    FileError
        There is something at `path`, or it cannot be made.
    """
    if path.exists() or path.is_symlink():
        raise FileError(str(path), "there is such a folder or file already", "name another folder")
    try:
        with tempfile.TemporaryDirectory(prefix=f".{path.name[:100]}.", suffix=".part", dir=path.parent) as kept:
            part = Path(kept) / path.name
            yield part
            part.rename(path)
    except OSError as error:
        raise FileError(str(path), f"it cannot be written ({error.strerror or error})", "name another folder") from None


def to_standard_output(pieces: Iterable[bytes | str], end: str = "") -> None:
    """Write pieces, one after the other, to standard output.

    Raises
    ------
    FileError
        It is closed, or its disk is full.
    """
    stream = getattr(sys.stdout, "buffer", None)
    if stream is None:
        raise FileError("standard output", "it is closed", "name a file with -o")
    try:
        sys.stdout.flush()
        for piece in itertools.chain(pieces, [end]):
            rest = memoryview(piece.encode() if isinstance(piece, str) else piece)
            while rest:  # a stream without a buffer may take less than it is given
                rest = rest[stream.write(rest) :]
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FileError("standard output", f"it cannot be written ({_reason(error)})", "name a file with -o") from None


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write `data` to `path`, or to standard output for "-"; whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    if str(path) == "-":
        to_standard_output([data])
        return
    with replacing(path) as part:
        part.write_bytes(data)


def _mode(target: Path) -> int:
    """Permissions of the file that is replaced, or those that a new file would get."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    return 0o666 & ~umask()


def umask() -> int:
    """The permissions that new files and folders do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _unreadable(path: object, error: Exception) -> FileError:
    return FileError(str(path), f"it cannot be read ({_reason(error)})", "check the file and its permissions")


def _unwritable(path: object, error: Exception) -> FileError:
    return FileError(str(path), f"it cannot be written ({_reason(error)})", "check the folder, or name another file")


def plain(value: Any) -> Any:
    """What JSON can say; what is not a number is null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):  # a NumPy array or number
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def needed(seen: str, rule: str, fix: str, *modules: str) -> Any:
    """The first of some modules, all of which have to be there.

    Raises
    ------
    FileError
        One is not installed.
    """
    try:
        first, *_ = map(import_module, modules)
        return first
    except ImportError:
        raise FileError(seen, rule, fix) from None


def size_of(file: BinaryIO) -> int | None:
    """Bytes of a file that is open; None of a pipe or a device."""
    try:
        about = os.fstat(file.fileno())
    except (OSError, ValueError):
        return None
    return about.st_size if stat.S_ISREG(about.st_mode) else None
