import subprocess
import sys

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from roboguitarist.errors import RoboGuitaristError  # noqa: E402
from roboguitarist.training import checkpoint  # noqa: E402

STATE = {
    "steps": 3,
    "text": "abc",
    "array": np.arange(4.0),
    "flags": np.array([True, False]),
    "nested": {"tensor": torch.ones(2), 0: {"list": [1, 2.5]}},
}


def test_saved_is_loaded(tmp_path):
    checkpoint.save(tmp_path / "a.pt", STATE)
    again = checkpoint.load(tmp_path / "a.pt")
    assert again["steps"] == 3
    assert again["text"] == "abc"
    assert again["array"].numpy().tolist() == [0, 1, 2, 3]
    assert again["flags"].numpy().tolist() == [True, False]
    assert again["nested"]["tensor"].tolist() == [1, 1]
    assert again["nested"][0] == {"list": [1, 2.5]}
    assert [path.name for path in tmp_path.iterdir()] == ["a.pt"]


@pytest.mark.parametrize("data", [b"", b"no checkpoint", b"PK\x03\x04 broken"])
def test_another_file_is_refused(tmp_path, data):
    (tmp_path / "a.pt").write_bytes(data)
    with pytest.raises(RoboGuitaristError, match="not a checkpoint"):
        checkpoint.load(tmp_path / "a.pt")


def test_code_in_a_checkpoint_is_not_executed(tmp_path):
    class Bad:
        def __reduce__(self):
            return (open, (str(tmp_path / "made"), "w"))

    torch.save({"x": Bad()}, tmp_path / "a.pt")
    with pytest.raises(RoboGuitaristError, match="not a checkpoint"):
        checkpoint.load(tmp_path / "a.pt")
    assert not (tmp_path / "made").exists()


FULL = """
import resource, sys, numpy as np
from roboguitarist.training import checkpoint
from roboguitarist.errors import RoboGuitaristError
checkpoint.save(sys.argv[1], {"steps": 1})
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    checkpoint.save(sys.argv[1], {"steps": 2, "much": np.zeros(1_000_000)})
except RoboGuitaristError as error:
    print(error)
"""


def test_where_no_more_can_be_written_the_old_checkpoint_stays(tmp_path):
    path = tmp_path / "a.pt"
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(path)], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith(f"cannot write {path}: File too large")
    assert checkpoint.load(path) == {"steps": 1}
    assert [left.name for left in tmp_path.iterdir()] == ["a.pt"]
