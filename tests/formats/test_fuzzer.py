import importlib.util
import random
from pathlib import Path

import pytest
from score_files import FILES

from roboguitarist.formats import detection

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "fuzz_readers.py"
SPEC = importlib.util.spec_from_file_location("fuzz_readers", SCRIPT)
assert SPEC is not None
assert SPEC.loader is not None
fuzzer = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(fuzzer)


@pytest.mark.parametrize("name", FILES)
def test_no_mutated_file_hangs_or_fails_but_with_our_error(name):
    assert fuzzer.fuzz([FILES[name]()], 150, random.Random(name), seconds=5.0) == []


def test_faults_are_found(monkeypatch):
    def broken(data, suffix):
        if len(data) % 2:
            raise KeyError("x")
        while True:
            pass

    monkeypatch.setattr(detection, "read", broken)
    faults = dict(fuzzer.fuzz([b"ab", b"abc"], 20, random.Random(0), seconds=0.05))
    assert set(faults) == {"KeyError: 'x'", "more than 0.05 s"}


def test_mutations_change_the_data_and_depend_on_the_seed_only():
    data = FILES["a.mxl"]()
    made = [fuzzer.mutated(data, data, random.Random(seed)) for seed in range(50)]
    again = [fuzzer.mutated(data, data, random.Random(seed)) for seed in range(50)]
    assert made == again
    assert len(set(made)) > 40
