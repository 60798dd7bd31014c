import csv

import numpy as np

from builders import moving
from roboguitarist import export, replay
from roboguitarist.tablature import Note, Tablature


def test_the_table_has_every_tick_and_every_joint_with_its_unit(tmp_path):
    performance = moving(Tablature((Note(0.0, 2, 1, 0.5),)))
    export.write_joints(performance, tmp_path / "joints.csv")
    with (tmp_path / "joints.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    model = replay.scene(performance)
    assert header[:3] == ["time_s", "lh_forearm_x_m", "lh_forearm_y_m"]
    assert "lh_FFJ3_rad" in header
    assert len(header) == 1 + model.nq == len(set(header))
    values = np.array(rows, float)
    np.testing.assert_allclose(values[:, 0], performance.time_s, atol=1e-6)
    np.testing.assert_allclose(values[:, 1:], performance.qpos, atol=1e-6)
