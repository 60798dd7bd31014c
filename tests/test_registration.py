import subprocess
import sys

import gymnasium as gym
import pytest

from roboguitarist import formats, pieces
from roboguitarist.fretting.env import FrettingEnv
from roboguitarist.registration import ids, register


def test_every_piece_has_an_environment_and_fretting_takes_any():
    names = ids()
    assert sorted(names.values()) == sorted([*pieces.names(), "twinkle"])
    assert names["RoboGuitarist/Fretting-v0"] == "twinkle"
    assert names["RoboGuitarist/Twinkle-v0"] == "twinkle"
    assert all(name.startswith("RoboGuitarist/") and name.endswith("-v0") for name in names)


def test_registering_again_changes_nothing():
    before = {name: gym.registry[name] for name in ids()}
    register()
    assert all(gym.registry[name] is spec for name, spec in before.items())


@pytest.mark.parametrize("name", ["RoboGuitarist/FurElise-v0", "RoboGuitarist/ChordTransition-v0"])
def test_an_environment_plays_its_piece(name):
    env = gym.make(name).unwrapped
    assert isinstance(env, FrettingEnv)
    piece = formats.load(pieces.path(ids()[name]))
    seconds = env.batch.bank.length[0] / env.batch.config.control_hz - env.batch.config.lead_s
    assert seconds == pytest.approx(piece.duration_s, abs=1 / 30)
    env.close()


def test_without_gymnasium_the_package_still_works():
    code = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "import roboguitarist\n"
        "from roboguitarist.registration import register\n"
        "register()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
