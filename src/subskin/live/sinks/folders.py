"""Folders that appear whole or not at all."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

from ...errors import FileError

__all__ = ["making"]


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
