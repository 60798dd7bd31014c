import sys
from dataclasses import replace

import pytest

from builders import moving
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.export.usd import write_usd
from roboguitarist.tablature import Note, Tablature

SHORT = Tablature((Note(0.0, 2, 1, 0.5),))


@pytest.mark.slow
def test_a_usdz_file_opens_with_its_pictures_and_moves(tmp_path):
    usd = pytest.importorskip("pxr.Usd", reason="no USD library: pip install usd-core")
    geom = pytest.importorskip("pxr.UsdGeom")
    whole = moving(SHORT)
    few = replace(whole, time_s=whole.time_s[:4], qpos=whole.qpos[:4])
    shares = []
    write_usd(few, tmp_path / "a.usdz", shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    stage = usd.Stage.Open(str(tmp_path / "a.usdz"))
    assert stage.GetTimeCodesPerSecond() == 30
    start, end = int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode())
    assert end - start >= 2
    places = [
        geom.XformCache(time).GetLocalToWorldTransform(prim).ExtractTranslation()
        for time in (start, end)
        for prim in stage.Traverse()
        if "lh_palm_seen" in prim.GetName()
    ]
    assert places
    assert places[0] != places[-1]


def test_without_the_library_one_line_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    monkeypatch.delitem(sys.modules, "mujoco.usd.exporter", raising=False)
    with pytest.raises(RoboGuitaristError, match=r"pip install 'roboguitarist\[usd\]'"):
        write_usd(moving(SHORT), tmp_path / "a.usdz")
    assert not list(tmp_path.iterdir())
