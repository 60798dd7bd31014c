"""Where on the neck a note of given pitch is played: found together with its finger.

Every place of every note is offered to the search for fingers, so that a place is as good as the
way a hand gets there and back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby
from typing import NamedTuple

import numpy as np

from roboguitarist.fingering.costs import HANDS, Costs
from roboguitarist.fingering.given import recurrences
from roboguitarist.fingering.grips import LEFT_OUT, grips
from roboguitarist.fingering.search import search
from roboguitarist.fingering.settings import Setting, setting
from roboguitarist.fingering.terms import form_terms
from roboguitarist.fingering.trellis import Form, Moment
from roboguitarist.tablature import STANDARD_TUNING

N_FRETS = 20
"""Frets of the default guitar, counted from the nut."""
STRETCH = 4
"""Highest minus lowest fret of the notes of one onset, at most."""
N_FINGERS = 4
MAX_CHORD = 24
"""Notes of one onset that are considered at all."""
FORMS_PER_POSITION = 4
"""Forms of a chord that are offered to the search, in each position the cheapest."""
LONG, FORMS_IF_LONG = 2000, 4
"""From so many onsets on, only the so many cheapest forms of each are offered: time is bounded."""
MEMORY = 2


class Place(NamedTuple):
    """A string, 1 to 6, and a fret counted from the capo."""

    string: int
    fret: int


@dataclass(frozen=True, slots=True)
class Sound:
    """A note to place.

    Attributes:
        onset_s, end_s: In seconds.
        pitch: MIDI pitch.
        string, fret: Given in advance, or None.
        finger: Left finger marked in the score: 0 asks for an open string.
    """

    onset_s: float
    end_s: float
    pitch: int
    string: int | None = None
    fret: int | None = None
    finger: int | None = None


def fold(
    pitch: int, tuning: Sequence[int] = STANDARD_TUNING, capo: int = 0, n_frets: int = N_FRETS
) -> int:
    """The same pitch class moved by octaves into the guitar's range."""
    lowest, highest = min(tuning) + capo, max(tuning) + n_frets
    pitch += 12 * max(0, -((pitch - lowest) // 12))
    return pitch - 12 * max(0, -((highest - pitch) // 12))


def arrange(
    sounds: Sequence[Sound],
    tuning: Sequence[int] = STANDARD_TUNING,
    capo: int = 0,
    n_frets: int = N_FRETS,
    costs: Costs = HANDS["robot"],
) -> list[Place | None]:
    """Give every note a string and a fret.

    Notes of one onset take different strings and frets within one hand position. Places given in
    advance are kept.

    Args:
        sounds: Sorted by onset.
        tuning: MIDI pitches of the six open strings, string 1 first.
        capo: Fret of the capo.
        n_frets: Number of frets counted from the nut.
        costs: What makes a fingering hard.

    Returns:
        A place for each note; None where the notes of that onset leave no string in reach. The
        highest and then the lowest note of a chord are the last to go.
    """
    given = [Place(s.string, s.fret) for s in sounds if s.string is not None and s.fret is not None]
    if len(given) == len(sounds):
        return list(given)
    offered = offers(sounds, tuning, capo, n_frets, costs)
    result: list[Place | None] = [None] * len(sounds)
    if not offered:
        return result
    way = search(free_setting(offered, capo), costs, MEMORY)
    first = 0
    for moment, form in zip(offered, way.form, strict=True):
        places, _ = moment.forms[form - first]
        first += len(moment.forms)
        for note, (string, fret) in zip(moment.notes, places, strict=True):
            result[note] = Place(string, fret and fret - capo)
    return result


def free_setting(moments: list[Moment], capo: int) -> Setting:
    """What the search needs to know of moments that leave strings free."""
    return setting(moments, capo if _may_be_open(moments) else None, None, free=True)


def offers(
    sounds: Sequence[Sound],
    tuning: Sequence[int] = STANDARD_TUNING,
    capo: int = 0,
    n_frets: int = N_FRETS,
    costs: Costs = HANDS["robot"],
) -> list[Moment]:
    """Every onset with the forms that are worth trying."""
    frets = range(n_frets - capo + 1)
    open_pitches = [pitch + capo for pitch in tuning]
    end_s = [sound.end_s for sound in sounds]
    again_s = recurrences([(sound.onset_s, sound.pitch, 0) for sound in sounds])
    moments, start = [], 0
    for onset_s, group in groupby(sounds, key=lambda sound: sound.onset_s):
        chord = list(group)
        options = tuple(tuple(_candidates(sound, open_pitches, frets)) for sound in chord)
        given = tuple(s.string is not None and s.fret is not None for s in chord)
        marks = tuple(sound.finger or None for sound in chord)
        chosen, forms = _forms(options, given, tuple(s.pitch for s in chord), marks, capo)
        notes = tuple(start + k for k in chosen)
        ends, again = (tuple(times[k] for k in notes) for times in (end_s, again_s))
        if notes:
            moments.append(Moment(onset_s, notes, ends, again, forms))
        start += len(chord)
    if not moments:
        return moments
    everything = free_setting(moments, capo)
    every = np.arange(everything.forms.first[-1])
    alone = costs.total(form_terms(everything, every))
    return _cheapest(moments, alone, everything.forms.position)


def _may_be_open(moments: list[Moment]) -> bool:
    return any(fret == 0 for m in moments for places, _ in m.forms for _, fret in places)


def _cheapest(moments: list[Moment], cost: np.ndarray, position: np.ndarray) -> list[Moment]:
    """The moments with only the cheapest forms of each position, and few if there are many."""
    most = FORMS_IF_LONG if len(moments) > LONG else None
    result, first = [], 0
    for moment in moments:
        count = len(moment.forms)
        seen: dict[int, int] = {}
        kept = []
        for k in np.argsort(cost[first : first + count], kind="stable"):
            place = int(position[first + k])
            seen[place] = seen.get(place, 0) + 1
            if seen[place] <= FORMS_PER_POSITION:
                kept.append(moment.forms[k])
        result.append(replace(moment, forms=kept[:most]))
        first += count
    return result


def _candidates(sound: Sound, open_pitches: Sequence[int], frets: range) -> list[Place]:
    if sound.string is not None and sound.fret is not None:
        return [Place(sound.string, sound.fret)]
    places = [
        Place(string, sound.pitch - pitch)
        for string, pitch in enumerate(open_pitches, 1)
        if sound.pitch - pitch in frets
    ]
    wanted = [
        place
        for place in places
        if sound.string in (None, place.string) and sound.fret in (None, place.fret)
    ]
    if sound.finger is not None:
        wanted = [p for p in wanted if (p.fret == 0) == (sound.finger == 0)] or wanted
    return wanted or places


@lru_cache(maxsize=1 << 12)
def _forms(
    options: tuple[tuple[Place, ...], ...],
    given: tuple[bool, ...],
    pitches: tuple[int, ...],
    marks: tuple[int | None, ...],
    capo: int,
) -> tuple[tuple[int, ...], list[Form]]:
    """Notes of an onset that are played, and all ways to do it."""
    fixed = [k for k, is_given in enumerate(given) if is_given]
    free = sorted(
        (k for k, is_given in enumerate(given) if not is_given), key=lambda k: -pitches[k]
    )
    wanted = fixed + free[:1] + free[-1:] * (len(free) > 1) + free[1:-1]
    firm = [options[k][0] for k in fixed]
    chosen: list[int] = []
    for k in wanted[:MAX_CHORD]:
        if next(_fits(options, [*chosen, k], firm, marks, capo), None) is not None:
            chosen.append(k)
    forms = list(_fits(options, chosen, firm, marks, capo))
    fewest = min((grip.count(LEFT_OUT) for _, grip in forms), default=0)
    return tuple(chosen), [form for form in forms if form[1].count(LEFT_OUT) == fewest]


def _fits(
    options: Sequence[Sequence[Place]],
    chosen: list[int],
    given: list[Place],
    marks: Sequence[int | None],
    capo: int,
) -> Iterator[Form]:
    """All ways to place the chosen notes on different strings and to stop them.

    Places given in advance may ask for more reach or fingers than a hand has.
    """
    reach = max(STRETCH, _span(given))
    asked = tuple(marks[k] for k in chosen)

    def extend(shape: tuple[Place, ...]) -> Iterator[Form]:
        if len(shape) == len(chosen):
            places = tuple((string, fret and fret + capo) for string, fret in shape)
            for grip in grips(places, asked):
                if LEFT_OUT not in grip or len(given) > 1:
                    yield places, grip
            return
        used = {place.string for place in shape}
        for place in options[chosen[len(shape)]]:
            if place.string not in used and _span([*shape, place]) <= reach:
                yield from extend((*shape, place))

    yield from extend(())


def _span(places: Sequence[Place]) -> int:
    stopped = [place.fret for place in places if place.fret]
    return max(stopped) - min(stopped) if stopped else 0
