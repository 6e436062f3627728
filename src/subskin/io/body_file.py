"""Bodies from files: a mesh (STL), a table of heights, an image; each becomes a `HeightMap`."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import FileError, InvalidValueError, SubskinError
from ..pressing import HeightMap
from ._csv import number_of
from .files import path_of

__all__ = ["read_body"]

_MESHES, _TABLES, _ARRAYS = (".stl",), (".csv", ".txt"), (".npy",)
_IMAGES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
_MOST = 1 << 24
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_MESH_UNIT = 1e-3
_EDGE = 1e-9
_END = 3  # lines of an ASCII mesh among which its last word is; blank ones may follow


def read_body(
    path: str | os.PathLike[str], *, pitch: float, unit: float | None = None, height: float | None = None
) -> HeightMap:
    """A rigid body from a file, as a map of heights whose middle is at (0, 0).

    A mesh presses with the side of its lowest z: its x becomes y, its y becomes z, and the height at a point is the
    lowest of the mesh there. In a table or an array rows run along y and columns along z, and an empty cell or `inf`
    says that no body is there. In an image rows run along y from above, and white is highest: farthest from the skin.

    Parameters
    ----------
    path : path
        .stl (binary or ASCII), .csv or .txt (commas, semicolons or blanks), .npy, or an image (.png, .jpg, .tif, .bmp).
    pitch : float
        Distance of the points of the map [m], > 0: of rows and columns, or at which a mesh is sampled.
    unit : float, optional
        Metres in a unit of the file; 1e-3 for a mesh and 1 for a table or an array if left out.
    height : float, optional
        Height of white above black [m], for an image, which needs it.

    Returns
    -------
    HeightMap
        For `press`.

    Raises
    ------
    FileError
        A file that is not there, of another kind, or broken; a mesh that is empty, or too large for its pitch.
    InvalidValueError
        An image without a height.

    Examples
    --------
    >>> import tempfile, numpy as np
    >>> at = np.linspace(-1e-3, 1e-3, 21)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.save(f"{folder}/dome.npy", (at[:, None] ** 2 + at**2) / 16e-3)
    ...     body = read_body(f"{folder}/dome.npy", pitch=0.1e-3)
    >>> body.height([0.0, 1e-3], 0.0).round(9).tolist()
    [0.0, 6.25e-05]
    """
    file = path_of(path)
    step = _check.scalar("pitch", pitch, unit="m", above=0.0)
    kind = file.suffix.lower()
    mesh = kind in _MESHES
    scale = _check.scalar("unit", (_MESH_UNIT if mesh else 1.0) if unit is None else unit, unit="m", above=0.0)
    try:
        if mesh:
            return _sampled(file, scale * _facets(file), step)
        if kind in _ARRAYS:
            heights = scale * _array(file)
        elif kind in _TABLES:
            heights = scale * _table(file)
        elif kind in _IMAGES:
            heights = _image(file, height)
        else:
            known = ", ".join((*_MESHES, *_TABLES, *_ARRAYS, *_IMAGES))
            raise FileError(f"{file}", f"a body is read from {known}", "save it as one of these")
    except SubskinError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"{file}: {error}", "the file has to hold what its suffix says", "see io.read_body") from error
    if heights.ndim != 2 or min(heights.shape) < 2:
        seen = f"{file}: heights of shape {heights.shape}"
        raise FileError(seen, "two rows and two columns or more are needed", "one height a cell, commas between them")
    _few(file, heights.shape)
    heights = np.where(np.isnan(heights), np.inf, heights)
    if not np.isfinite(heights).any() or (heights == -np.inf).any():
        seen = f"{file}: {'a height of -inf' if (heights == -np.inf).any() else 'no height in it is a number'}"
        raise FileError(seen, "a body has heights, and inf where it is not", "numbers in the cells")
    y, z = (step * (np.arange(count) - 0.5 * (count - 1)) for count in heights.shape)
    return HeightMap(y, z, heights)


@contextlib.contextmanager
def _damage_said(file: Path, what: str) -> Iterator[None]:
    """What is damaged in a file makes errors of many kinds in whoever reads it; one of them is said."""
    try:
        yield
    except SubskinError:
        raise
    except Exception as error:
        raise FileError(f"{file}: {error}", f"it cannot be read as {what}", "save it anew") from error


def _few(file: Path, counts: Sequence[float]) -> None:
    if counts[0] * counts[1] > _MOST:
        seen = f"{file}: {counts[0]:.0f} by {counts[1]:.0f} points"
        raise FileError(seen, f"at most {_MOST} are handled", "a coarser map, or a part of it")


def _table(file: Path) -> FloatArray:
    text = file.read_text(encoding="utf-8-sig")
    mark = ";" if ";" in text else "," if "," in text else None
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), 1):
        heights = line.partition("#")[0].strip()
        if not heights:
            continue
        cells = [cell.strip() for cell in heights.split(mark)]
        found = [number_of(cell) for cell in cells]
        if None in found:
            seen = f'{file}, line {number}: "{cells[found.index(None)]}"'
            raise FileError(seen, "a cell is a height, or empty where no body is", "a decimal point, and no header")
        if rows and len(found) != len(rows[0]):
            seen = f"{file}, line {number}: {len(found)} cells"
            raise FileError(seen, f"the rows before have {len(rows[0])} each", "as many cells in each row")
        rows.append([height for height in found if height is not None])
    return np.array(rows, dtype=np.float64)


def _array(file: Path) -> FloatArray:
    with _damage_said(file, "an array"):
        values = np.load(file, mmap_mode="r", allow_pickle=False)  # takes no memory for what a damaged head promises
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        kind = f"an array of {values.dtype}" if isinstance(values, np.ndarray) else "several arrays"
        raise FileError(f"{file}: {kind}", "one array of real numbers is needed", "np.save(file, heights)")
    return values.astype(np.float64)


def _image(file: Path, height: float | None) -> FloatArray:
    if height is None:
        rule = "an image says which points are high, not how high"
        raise InvalidValueError(f"{file.name} without a height", rule, "height=0.2e-3, of white above black [m]")
    from PIL import Image

    with _damage_said(file, "an image"), Image.open(file) as image:
        _few(file, image.size)
        deep = image.mode.startswith(("I", "F"))  # 16 bits, or numbers
        shades = np.asarray(image if deep else image.convert("RGB"), dtype=np.float64)
        values = shades / (1.0 if image.mode == "F" else 65535.0 if deep else 255.0)
    grey = values[..., :3].mean(axis=-1) if values.ndim == 3 else values
    return np.asarray(_check.scalar("height", height, unit="m", above=0.0) * grey)


def _facets(file: Path) -> FloatArray:
    """Corners of the mesh's triangles, shape (m, 3, 3), in its own unit."""
    data = file.read_bytes()
    count = int(np.frombuffer(data[80:84], dtype="<u4")[0]) if len(data) >= 84 else 0
    if count and len(data) == 84 + count * _FACET.itemsize:
        corners = np.frombuffer(data, dtype=_FACET, offset=84)["corners"].astype(np.float64)
    else:
        lines = [line.split() for line in data.decode("ascii", errors="replace").lower().splitlines()]
        found = [line[1:] for line in lines if line[:1] == ["vertex"]]
        if not found:
            takes = f"{84 + count * _FACET.itemsize} bytes for the {count} triangles that its head counts"
            seen = f"{file}: {len(data)} bytes without a corner in ASCII"
            raise FileError(seen, f"a binary STL would have {takes}", "export it anew")
        ended = any(line[:1] == ["endsolid"] for line in lines[-_END:])
        if len(found) % 3 or not ended or any(len(corner) != 3 for corner in found):
            seen = f"{file}: {len(found)} corners in ASCII, {'with' if ended else 'without'} an end"
            raise FileError(seen, "three corners of three numbers each, and endsolid at the end", "export it anew")
        corners = np.array(found, dtype=np.float64).reshape(-1, 3, 3)
    if not np.isfinite(corners).all():
        raise FileError(f"{file}: a corner that is not a number", "triangles have corners", "export it anew")
    return corners


