"""Arrays in files of their own: the response of a finger in place, and finished rows of a search."""

from __future__ import annotations

import hashlib
import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import FileError, SubskinError
from ..measured import MeasuredResponse
from .files import path_of, read_bytes, replacing, write_bytes

__all__ = ["FolderStore", "checksum", "read_response", "response_path", "write_both"]

_NAMES = ("y", "z", "values", "variance", "offset", "noise", "correlation", "load", "common", "vague")
_LARGEST = 1 << 31
_ENDING = ".response.npz"


def response_path(path: str | Path) -> Path:
    """Where the response of the finger file at `path` lies: beside it, `NAME.response.npz` for `NAME.toml`.

    Examples
    --------
    >>> response_path("left/calibrated.toml").as_posix()
    'left/calibrated.response.npz'
    """
    at = path_of(path)
    at = at.resolve() if at.is_symlink() else at
    return at.with_name(at.name.removesuffix(".toml") + _ENDING)


def checksum(response: MeasuredResponse) -> str:
    """SHA-256 of the numbers of a response, as `[calibration] response` has it."""
    out = hashlib.sha256()
    for name in _NAMES:
        if name == "vague" and response.vague == np.inf:
            continue  # as in files of 0.2.0, which know of none
        values = np.ascontiguousarray(getattr(response, name), dtype="<f8")
        out.update(f"{name}{values.shape}".encode())
        out.update(values.tobytes())
    return out.hexdigest()


def read_response(finger: str, expected: str) -> MeasuredResponse:
    """The response that belongs to the file of a `finger`, whose checksum it has to have.

    Raises
    ------
    FileError
        It is missing, that of another finger, or damaged.
    """
    again = "calibrate again, or copy both files of the finger and give them one name"
    if finger == "-":
        raise FileError("a finger from standard input", "its response lies in a file beside it", "name the file")
    path = response_path(finger)
    if not path.is_file():
        raise FileError(str(path), f"{finger} needs this file beside it, and it is not there", again)
    if path.stat().st_size > _LARGEST:
        raise FileError(str(path), "a response has at most 2 GiB", again)
    data = read_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as parts:
            if sum(part.file_size for part in parts.infolist()) > _LARGEST:
                raise ValueError
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            response = MeasuredResponse(**{name: arrays[name] for name in _NAMES if name != "vague" or name in arrays})
    except (SubskinError, ValueError, KeyError, TypeError, EOFError, MemoryError, OSError, zipfile.BadZipFile) as wrong:
        raise FileError(str(path), f"it holds no response ({str(wrong)[:80] or type(wrong).__name__})", again) from None
    if checksum(response) != expected:
        raise FileError(str(path), f"it is not the response that {finger} was written with (another checksum)", again)
    return response


def write_both(path: str | Path, text: str, of: MeasuredResponse) -> None:
    """Write a finger file and, beside it, its response: both, or neither.

    Raises
    ------
    FileError
        One of the two cannot be written; standard output, or what is no file.
    """
    at = path_of(path)
    if str(path) == "-" or (at.exists() and not at.is_file()):
        seen = "standard output" if str(path) == "-" else str(path)
        raise FileError(seen, "this finger's response goes into a file beside the finger", "-o calibrated.toml")
    with replacing(path) as finger, replacing(response_path(path)) as response:
        with response.open("wb") as file:
            arrays: dict[str, Any] = {name: np.asarray(getattr(of, name)) for name in _NAMES}
            np.savez(file, **arrays)
        finger.write_bytes(text.encode("utf-8"))


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
