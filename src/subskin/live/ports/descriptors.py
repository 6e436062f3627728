"""Bytes of a file, a pipe, a named pipe, standard input."""

from __future__ import annotations

import os
import select
import stat
import sys

from ...errors import FileError
from .base import HeldPort, PortEnded, PortLost

__all__ = ["FilePort", "StandardInput"]

_MOST = 1 << 16


class _Descriptor(HeldPort):
    """What an open descriptor gives; a regular file as fast as it is read."""

    def read(self, timeout: float) -> bytes:
        number: int = self._own
        try:
            if self.real_time and not select.select([number], [], [], timeout)[0]:
                return b""
            data = os.read(number, _MOST)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise PortLost(self.name, f"it cannot be read ({error.strerror})", "check the cable") from None
        if not data:
            raise PortEnded(self.name, "it is at its end")
        return data

    @property
    def real_time(self) -> bool:
        """Whether bytes come in their own time: not of a regular file, and not known of a pipe on Windows."""
        return os.name == "posix" and not stat.S_ISREG(os.fstat(self._own).st_mode)

    def write(self, data: bytes) -> None:
        pass


class FilePort(_Descriptor, name="file"):
    """`file:PATH`: bytes that were recorded, or a named pipe.

    Parameters
    ----------
    path : str
        The file.

    Raises
    ------
    FileError
        There is no such file, or it cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "log.bin").write_bytes(b"ab")
    ...     with FilePort(f"{folder}/log.bin") as port:
    ...         port.regular, port.read(0.0)
    (True, b'ab')
    """

    def __init__(self, path: str) -> None:
        self.name, self._path = path, path
        self.reopen()

    @property
    def regular(self) -> bool:
        """Whether it is a file that holds all its bytes already, and no pipe into which they come."""
        return self._held is not None and stat.S_ISREG(os.fstat(self._held).st_mode)

    def _begun(self) -> int:
        if not self._path:
            raise FileError("file:", "the name of a file is needed", "file:log.bin")
        try:
            number = os.open(self._path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        except OSError as error:
            raise FileError(self._path, f"it cannot be read ({error.strerror})", "check the name") from None
        if stat.S_ISDIR(os.fstat(number).st_mode):
            os.close(number)
            raise FileError(self._path, "it is a folder", "name a file in it")
        return number

    def _ended(self, held: int) -> None:
        os.close(held)


class StandardInput(_Descriptor, name="-"):
    """`-`: what is piped in.

    Raises
    ------
    PortLost
        Standard input is closed.
    """

    def __init__(self) -> None:
        self.name = "standard input"
        self.reopen()

    def _begun(self) -> int:
        try:
            return sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):
            raise PortLost(self.name, "it is closed", "pipe bytes into it") from None

    def _ended(self, held: int) -> None:
        pass  # it is not ours to close
