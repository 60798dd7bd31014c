import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from roboguitarist import exercises
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.env import FrettingEnv
from roboguitarist.fretting.episodes import OBSERVATION_LIMIT, FrettingBatch
from roboguitarist.fretting.guided import ALOFT, CORRECTIONS, FINGERS, WEIGHTS
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4), Note(0.8, 1, 0, 0.2)))
GUIDED = {"task": "guided", "substeps": 16, "lead_s": 1.0}


def batch(tablatures, n_envs=4, **settings) -> FrettingBatch:
    made = FrettingBatch(tablatures, TaskConfig(**{**GUIDED, **settings}), n_envs)
    made.rng = np.random.default_rng(0)
    made.reset()
    return made


@pytest.fixture(scope="module")
def tune() -> FrettingBatch:
    return batch([TUNE])


def test_without_correction_the_servos_follow_the_plan(tune):
    tune.reset()
    nothing = np.zeros((4, tune.n_actions))
    ctrl = tune.task.ctrl(nothing, nothing, tune.hands, tune.at)
    assert ctrl.shape[:2] == (4, 8)
    assert ctrl[0] == pytest.approx(tune.task.guide.ctrl[0, 0], abs=1e-6)


def test_a_correction_moves_targets_evenly_and_by_no_more_than_it_may(tune):
    tune.reset()
    nothing, full = np.zeros((4, tune.n_actions)), np.full((4, tune.n_actions), 5.0)
    moved, still = (tune.task.ctrl(a, nothing, tune.hands, tune.at) for a in (full, nothing))
    moved -= still
    most = np.zeros(moved.shape[2])
    most[tune.task._servos] = list(CORRECTIONS.values())
    assert (moved <= most + 1e-6).all()
    x = tune.hands.model.actuator("lh_A_forearm_x").id
    assert moved[0, :, x] == pytest.approx(CORRECTIONS["forearm_x"] * np.arange(1, 9) / 8)
    thumb = tune.hands.model.actuator("lh_A_THJ4").id
    assert not moved[..., thumb].any()


def test_what_the_hand_misses_is_added_to_the_targets(tune):
    tune.reset()
    nothing = np.zeros((4, tune.n_actions))
    joint = tune.hands.model.joint("lh_MFJ3").qposadr[0]
    servo = tune.hands.model.actuator("lh_A_MFJ3").id
    before = tune.task.ctrl(nothing, nothing, tune.hands, tune.at)
    tune.hands.qpos[:, joint] -= 0.05
    after = tune.task.ctrl(nothing, nothing, tune.hands, tune.at)
    assert (after - before)[:, :, servo] == pytest.approx(0.05, abs=1e-6)
    assert np.delete(after - before, servo, axis=2) == pytest.approx(0.0)
    # A correction moves the place that the hand is held to, too.
    at_plan = np.full((4, tune.n_actions), 0.1)
    held = tune.task.ctrl(at_plan, at_plan, tune.hands, tune.at) - after
    wrist = tune.hands.model.actuator("lh_A_WRJ1").id
    assert held[0, 0, wrist] == pytest.approx(2 * 0.1 * CORRECTIONS["WRJ1"])


def test_a_finger_that_is_down_is_corrected_in_full_and_one_in_the_air_hardly(tune):
    tune.reset()
    tune.tick[:] = 36  # the first note is held by one finger
    finger = int(np.flatnonzero(tune.bank.active[0, 36])[0])
    full, nothing = np.full((4, tune.n_actions), 0.1), np.zeros((4, tune.n_actions))
    moved = tune.task.ctrl(full, full, tune.hands, tune.at)
    moved -= tune.task.ctrl(nothing, nothing, tune.hands, tune.at)
    for index, name in enumerate(FINGERS):
        servo = tune.hands.model.actuator(f"lh_A_{name}J4").id
        share = 1.0 if index == finger else ALOFT
        # Added once as a correction and once as what the hand misses of it.
        assert moved[0, 0, servo] == pytest.approx(
            2 * 0.1 * share * CORRECTIONS[f"{name}J4"], rel=0.02
        )


