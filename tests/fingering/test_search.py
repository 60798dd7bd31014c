import random
import resource
import time
from dataclasses import replace
from functools import partial
from itertools import accumulate

import numpy as np
import pytest
from exhaustive import Piece
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.fingering import assign as assign_by
from roboguitarist.fingering.costs import HANDS, Costs
from roboguitarist.fingering.given import moments
from roboguitarist.fingering.search import search, way_terms
from roboguitarist.fingering.settings import setting
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature

steady = settings(deadline=None)
assign = partial(assign_by, method="search")

MEMORY = 3
WEIGHTS = st.sampled_from([0.0, 0.25, 0.5, 1.0, 1.5, 3.0])


@st.composite
def pieces(draw: st.DrawFn, *, most: int = 6, lowest: int = 0) -> Tablature:
    """Up to six notes, some together, some held over the next."""
    gaps = st.sampled_from([0.0, 0.0, 0.07, 0.15, 0.4, 1.0])
    count = draw(st.integers(1, most))
    onsets = list(accumulate(draw(gaps) for _ in range(count)))
    notes: dict[tuple[float, int], Note] = {}
    for onset_s in onsets:
        string = draw(st.integers(1, 6))
        fret = draw(st.integers(lowest, 7))
        mark = draw(st.sampled_from([None, None, None, 1, 2, 3, 4]))
        length_s = draw(st.sampled_from([0.05, 0.15, 0.5, 2.0]))
        key = round(onset_s, 6), string
        notes[key] = Note(*key, fret, length_s, left_finger=mark)
    return Tablature(tuple(sorted(notes.values(), key=lambda note: note.place)))


@st.composite
def weights(draw: st.DrawFn) -> Costs:
    return replace(Costs(), **{name: draw(WEIGHTS) for name in draw(st.sets(NAMES, max_size=6))})


NAMES = st.sampled_from([name for name in Costs.__dataclass_fields__ if name != "left_out"])


@steady
@given(pieces(), weights(), st.booleans())
def test_no_way_is_cheaper_than_the_one_found(tablature: Tablature, costs: Costs, nut: bool):
    onsets = moments(tablature, Guitar())
    nut_fret = 0 if nut else None
    way = search(setting(onsets, nut_fret, None), costs, MEMORY)
    every = list(Piece(onsets, nut_fret, costs, MEMORY).all_ways())
    assert way.cost.sum() == pytest.approx(min(map(sum, every)), abs=0.02)
    numbers = np.cumprod([1, *(len(m.forms) for m in onsets[:0:-1])])[::-1]
    firsts = np.cumsum([0, *(len(m.forms) for m in onsets[:-1])])
    same = every[int(((way.form - firsts) * numbers).sum())]
    assert way.cost.tolist() == pytest.approx(same, abs=0.02)


@settings(steady, max_examples=30)
@given(pieces(most=5), weights())
def test_no_way_has_an_easier_hardest_moment(tablature: Tablature, costs: Costs):
    onsets = moments(tablature, Guitar())
    way = search(setting(onsets, 0, None), costs, MEMORY, hardest=True)
    every = list(Piece(onsets, 0, costs, MEMORY).all_ways())
    easiest = min(map(max, every))
    assert way.cost.max() == pytest.approx(easiest, abs=0.02)
    assert (
        way.cost.sum() <= min(sum(c) for c in every if max(c) <= easiest - 0.02) + 0.05
        if any(max(c) <= easiest - 0.02 for c in every)
        else True
    )


@steady
@given(pieces(most=12, lowest=1))
def test_one_fret_up_leaves_the_fingers_as_they_were(tablature: Tablature):
    higher = tuple(replace(note, fret=note.fret + 1) for note in tablature.notes)
    low, high = assign(tablature), assign(replace(tablature, notes=higher))
    assert low.left.tolist() == high.left.tolist()
    assert low.barre.tolist() == high.barre.tolist()


@steady
@given(pieces(most=12))
def test_the_terms_of_a_way_add_up_to_its_cost(tablature: Tablature):
    everything = setting(moments(tablature, Guitar()), 0, None)
    way = search(everything, HANDS["robot"], MEMORY)
    total = HANDS["robot"].total(way_terms(everything, way))
    assert total.tolist() == pytest.approx(way.cost.tolist(), abs=0.01)


def fast_piece(count: int) -> Tablature:
    """Sixteen notes a second, chords among them."""
    generator = random.Random(0)
    notes: list[Note] = []
    onset_s = 0.0
    while len(notes) < count:
        size = generator.choice([1, 1, 1, 1, 2, 3, 4])
        base = 1 + (len(notes) // 50) % 7
        for string in sorted(generator.sample(range(1, 7), size)):
            fret = generator.choice([0, base, base + 1, base + 2, base + 3])
            notes.append(Note(round(onset_s, 6), string, fret, generator.choice([0.1, 0.4])))
        onset_s += size / 16
    return Tablature(tuple(notes[:count]))


def test_ten_thousand_fast_notes_take_less_than_three_seconds():
    tablature = fast_piece(10_000)
    start_s = time.process_time()
    fingering = assign(tablature)
    assert time.process_time() - start_s < 3.0
    assert len(fingering.left) == 10_000
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 1_000_000
