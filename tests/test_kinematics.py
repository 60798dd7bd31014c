from __future__ import annotations

from dataclasses import replace

import mink
import mujoco
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from roboguitarist.hands import VARIANTS, Variant
from roboguitarist.ik_tasks import ClearanceTask, SeparationTask, TipTask
from roboguitarist.kinematics import Solver, TipPaths, follow
from roboguitarist.scene import SceneConfig, build

FINGERS = ("ff", "mf", "rf", "lf")
TIPS = tuple(f"lh_{finger}tip" for finger in FINGERS)
LINKS = tuple(
    tuple(f"lh_{finger}{link}" for link in ("proximal", "middle", "distal")) for finger in FINGERS
)
KNUCKLES = tuple((f"lh_{finger}{link}", 0.009) for finger in FINGERS for link in ("middle",))
seeds = st.integers(0, 2**31)
variants = pytest.mark.parametrize("hand", VARIANTS)


def solver(hand: Variant = "linkage", **settings) -> Solver:
    """The left hand with weak springs to its rest posture and no other wish."""
    model = build(SceneConfig(hand=hand, sides=("left",), visuals=False))
    return Solver(model, TIPS, np.full(model.nv, 0.03), **settings)


def playing(model: mujoco.MjModel) -> np.ndarray:
    """A hand over the strings at the fifth fret, its fingers curled."""
    qpos = model.qpos0.copy()
    for index in range(model.njnt):
        bends = {"FJ3": 0.5, "FJ2": 1.0, "FJ1": 1.0}
        qpos[index] = bends.get(model.joint(index).name[-3:], 0.0)
    qpos[:3] = 0.15, 0.0, 0.01
    return qpos


def near(model: mujoco.MjModel, seed: int, spread: float) -> np.ndarray:
    """A random posture near `playing`, within the ranges, with J1 = J2."""
    rng = np.random.default_rng(seed)
    low, high = model.jnt_range.T
    scale = np.where(np.arange(model.nq) < 3, 0.1, 1.0) * spread
    qpos = np.clip(playing(model) + scale * rng.uniform(-1, 1, model.nq), low + 0.02, high - 0.02)
    for finger in ("FF", "MF", "RF", "LF"):
        qpos[model.joint(f"lh_{finger}J1").id] = qpos[model.joint(f"lh_{finger}J2").id]
    return qpos


