import numpy as np
import pytest

from roboguitarist import exercises, formats, pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.episodes import OBSERVATION_LIMIT, FrettingBatch
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

SHORT = Tablature((Note(0.0, 3, 2, 0.3),))
LONG = Tablature((Note(0.0, 1, 7, 0.6), Note(0.6, 6, 3, 0.6)))


def repertoire() -> list[Tablature]:
    config = exercises.ExerciseConfig(duration_s=6.0, highest_fret=20)
    studies = [exercises.generate(kind, 1, config) for kind in exercises.KINDS]
    return [*studies, formats.load(pieces.path("twinkle"))]


def batch(tablatures, n_envs=8, **settings) -> FrettingBatch:
    made = FrettingBatch(tablatures, TaskConfig(**settings), n_envs)
    made.rng = np.random.default_rng(0)
    return made


def random_episodes(made: FrettingBatch, ticks: int) -> np.ndarray:
    rng, seen = np.random.default_rng(0), [made.reset()]
    for tick in range(ticks):
        action = rng.uniform(-1, 1, (made.n_envs, made.n_actions))
        observation, _, ended, _ = made.step(action)
        seen.append(observation)
        if ended.any() or tick % 15 == 14:
            seen.append(made.reset(ended if tick % 15 != 14 else None))
    return np.concatenate(seen)


@pytest.mark.parametrize("string_goal", ["simplified", "one_hot"])
def test_no_element_of_the_observation_is_constant(string_goal):
    made = batch(repertoire(), 48, string_goal=string_goal, random_start=True)
    seen = random_episodes(made, 45)
    assert np.abs(seen).max() < OBSERVATION_LIMIT
    begin = np.cumsum([0, *(block.size for block in made.blocks)])
    for block, low, high in zip(made.blocks, begin, begin[1:], strict=False):
        varies = np.ptp(seen[:, low:high], axis=0) > 1e-4
        if block.name == "keys":
            # A hand that moves at random comes by most keys, but by some of the upper ones not
            # in so short a time: a fret space there is narrow, and fingertips seldom meet it.
            assert varies.mean() > 0.5
        elif block.name == "string_goal" and string_goal == "one_hot":
            # Not every key is asked for by the set, or in the few seconds of these episodes.
            asked = np.isin(np.arange(block.size) % 120, _asked_keys(made))
            assert not varies[~asked].any()
            assert varies.sum() > 0.9 * asked.sum() > 0.5 * block.size
        else:
            assert varies.all(), (block.name, np.flatnonzero(~varies))


def _asked_keys(made: FrettingBatch) -> np.ndarray:
    """Keys, string by string, that any tick of the bank asks for."""
    fret = made.bank.fret.reshape(-1, 6)
    return np.unique(np.concatenate([20 * s + fret[fret[:, s] > 0, s] - 1 for s in range(6)]))


def test_all_tablatures_are_drawn():
    made = batch([SHORT, LONG, SHORT], 64)
    made.reset()
    assert set(made.episode) == {0, 1, 2}


def test_a_reset_concerns_only_what_it_names():
    made = batch([SHORT, LONG], 4)
    made.reset()
    for _ in range(3):
        made.step(np.zeros((4, 20)))
    before, mask = made.observe(), np.array([False, True, False, True])
    after = made.reset(mask)
    assert made.tick.tolist() == [3, 0, 3, 0]
    assert np.array_equal(after[~mask], before[~mask])
    assert not np.array_equal(after[mask], before[mask])


def test_episodes_begin_at_the_beginning_or_anywhere():
    first, anywhere = batch([SHORT, LONG], 200), batch([SHORT, LONG], 200, random_start=True)
    first.reset()
    anywhere.reset()
    assert not first.tick.any()
    for episode, length in enumerate(anywhere.bank.length):
        begun = anywhere.tick[anywhere.episode == episode]
        assert len(set(begun)) > length / 2
        assert begun.max() < length


