"""A bonded layer under a point force against reference values of 16 digits, found with 45.

Real functions of the distance from the load, for a layer of thickness 1; displacements times 2 G.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import subskin as ss

LOADS = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.375, -0.25)]


@pytest.mark.parametrize("load", LOADS, ids=["press", "drag", "both"])
@pytest.mark.parametrize("nu", [0.5, 0.45, 0.3125])
def test_bonded_layer(nu, load, shared):
    points = [p for p in json.loads((shared / "reference/15_layer_3d.json").read_text())["points"] if p["nu"] == nu]
    t = {name: np.array([float(p[name]) for p in points]) for name in points[0]}
    n, tau, e = load[0], load[1] + 1j * load[2], np.exp(0.7j)
    back = np.conj(tau) * e
    expected = [
        n * t["n_xx"] + back.real * t["t_xx"],
        n * t["n_tr"] + back.real * t["t_tr"],
        n * e * t["n_sh"] + tau * t["t_sh0"] + back * e * t["t_sh2"],
        n * e**2 * t["n_df"] + tau * e * t["t_df1"] + back * e**2 * t["t_df3"],
        n * t["n_ux"] + back.real * t["t_ux"],
        n * e * t["n_us"] + tau * t["t_us0"] + back * e * t["t_us2"],
    ]
    skin = ss.Layered(ss.Layer(ss.Material(2 * (1 + nu), nu), thickness=1.0))
    at = t["r"] * e
    state = skin.state(ss.PointLoad(components=load), t["d"], at.real, at.imag)
    s, u = state.stress, state.displacement
    seen = [s.xx, s.yy + s.zz, s.xy + 1j * s.xz, s.yy - s.zz + 2j * s.yz, 2 * u.x, 2 * (u.y + 1j * u.z)]
    for part in (slice(0, 4), slice(4, 6)):
        size = np.abs(expected[part]).max(axis=0)
        assert (np.abs(np.array(seen[part]) - np.array(expected[part])).max(axis=0) < 1e-12 * size).all()
