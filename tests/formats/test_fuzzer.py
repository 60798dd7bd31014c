import importlib.util
import random
import sys
from pathlib import Path

import pytest
from score_files import FILES

from roboguitarist.formats import detection

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "fuzz_readers.py"
SPEC = importlib.util.spec_from_file_location("fuzz_readers", SCRIPT)
assert SPEC is not None
assert SPEC.loader is not None
fuzzer = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = fuzzer  # where dataclasses look for it
SPEC.loader.exec_module(fuzzer)


@pytest.mark.parametrize("name", FILES)
def test_no_mutated_file_hangs_or_fails_but_with_our_error(name):
    tally = fuzzer.Tally()
    fuzzer.fuzz([FILES[name]()], range(150), name, tally)
    assert tally.faults == {}
    assert tally.read + tally.refused == tally.inputs == 150


def test_faults_are_found(monkeypatch):
    def broken(data, suffix):
        if len(data) % 2:
            raise KeyError("x")
        while True:
            pass

    monkeypatch.setattr(detection, "read", broken)
    assert fuzzer.fault(b"abc") == "KeyError: 'x'"
    assert fuzzer.fault(b"ab", seconds=0.05) == "more than 0.05 s"
    tally = fuzzer.Tally()
    fuzzer.fuzz([b"abc"], range(9), 0, tally)
    assert tally.faults


def test_mutations_change_the_data_and_depend_on_the_seed_only():
    data = FILES["a.mxl"]()
    made = [fuzzer.mutated(data, data, random.Random(seed)) for seed in range(50)]
    again = [fuzzer.mutated(data, data, random.Random(seed)) for seed in range(50)]
    assert made == again
    assert len(set(made)) > 40