def test_start_postures_follow_the_hold_position():
    low, high = (batch([Tablature((Note(0.0, 3, fret, 1.0),))], 1) for fret in (2, 12))
    low.reset()
    high.reset()
    guitar = low.config.scene().guitar
    apart = np.abs(low.hands.tip_m[0, :, 0].mean() - high.hands.tip_m[0, :, 0].mean())
    assert apart > 0.5 * (guitar.fret_x(12) - guitar.fret_x(2))


def test_a_short_piece_ends_before_the_padding():
    made = batch([SHORT, LONG], 16)
    made.reset()
    length = made.bank.length[made.episode]
    assert len(set(length)) == 2
    for tick in range(1, max(length) + 1):
        *_, ended, _ = made.step(np.zeros((16, 20)))
        assert np.array_equal(ended, tick >= length)
        assert np.all(made.tick < length)


def test_padding_is_empty_and_pieces_are_not():
    made = batch([SHORT, LONG], 1)
    for episode, length in enumerate(made.bank.length):
        assert made.bank.fret[episode, :length].any()
        assert not made.bank.fret[episode, length:].any()
        assert not made.bank.active[episode, length:].any()


def test_a_failure_ends_that_episode_only(monkeypatch):
    made = batch([LONG], 3)
    made.reset()
    monkeypatch.setattr(made.hands, "step", lambda ctrl: np.array([False, True, False]))
    seen, reward, ended, _ = made.step(np.zeros((3, 20)))
    assert ended.tolist() == [False, True, False]
    assert np.isfinite(seen).all()
    assert np.isfinite(reward).all()


def test_fingers_are_led_to_their_keys():
    made = batch([LONG], 1)
    made.reset()
    made.tick[:] = round(0.5 * 30) + 2
    begin = np.cumsum([0, *(block.size for block in made.blocks)])
    names = [block.name for block in made.blocks]
    fingers = made.observe()[0, begin[names.index("fingers")] :][:12].reshape(4, 3)
    busy = made.observe()[0, begin[names.index("busy")] :][:4].astype(bool)
    assert busy.sum() == 1
    assert not fingers[~busy].any()
    point = made.hands.tip_m[0, busy] + 0.1 * fingers[busy]
    guitar = made.config.scene().guitar
    assert guitar.fret_x(6) < point[0, 0] < guitar.fret_x(7)


def test_the_action_before_is_seen_as_it_was_cut():
    made = batch([SHORT], 2)
    made.reset()
    action = np.linspace(-3, 3, 40).reshape(2, 20)
    seen, reward, _, _ = made.step(action)
    at = sum(block.size for block in made.blocks[:3])
    assert seen[:, at : at + 20] == pytest.approx(np.clip(action, -1, 1), abs=1e-6)
    assert seen[:, at + 20] == pytest.approx(reward, abs=1e-6)


def test_nothing_to_fret_is_refused():
    with pytest.raises(RoboGuitaristError, match="no tablature"):
        FrettingBatch([])


def test_restored_environments_go_on_as_the_others_do():
    first, second = (batch([SHORT, LONG], random_start=True, max_ticks=9) for _ in range(2))
    random_episodes(first, 20)
    second.restore(first.state())
    assert np.array_equal(first.observe(), second.observe())
    assert np.array_equal(random_episodes(first, 20), random_episodes(second, 20))


def test_the_resting_action_keeps_the_hand_about_where_it_begins():
    made = batch([LONG], 1, hand="tendon")
    made.reset()
    begin = made.hands.qpos.copy()
    for _ in range(20):
        made.step(made.task.resting_action()[None])
    model = made.hands.model  # the paper holds the thumb elsewhere, and the forearm lower
    names = [model.joint(index).name for index in range(model.njnt)]
    fingers = [i for i, name in enumerate(names) if "forearm" not in name and "TH" not in name]
    moved = np.abs(made.hands.qpos - begin)[0]
    assert moved[:2].max() < 0.01
    assert moved[fingers].max() < 0.35
    rest = batch([SHORT], 1, task="guided", substeps=16, lead_s=1.0).task.resting_action()
    assert not rest.any()