def _sampled(file: Path, corners: FloatArray, step: float) -> HeightMap:
    """The lowest of the triangles at each point of a grid."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    sides = np.floor((high - low)[:2] / step * (1 + _EDGE)) + 1
    if not (sides >= 2).all() or sides[0] > _MOST / sides[1]:
        seen = (
            f"a mesh of {1e3 * (high - low)[0]:.4g} by {1e3 * (high - low)[1]:.4g} mm at a pitch of {1e3 * step:.4g} mm"
        )
        rule = f"that makes {sides[0]:.4g} by {sides[1]:.4g} points, and 2 by 2 to {_MOST:.0e} are handled"
        raise FileError(f"{file}: {seen}", rule, "another pitch or unit")
    counts = sides.astype(int)
    middle = 0.5 * (low + high)[:2]
    axes = [step * (np.arange(count) - 0.5 * (count - 1)) for count in counts]
    out = np.full(counts, np.inf)
    for triangle in corners - np.append(middle, low[2]):
        _lower(out, axes, triangle)
    if not np.isfinite(out).any():
        raise FileError(f"{file}: no triangle covers a point of the map", "a body has heights", "a finer pitch")
    return HeightMap(axes[0], axes[1], out)


def _lower(out: FloatArray, axes: list[npt.NDArray[np.float64]], triangle: FloatArray) -> None:
    """Bring the map down to one triangle."""
    (y0, z0, x0), b, c = triangle
    det = (b[0] - y0) * (c[1] - z0) - (c[0] - y0) * (b[1] - z0)
    size = np.ptp(triangle[:, 0]) * np.ptp(triangle[:, 1])
    if abs(det) <= 1e-12 * size or not size:  # seen from above it is a line
        return
    parts = []
    for axis, nodes in enumerate(axes):
        slack = _EDGE * abs(float(nodes[-1]))
        first = int(np.searchsorted(nodes, triangle[:, axis].min() - slack))
        parts.append(slice(first, int(np.searchsorted(nodes, triangle[:, axis].max() + slack, side="right"))))
    y, z = axes[0][parts[0]][:, None] - y0, axes[1][parts[1]] - z0
    s = (y * (c[1] - z0) - z * (c[0] - y0)) / det
    t = (z * (b[0] - y0) - y * (b[1] - z0)) / det
    inside = (s >= -_EDGE) & (t >= -_EDGE) & (s + t <= 1 + _EDGE)
    height = x0 + s * (b[2] - x0) + t * (c[2] - x0)
    part = out[parts[0], parts[1]]
    np.minimum(part, np.where(inside, height, np.inf), out=part)