def test_the_reward_is_shared_among_the_fingers_that_earn_it(tune):
    tune.reset()
    tune.tick[:] = 36  # the first note is held by one finger
    tune.hands.put(np.arange(4), tune.task.start(tune.at))
    parts, terms = tune.task.reward(tune.hands, tune.at, np.zeros((4, tune.n_actions)))
    weighted = sum(WEIGHTS[name] * values for name, values in terms.items())
    assert parts.sum(axis=1) == pytest.approx(weighted)
    finger = int(np.flatnonzero(tune.bank.active[0, 36])[0])
    assert parts[0, finger] > 0
    assert not np.delete(parts[0, :4], finger).any()
    assert tune.task.groups.tolist() == [4] * 5 + [3] + [f for f in range(4) for _ in range(3)]


def test_the_plan_alone_plays_the_tune_and_is_paid_for_it(tune):
    tune.reset()
    playing, ended = [], np.zeros(4, bool)
    while not ended.any():
        _, reward, ended, terms = tune.step(np.zeros((4, tune.n_actions)))
        assert all(((term >= 0) & (term <= 1)).all() for term in terms.values())
        assert ((reward >= 0) & (reward <= 1)).all()
        playing.append(terms["playing"][0])
    assert np.mean(playing) > 0.85
    far = np.ones((4, tune.n_actions))
    tune.reset()
    wrong = [tune.step(far)[3]["playing"][0] for _ in range(len(playing))]
    assert np.mean(wrong) < np.mean(playing) - 0.1


def test_observed_keys_lead_the_fingers(tune):
    tune.reset()
    tune.tick[:] = 32
    begin = np.cumsum([0, *(block.size for block in tune.blocks)])
    place = {block.name: slice(*begin[i : i + 2]) for i, block in enumerate(tune.blocks)}
    seen = tune.observe()[0]
    busy = seen[place["busy"]].astype(bool)
    assert busy.sum() == 1
    way = 0.02 * np.arctanh(seen[place["to_key"]].reshape(4, 3)[busy][0].astype(float))
    guitar = tune.config.scene().guitar
    at = tune.hands.tip_m[0, busy][0] + way
    assert guitar.fret_x(1) < at[0] < guitar.fret_x(2)
    assert at[1] == pytest.approx(float(guitar.string_y(3, at[0])), abs=1e-4)
    assert seen[place["stopped"]].tolist() == [0, 0, 1, 0, 0, 0]


def test_a_guided_episode_ends_after_its_ticks():
    made = batch([TUNE], max_ticks=5)
    ends = [made.step(np.zeros((4, made.n_actions)))[2].all() for _ in range(5)]
    assert ends == [False] * 4 + [True]


@pytest.mark.parametrize("hand", ["linkage", "tendon"])
@pytest.mark.filterwarnings("ignore:.*not within the observation space.*")
def test_gymnasium_accepts_the_guided_task(hand):
    check_env(FrettingEnv(TUNE, hand=hand, **GUIDED), skip_render_check=True)


@pytest.mark.slow
def test_no_element_of_the_observation_is_constant():
    config = exercises.ExerciseConfig(duration_s=4.0)
    studies = [exercises.generate(kind, 3, config) for kind in exercises.KINDS]
    made = batch(studies, 64, random_start=True)
    rng, seen = np.random.default_rng(0), []
    for tick in range(60):
        observation, _, ended, _ = made.step(rng.uniform(-1, 1, (64, made.n_actions)))
        seen.append(observation)
        made.reset(ended if tick % 20 else None)
    every = np.concatenate(seen)
    assert np.abs(every).max() <= OBSERVATION_LIMIT
    begin = np.cumsum([0, *(block.size for block in made.blocks)])
    for block, low, high in zip(made.blocks, begin, begin[1:], strict=False):
        if block.name.endswith("span"):  # only the index finger and a ring finger lie flat
            high = low + 1  # noqa: PLW2901
        varies = np.ptp(every[:, low:high], axis=0) > 1e-4
        assert varies.all(), (block.name, np.flatnonzero(~varies))


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"task": "other"}, "no task"), ({"lead_s": 2.0}, "lead_s")],
)
def test_settings_that_do_not_fit_are_refused(settings, message):
    with pytest.raises(RoboGuitaristError, match=message):
        batch([TUNE], **settings)
