"""The weights that come with the package: the published ones, and worth what their card says."""

from __future__ import annotations

import hashlib
from importlib import resources

import numpy as np
import pytest

from roboguitarist import exercises, policies
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import assign
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.metrics import evaluate
from roboguitarist.performance import PerformConfig, perform
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.5), Note(0.5, 2, 1, 0.5)))


def test_every_variant_with_weights_loads_and_fits_the_task_of_today():
    assert policies.names() == ("linkage",)
    for hand in policies.names():
        policy = policies.load(hand)
        assert (policy.task, policy.hand) == ("guided", hand)
        batch = FrettingBatch([TUNE], policy.task_config())
        seen = batch.reset()
        acted = policy.act(seen)
        assert acted.shape == (1, batch.n_actions)
        assert np.abs(acted).max() < 1


def test_a_hand_without_weights_is_told_what_there_is():
    with pytest.raises(RoboGuitaristError, match=r"there are linkage.*'planner' needs none"):
        policies.load("tendon")


def test_other_weights_than_the_published_ones_are_refused(monkeypatch):
    path = resources.files(policies) / "linkage.npz"
    found = hashlib.sha256(path.read_bytes()).hexdigest()
    assert policies._checksums()["linkage"] == found
    monkeypatch.setattr(policies, "_checksums", lambda: {"linkage": found[::-1]})
    with pytest.raises(RoboGuitaristError, match="checksum"):
        policies.load("linkage")


@pytest.mark.slow
def test_the_policy_corrects_what_the_planner_gets_wrong_in_mixed_music():
    settings = exercises.ExerciseConfig(duration_s=8.0)
    scores = {"planner": 0.0, "policy": 0.0}
    for controller in scores:
        for seed in (1000, 1001):
            fingering = assign(exercises.generate(exercises.Kind.MIXED, seed, settings))
            found = evaluate(perform(fingering, PerformConfig(controller=controller)))
            assert found.note is not None
            scores[controller] += found.note.f1 / 2
    assert scores["policy"] > scores["planner"] + 0.05
