"""`subskin afferents`: a table of rates, the ranking, its files, and what it refuses."""

import csv
import json

import numpy as np
import pytest

from subskin.afferents import Stimulus, strain_at


@pytest.fixture
def stimulus(folder):
    """Rates of a receptor that answers to the maximum compressive strain 0.7 mm deep; lengths in mm."""
    rng = np.random.default_rng(0)
    lines = ["shape,width,gap,position,rate"]
    for shape, width, gap in (("grating", 0.5, 1.0), ("grating", 0.5, 3.0), ("bar", 1.5, ""), ("edge", "", "")):
        for y in rng.uniform(-1.5, 1.5, 10):
            one = Stimulus(shape, *(1e-3 * (v or 0.0) for v in (width, gap)))
            strain = float(strain_at(one, 1e-3 * y, 0.7e-3, "max_compressive_strain"))
            lines.append(f"{shape},{width},{gap},{y:.4f},{max(0.0, 200 * strain - 20 + rng.normal(0, 1)):.3f}")
    (folder / "stimulus.csv").write_text("\n".join(lines) + "\n")
    return folder


def test_strains_are_ranked_and_rates_written(stimulus, subskin):
    done = subskin("afferents", "stimulus.csv", "--unit", "mm", "-o", "fitted.csv", "--figure", "fitted.png")
    assert done.code == 0
    assert "40 rates, best first" in done.out
    assert done.out.index("maximum compressive strain") < done.out.index("strain energy density")
    rows = list(csv.DictReader((stimulus / "fitted.csv").read_text().splitlines()))
    assert len(rows) == 40
    assert np.abs([float(row["rate"]) - float(row["max_compressive_strain"]) for row in rows]).mean() < 2.0
    assert (stimulus / "fitted.png").stat().st_size > 10_000


def test_json_says_the_same_and_a_depth_is_kept(stimulus, subskin):
    done = subskin("afferents", "stimulus.csv", "--unit", "mm", "--depth", "0.7 mm", "--json")
    found = json.loads(done.out)
    assert found["rows"] == 40
    assert found["fits"][0]["measure"] == "max_compressive_strain"
    assert found["fits"][0]["r2"] > 0.99
    assert found["fits"][0]["slope"] == pytest.approx(200, rel=0.02)
    assert {fit["depth"] for fit in found["fits"]} == {0.7e-3}


def test_a_period_alone_is_a_grating_whose_half_is_bar(folder, subskin):
    (folder / "g.csv").write_text("period,rate\n1,5\n2,30\n4,60\n6,70\n")
    done = subskin("afferents", "g.csv", "--unit", "mm", "--depth", "0.7 mm", "--json")
    assert done.code == 0
    assert json.loads(done.out)["rows"] == 4


@pytest.mark.parametrize(
    ("table", "arguments", "said"),
    [
        ("width,position\n1,0\n", (), "rate"),
        ("shape,width,rate\nball,1,2\nbar,1,3\nbar,2,4\n", (), "line 2"),
        ("shape,width,rate\ngrating,1,2\nbar,1,3\nbar,2,4\n", (), "line 2"),
        ("width,rate\n1,2\n2,3\n3,4\n", ("--unit", "kg"), "--unit"),
        ("width,rate\n1,2\n2,3\n", (), "at least 3"),
    ],
)
def test_what_it_refuses(folder, subskin, table, arguments, said):
    (folder / "bad.csv").write_text(table)
    done = subskin("afferents", "bad.csv", *(arguments or ("--unit", "mm")))
    assert done.code == 2
    assert said in done.err
    assert len(done.err.splitlines()) <= 2
