"""Finished rows of a search in a folder, so that a search that was stopped can go on."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .. import _check
from .._check import FloatArray
from .._path import path_of
from ..errors import FileError
from .files import write_bytes

__all__ = ["FolderStore"]


class FolderStore:
    """A folder with one file for each row; made where it is missing.

    Parameters
    ----------
    folder : path-like
        Where the rows are.

    Raises
    ------
    FileError
        A folder that cannot be made.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     store = FolderStore(folder)
    ...     store.put("first", {"unsure": np.array([0.25])})
    ...     store.get("first")["unsure"].tolist(), store.get("second")
    ([0.25], None)
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = path_of(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:  # the latter of a name with a NUL
            why = getattr(error, "strerror", None) or error
            raise FileError(str(folder), f"it cannot be made ({why})", "name another folder with -o") from None

    def get(self, key: str) -> Mapping[str, FloatArray] | None:
        """The row called `key`, or None; a file that was damaged counts as none."""
        try:
            data = io.BytesIO((self.folder / f"{key}.npz").read_bytes())
        except (OSError, ValueError):
            return None
        try:
            with np.load(data, allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        except (ValueError, OSError, EOFError, zipfile.BadZipFile, zlib.error):  # cut off
            return None

    def put(self, key: str, row: Mapping[str, FloatArray]) -> None:
        """Keep `row` by the name `key`, whole or not at all."""
        _check.noun("row", row, Mapping, 'row={"unsure": np.array([0.25])}')
        file = io.BytesIO()
        arrays: dict[str, Any] = dict(row)
        np.savez_compressed(file, **arrays)
        write_bytes(self.folder / f"{key}.npz", file.getvalue())
