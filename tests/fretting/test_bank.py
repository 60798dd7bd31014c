import numpy as np
import pytest

from roboguitarist.fretting.bank import HORIZON_S, fill, fingered, padded
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 0, 0.4), Note(1.0, 3, 4, 0.2)))
SHORT = Tablature((Note(0.0, 1, 1, 0.1),), capo=1)


@pytest.fixture(scope="module")
def bank():
    return fill(fingered([TUNE, SHORT]), TaskConfig(control_hz=10.0, lead_s=0.5))[0]


def test_open_strings_are_asked_too(bank):
    # Half a second of lead, then ticks of a tenth.
    assert bank.asked[0, 5:9, 2].all()
    assert bank.asked[0, 9:13, 1].all()
    assert not bank.asked[0, 9:15, 2].any()
    assert not bank.fret[0, :, 1].any()


def test_times_count_down(bank):
    assert bank.until_onset_s[0, :5, 2] == pytest.approx([0.5, 0.4, 0.3, 0.2, 0.1])
    assert bank.until_onset_s[0, 5, 2] == pytest.approx(1.0)
    assert bank.next_fret[0, 5, 2] == 4
    assert (bank.until_onset_s[0, :, 5] == HORIZON_S).all()
    finger = int(np.flatnonzero(bank.active[0, 5])[0])
    assert bank.left_s[0, 5:9, finger] == pytest.approx([0.4, 0.3, 0.2, 0.1])
    assert not bank.left_s[0, :5].any()


def test_pieces_end_where_they_end(bank):
    assert bank.length.tolist() == [17, 6]
    assert bank.capo.tolist() == [0, 1]
    assert not bank.active[1, 6:].any()
    assert bank.last((np.array([0, 1]), np.array([16, 6]))).tolist() == [False, True]


def test_padding_keeps_what_is_there():
    rows = padded([np.ones((2, 3)), np.ones((4, 3))])
    assert rows.shape == (2, 4, 3)
    assert rows.sum(axis=(1, 2)).tolist() == [6, 12]