def tips(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return np.array([data.site(name).xpos for name in TIPS])


def paths(
    targets: np.ndarray, rest: np.ndarray, weight: float = 100.0, aloft: float | None = None
) -> TipPaths:
    """Paths of T samples towards targets (T, 4, 3) from one rest posture."""
    shape = targets.shape[:2]
    lifted = None if aloft is None else np.full(shape, aloft)
    return TipPaths(targets, np.full(shape, weight), np.tile(rest, (len(targets), 1)), lifted)


def slopes(task: mink.Task, model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Derivative (errors, nv) of a task's error by central differences."""
    step, columns = 1e-6, []
    for joint in range(model.nv):
        shift = step * np.eye(model.nv)[joint]
        ends = [
            task.compute_error(mink.Configuration(model, qpos + sign * shift)) for sign in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2 * step))
    return np.stack(columns, axis=1)


@settings(max_examples=15, deadline=None)
@given(seeds)
def test_the_jacobian_of_separation_is_the_derivative_of_its_error(seed):
    hand = solver(apart=LINKS, clearance_m=0.012)
    task, qpos = SeparationTask(hand), near(hand.model, seed, 0.4)
    configuration = mink.Configuration(hand.model, qpos)
    error = task.compute_error(configuration)
    assume((error < 0).any())
    assert np.all(error <= 0)
    np.testing.assert_allclose(
        task.compute_jacobian(configuration), slopes(task, hand.model, qpos), atol=1e-4
    )


@settings(max_examples=25, deadline=None)
@given(seeds, st.floats(0.0, 0.12))
def test_the_jacobian_of_clearance_is_the_derivative_of_its_error(seed, y):
    hand = solver(knuckles=KNUCKLES, over_m=0.02)
    task, qpos = ClearanceTask(hand), near(hand.model, seed, 0.3)
    task.aloft = np.array([1.0, 0.3, 0.0, 1.0])
    qpos[1:3] = y, -0.01
    configuration = mink.Configuration(hand.model, qpos)
    points = [configuration.data.body(name).xpos for name, _ in KNUCKLES]
    beyond_m = np.array([*points, *tips(hand.model, qpos)])[:, 1] - hand.half_width_m
    # Where the demand fades, the Jacobian is documented to be another.
    clear = (beyond_m < -0.0051) | (beyond_m > 1e-4)
    error = task.compute_error(configuration)
    assert np.all(error <= 0)
    assert not error[beyond_m > 0].any()
    difference = task.compute_jacobian(configuration) - slopes(task, hand.model, qpos)
    np.testing.assert_allclose(difference[clear], 0, atol=1e-4)


@variants
def test_reachable_targets_are_reached(hand):
    wanted = solver(hand)
    rest = playing(wanted.model)
    targets = np.stack([tips(wanted.model, near(wanted.model, seed, 0.2)) for seed in range(12)])
    postures = follow(wanted, paths(targets, rest))
    reached = np.stack([tips(wanted.model, qpos) for qpos in postures])
    assert np.linalg.norm(reached - targets, axis=2).max() < 2e-4


def test_the_error_falls_with_every_iteration():
    wanted = solver()
    rest = playing(wanted.model)
    for seed in range(5):
        target = tips(wanted.model, near(wanted.model, seed, 0.2))[None]
        errors = [np.linalg.norm(tips(wanted.model, rest) - target)]
        for iterations in (1, 2, 3):
            few = replace(wanted, iterations=iterations)
            qpos = follow(few, paths(target, rest))[0]
            errors.append(np.linalg.norm(tips(wanted.model, qpos) - target))
        assert np.all(np.diff(errors) < 0)


def test_no_iteration_makes_the_whole_cost_greater():
    wanted = solver(apart=LINKS, apart_cost=60.0, clearance_m=0.004)
    rest = playing(wanted.model)
    entangled = tips(wanted.model, rest)[[1, 0, 3, 2]][None]  # neighbours change places
    cost = []
    for iterations in range(1, 16):
        configuration = mink.Configuration(
            wanted.model, follow(replace(wanted, iterations=iterations), paths(entangled, rest))[0]
        )
        miss = 100.0 * (tips(wanted.model, configuration.q) - entangled)
        apart = 60.0 * SeparationTask(wanted).compute_error(configuration)
        sprung = 0.03 * (configuration.q - rest)
        cost.append(sum(np.sum(term**2) for term in (miss, apart, sprung)))
    assert np.all(np.diff(cost) <= 1e-9)
    assert cost[-1] < 0.5 * cost[0]


@settings(max_examples=10, deadline=None)
@given(seeds, st.sampled_from(VARIANTS))
def test_limits_are_never_crossed_and_the_linkage_never_broken(seed, hand):
    wanted, rng = solver(hand), np.random.default_rng(seed)
    rest = playing(wanted.model)
    far = tips(wanted.model, rest) + rng.normal(0, 0.05, (4, 4, 3))  # out of reach as often as not
    postures = follow(wanted, paths(far, rest))
    low, high = wanted.model.jnt_range.T
    assert np.all((low - 1e-6 <= postures) & (postures <= high + 1e-6))
    if hand == "linkage":
        outer, inner = (
            [wanted.model.joint(f"lh_{f.upper()}J{k}").id for f in FINGERS] for k in (1, 2)
        )
        np.testing.assert_allclose(postures[:, outer], postures[:, inner], atol=1e-3)


@settings(max_examples=5, deadline=None)
@given(seeds)
def test_where_the_targets_stand_still_the_joints_do_too(seed):
    wanted = solver()
    rest = playing(wanted.model)
    target = tips(wanted.model, near(wanted.model, seed, 0.2))
    postures = follow(wanted, paths(np.repeat(target[None], 6, axis=0), rest))
    settled = postures[2:]
    np.testing.assert_array_equal(settled, np.broadcast_to(settled[0], settled.shape))
    np.testing.assert_allclose(postures[0], settled[0], atol=0.01)


def test_a_rest_posture_out_of_the_ranges_is_no_obstacle():
    wanted = solver()
    rest = playing(wanted.model)
    target = tips(wanted.model, rest)[None]
    beyond = rest.copy()
    beyond[wanted.model.joint("lh_WRJ2").id] = 1.0
    beyond[1] = 0.3
    qpos = follow(wanted, paths(target, beyond))[0]
    assert np.linalg.norm(tips(wanted.model, qpos) - target[0], axis=1).max() < 1e-3


def test_the_same_again_gives_the_same_joints():
    targets = np.stack([tips(solver().model, near(solver().model, k, 0.3)) for k in range(4)])
    rest = playing(solver().model)
    first, second = (follow(solver(apart=LINKS), paths(targets, rest)) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_without_weight_the_hand_goes_where_its_posture_leads():
    wanted = solver()
    rest = playing(wanted.model)
    elsewhere = tips(wanted.model, rest)[None] + 0.1
    postures = follow(wanted, paths(elsewhere, near(wanted.model, 1, 0.2), weight=0.0))
    np.testing.assert_allclose(postures[0], near(wanted.model, 1, 0.2), atol=1e-3)


def test_neighbouring_fingers_are_pushed_apart():
    close = tips(solver().model, playing(solver().model))[None].copy()
    close[0, 1, :2] = close[0, 0, :2] + (0.012, 0)  # fingertips are 13 mm thick
    gaps = []
    for apart in ((), LINKS):
        wanted = solver(apart=apart, apart_cost=300.0)
        qpos = follow(wanted, paths(close, playing(wanted.model)))[0]
        gap = SeparationTask(solver(apart=LINKS, clearance_m=0.0))
        gaps.append(gap.compute_error(mink.Configuration(wanted.model, qpos)).min())
    assert gaps[0] < -5e-4
    assert gaps[1] > 0.5 * gaps[0]


@pytest.mark.parametrize(("aloft", "lifted"), [(1.0, True), (0.0, False)])
def test_only_fingers_that_are_aloft_stay_off_the_strings(aloft, lifted):
    wanted = solver(knuckles=KNUCKLES, apart_cost=300.0)
    rest = playing(wanted.model)
    low = tips(wanted.model, rest)[None].copy()
    low[..., 2] = wanted.tip_radius_m
    height = tips(wanted.model, follow(wanted, paths(low, rest, 30.0, aloft))[0])[:, 2]
    assert np.all((height > wanted.tip_radius_m + 0.8 * wanted.over_m) == lifted)


def test_a_change_of_what_is_aloft_alone_is_followed():
    wanted = solver(knuckles=KNUCKLES, apart_cost=300.0)
    rest = playing(wanted.model)
    low = tips(wanted.model, rest)
    low[:, 2] = wanted.tip_radius_m
    still = paths(np.repeat(low[None], 6, axis=0), rest, 30.0, 0.0)
    assert still.aloft is not None
    still.aloft[4:] = 1.0
    height = np.array([tips(wanted.model, qpos)[:, 2] for qpos in follow(wanted, still)])
    assert np.all(height[-1] > height[3] + 0.8 * wanted.over_m)


def test_fingers_are_drawn_to_point_where_they_are_asked_to():
    target = tips(solver().model, playing(solver().model))[None]
    angles = []
    for cost in (0.0, 1.0):
        wanted = solver(pointing=(0.0, 0.0, -1.0), pointing_cost=cost)
        data = mujoco.MjData(wanted.model)
        data.qpos[:] = follow(wanted, paths(target, playing(wanted.model)))[0]
        mujoco.mj_kinematics(wanted.model, data)
        angles.append([data.site(name).xmat[8] for name in TIPS])
    assert np.mean(angles[1]) < np.mean(angles[0]) < 0


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_the_pull_of_a_flat_finger_has_the_slope_of_its_error(seed):
    hand = solver(knuckles=KNUCKLES)
    task, qpos = ClearanceTask(hand), near(hand.model, seed, 0.3)
    task.aloft, task.flat = np.zeros(4), np.array([1.0, 0.0, 0.0, 0.0])
    qpos[2] = 0.06  # the other fingers are high enough
    configuration = mink.Configuration(hand.model, qpos)
    error, jacobian = task.compute_error(configuration), task.compute_jacobian(configuration)
    assert error[0] != 0
    np.testing.assert_allclose(jacobian[0], slopes(task, hand.model, qpos)[0], atol=1e-4)


def test_a_flat_finger_lies_on_the_strings_with_its_joints():
    knuckles = tuple((f"lh_{f}{link}", 0.009) for f in FINGERS for link in ("middle", "distal"))
    hand = solver(knuckles=knuckles, pointing_cost=0.3)
    rest = playing(hand.model)
    target = tips(hand.model, rest)
    target[0] = 0.15, -0.022, 0.0073
    flat = np.array([[1.0, 0.0, 0.0, 0.0]])
    weight = np.array([[100.0, 1.0, 1.0, 1.0]])
    wanted = TipPaths(target[None], weight, rest[None], np.zeros((1, 4)), flat)
    posture = follow(hand, wanted)[0]
    data = mujoco.MjData(hand.model)
    data.qpos[:] = posture
    mujoco.mj_kinematics(hand.model, data)
    heights = [data.body(f"lh_ff{link}").xpos[2] for link in ("middle", "distal")]
    assert heights == pytest.approx([0.0098] * 2, abs=0.0015)
    assert tips(hand.model, posture)[0] == pytest.approx(target[0], abs=0.001)


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_the_jacobian_of_the_tips_is_the_derivative_of_their_error(seed):
    hand, rng = solver(room_pull=0.1), np.random.default_rng(seed)
    task, qpos = TipTask(hand), near(hand.model, seed, 0.3)
    room = np.sort(rng.uniform(-0.02, 0.02, (4, 2)), axis=1) * [[1, 1], [1, 1], [0, 0], [1, 1]]
    target = tips(hand.model, qpos) + rng.uniform(-0.02, 0.02, (4, 3))
    task.aim(target, np.ones(4), room)
    off = (tips(hand.model, qpos) - target)[:, 0]
    assume(np.abs(off[:, None] - room).min() > 1e-5)
    jacobian = task.compute_jacobian(mink.Configuration(hand.model, qpos))
    np.testing.assert_allclose(jacobian, slopes(task, hand.model, qpos), atol=1e-4)


@given(st.floats(-0.03, 0.03))
def test_room_lowers_the_price_of_being_off_and_nothing_beyond_it(off_m):
    hand = solver(room_pull=0.1)
    configuration = mink.Configuration(hand.model, playing(hand.model))
    target = tips(hand.model, configuration.q) - [off_m, 0.0, 0.0]
    task = TipTask(hand)
    task.aim(target, np.ones(4), np.tile([-0.01, 0.005], (4, 1)))
    error = task.compute_error(configuration).reshape(4, 3)
    within = np.clip(off_m, -0.01, 0.005)
    np.testing.assert_allclose(error[:, 0], 0.1 * within + (off_m - within), atol=1e-9)
    np.testing.assert_allclose(error[:, 1:], 0.0, atol=1e-9)


def test_two_fingers_for_one_place_share_the_room_along_the_string():
    hand = solver(apart=LINKS, apart_cost=60.0)
    rest = playing(hand.model)
    wanted = tips(hand.model, rest)
    wanted[1] = wanted[0] + [0.002, 0.010, 0.0]
    crowded = paths(wanted[None], rest)
    spread = replace(crowded, room_m=np.tile([-0.012, 0.012], (1, 4, 1)))
    off_string = []
    for one in (crowded, spread):
        reached = tips(hand.model, follow(hand, one)[0])
        off_string.append(np.linalg.norm((reached - wanted)[:2, 1:], axis=1).max())
    assert off_string[1] < 0.5 * off_string[0]
