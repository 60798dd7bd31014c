from __future__ import annotations

import numpy as np
import pytest

from roboguitarist.exercises import KINDS, ExerciseConfig
from roboguitarist.fingering import assign
from roboguitarist.fretting import planner
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.training import practice

TASK = TaskConfig("guided", lead_s=0.5)
SHORT = ExerciseConfig(duration_s=2.0)


def test_the_same_seed_draws_the_same_exercises_and_another_seed_others():
    first, again, other = (practice.exercises(20, seed) for seed in (1, 1, 2))
    assert first == again
    assert len(first) == 20
    assert not set(first) & set(other)


def test_no_exercise_of_the_exam_is_ever_practised():
    low, _ = practice.PRACTICE_SEEDS
    assert practice.EXAM_SEED + practice.EXAMS <= low


def test_plans_of_several_processes_are_those_of_one(monkeypatch):
    monkeypatch.setattr(practice, "EXERCISE", SHORT)
    tablatures = list(practice.exercises(3, 5).values())
    found = practice.planned(tablatures, TASK, workers=2)
    for tablature, plan in zip(tablatures, found, strict=True):
        np.testing.assert_array_equal(plan.ctrl, planner.plan(assign(tablature), TASK.scene()).ctrl)


@pytest.mark.slow
def test_the_exam_judges_every_kind_and_the_same_each_time(monkeypatch):
    monkeypatch.setattr(practice, "EXAMS", 1)
    monkeypatch.setattr(practice, "EXERCISE", SHORT)
    evaluate = practice.examiner(TASK)
    first, again = evaluate(None), evaluate(None)
    assert first == again
    assert {f"exam/{kind}/{what}" for kind in KINDS for what in ("frame", "onset")} < set(
        first.scalars
    )
    assert all(0 <= value <= 1 for value in first.scalars.values())
    assert 0.5 < first.score < 1
