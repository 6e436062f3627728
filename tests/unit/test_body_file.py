"""Bodies from files: meshes, tables, arrays, images."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from subskin.errors import FileError, InvalidValueError
from subskin.io import read_body

AT = np.linspace(-1.0, 1.0, 9)  # mm


def dome_mesh():
    """Triangles of a coarse dome, z = r^2 / 4 mm, and of its lid at 1 mm."""
    y, z = np.meshgrid(AT, AT, indexing="ij")
    triangles = []
    for x in ((y**2 + z**2) / 4, np.ones_like(y)):
        p = np.stack([y, z, x], axis=-1)
        a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
        triangles += [np.stack([a, b, c], axis=-2).reshape(-1, 3, 3), np.stack([a, c, d], axis=-2).reshape(-1, 3, 3)]
    return np.concatenate(triangles)


def write_binary(path, triangles):
    facets = [struct.pack("<12fH", *(0.0,) * 3, *corners.reshape(-1), 0) for corners in triangles]
    path.write_bytes(b"a dome".ljust(80) + struct.pack("<I", len(facets)) + b"".join(facets))


def write_ascii(path, triangles):
    lines = ["solid dome"]
    for corners in triangles:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += [f"  vertex {a:.9g} {b:.9g} {c:.9g}" for a, b, c in corners] + ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid dome"]))


@pytest.mark.parametrize("write", [write_binary, write_ascii])
def test_a_mesh(tmp_path, write):
    write(tmp_path / "dome.STL", dome_mesh())
    body = read_body(tmp_path / "dome.STL", pitch=0.25e-3)
    at = 1e-3 * AT
    assert body.height(at[:, None], at) == pytest.approx((at[:, None] ** 2 + at**2) / 4e-3, abs=1e-10)
    inches = read_body(tmp_path / "dome.STL", pitch=25.4 * 0.25e-3, unit=25.4e-3)
    assert inches.ends[0][1] == pytest.approx(25.4e-3)


def test_where_a_mesh_ends_there_is_no_body(tmp_path):
    write_binary(tmp_path / "one.stl", np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0]]], dtype=float))
    body = read_body(tmp_path / "one.stl", pitch=0.1e-3)
    assert np.isfinite(body.height(-0.5e-3, -0.5e-3))
    assert np.isinf(body.height(0.5e-3, 0.5e-3))


def test_tables_arrays_and_images(tmp_path):
    heights = np.array([[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]])
    np.save(tmp_path / "a.npy", 1e-4 * heights)
    (tmp_path / "a.csv").write_text("0, 0.1, 0.2\n0.1, , 0.3\n")
    from matplotlib.image import imsave

    imsave(tmp_path / "a.png", heights / 3, cmap="gray", vmin=0, vmax=1)
    array, table = read_body(tmp_path / "a.npy", pitch=1e-3), read_body(tmp_path / "a.csv", pitch=1e-3, unit=1e-3)
    image = read_body(tmp_path / "a.png", pitch=1e-3, height=3e-4)
    for body in (array, image):
        assert body.height([[-0.5e-3], [0.5e-3]], [-1e-3, 0.0, 1e-3]) == pytest.approx(1e-4 * heights, abs=2e-6)
    assert table.height(0.5e-3, 1e-3) == pytest.approx(3e-4)
    assert np.isinf(table.height(0.5e-3, 0.0))


def test_what_is_refused(tmp_path):
    (tmp_path / "a.stl").write_text("solid nothing\nendsolid")
    (tmp_path / "b.stl").write_bytes(b"x" * 84 + b"\x01")
    (tmp_path / "a.csv").write_text("one two\n")
    (tmp_path / "a.obj").write_text("")
    for name in ("a.stl", "b.stl", "a.csv", "a.obj", "absent.npy"):
        with pytest.raises(FileError, match=name):
            read_body(tmp_path / name, pitch=1e-3)
    write_binary(tmp_path / "c.stl", dome_mesh())
    with pytest.raises(FileError, match="another pitch or unit"):
        read_body(tmp_path / "c.stl", pitch=1e-8)
    with pytest.raises(InvalidValueError, match="how high"):
        read_body(tmp_path / "a.png", pitch=1e-3)


DAMAGED = {
    "a.csv": [
        b"y,z\n1,2\n3,4\n", b"1,2\n3,x\n", b"0,1;0,2\n0,3;0,4\n", b"1,2\n3\n", b"", b"# none\n", b"1 2\n3 -inf\n",
    ],
    "a.npy": [b"", b"\x93NUMPY\x01\x00\x46\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1 << 50, 9)}\n"],
    "a.png": [b"", b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x00\xff\xff\x00\x00\xff\xff\x08\x00\x00\x00\x00"],
    "a.stl": [
        b"", b"x" * 200, b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 100, b"solid\n" + b"vertex 0 0\n" * 9 + b"endsolid",
        b"solid\n" + b"vertex 0 0 1 2\n" * 9 + b"endsolid", b"solid\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 2",
        b"solid\nvertex nan 0 0\nvertex 2 0 0\nvertex 0 2 0\nendsolid",
    ],
}  # fmt: skip


@pytest.mark.parametrize(("name", "data"), [(name, data) for name, each in DAMAGED.items() for data in each])
def test_damaged_files_are_said(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FileError, match=name):
        read_body(tmp_path / name, pitch=1e-3, height=1e-3)


@pytest.mark.parametrize("array", [np.ones((3, 3), complex), np.full((3, 3), "1"), np.zeros((3, 3), "M8[s]")])
def test_arrays_that_are_no_real_numbers_are_refused(tmp_path, array):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(FileError, match="real numbers"):
        read_body(tmp_path / "a.npy", pitch=1e-3)
    np.savez(tmp_path / "a.npz", array)
    with pytest.raises(FileError, match="several arrays"):
        read_body((tmp_path / "a.npz").rename(tmp_path / "b.npy"), pitch=1e-3)


def test_a_mesh_cut_off_or_beyond_all_bounds_is_said(tmp_path):
    write_ascii(tmp_path / "a.stl", dome_mesh())
    text = (tmp_path / "a.stl").read_text()
    (tmp_path / "cut.stl").write_text(text[: text.index("facet", len(text) // 2)])  # whole triangles, half of them
    with pytest.raises(FileError, match="without an end"):
        read_body(tmp_path / "cut.stl", pitch=0.25e-3)
    (tmp_path / "shout.stl").write_text(text.upper() + "\n\n")
    assert np.isfinite(read_body(tmp_path / "shout.stl", pitch=0.25e-3).height(0.0, 0.0))
    write_binary(tmp_path / "far.stl", 1e38 * dome_mesh())
    with pytest.raises(FileError, match="another pitch or unit"):
        read_body(tmp_path / "far.stl", pitch=1e-3)
    write_binary(tmp_path / "short.stl", dome_mesh())
    (tmp_path / "short.stl").write_bytes((tmp_path / "short.stl").read_bytes()[:-7])
    with pytest.raises(FileError, match="12884 bytes for the 256 triangles"):
        read_body(tmp_path / "short.stl", pitch=0.25e-3)


@pytest.mark.parametrize("path", [None, 3, b"a.npy", np.ones(3), open])
def test_no_path_is_said(path):
    with pytest.raises(InvalidValueError, match="for a path"):
        read_body(path, pitch=1e-3)
