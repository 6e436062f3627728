"""A port that is open, and the driver that reads it: what a person named, or what [live] of the finger file says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import FileError, InvalidValueError, SubskinError
from ..io.finger_file import FingerFile
from ..io.toml_errors import wrong_in
from .drivers import Driver, from_table
from .drivers.base import written
from .ports import FilePort, Log, Port, opened

__all__ = ["connected"]


def connected(
    file: FingerFile,
    port: Port | str | None = None,
    driver: Driver | str | Mapping[str, Any] | None = None,
    rate: float | None = None,
) -> tuple[Port, Driver]:
    """The port, open, and the driver that reads it; parameters and errors as of `live`."""
    if port is None:
        port = "" if file.live is None else file.live.port
        if not port:
            fix = 'port="demo" (--port demo) simulates one; port = "..." under [live] of the finger file'
            raise InvalidValueError("no port", "nothing says where the device is", fix)
    where = opened(port, file) if isinstance(port, str) else port
    try:
        reads = _driver(driver, where, file)
        if isinstance(where, FilePort) and where.regular:
            return Log(where, reads, rate), reads
        if rate is not None:
            rule = "a device has a rate of its own, and only a file of bytes is played"
            raise InvalidValueError(f'rate = {rate!r} of port "{where.name}"', rule, "leave it out")
        return where, reads
    except BaseException:
        where.close()
        raise


def _driver(given: Driver | str | Mapping[str, Any] | None, port: Port, file: FingerFile) -> Driver:
    """The driver that was named, that of the port, or that of [live] of the finger file."""
    if isinstance(given, Driver):
        return given
    if isinstance(given, str):
        name, options = written(given)
        return from_table({"name": name, **{k: int(text) if text.isdecimal() else text for k, text in options.items()}})
    if given is not None:
        return from_table(given)
    if port.driver is not None:
        return port.driver
    if file.live is not None and file.live.driver:
        try:
            return from_table(file.live.driver)
        except FileError:  # of another file, which describes a board
            raise
        except SubskinError as error:
            raise wrong_in(file.text, file.name, ("live", "driver"), file.live.driver, error) from None
    rule = "nothing says how the bytes of this device are read"
    raise InvalidValueError(f'port "{port.name}" without a driver', rule, 'driver="lines", or driver under [live]')
