"""The repertoire: public-domain pieces as MusicXML tabs, the benchmark's eight first."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from roboguitarist.errors import RoboGuitaristError


@dataclass(frozen=True, slots=True)
class Piece:
    """One piece of the repertoire.

    Attributes:
        name: What the command line calls it, the stem of its file.
        title: As printed.
        composer: With years of birth and death where they are known, else where it comes from.
        source: What the arrangement was made from.
        grade: `beginner 1` (single notes, slow) to `beginner 3` (two voices, or quick).
        file: File name in this folder.
    """

    name: str
    title: str
    composer: str
    source: str
    grade: str
    file: str


PIECES = (
    Piece(
        name="twinkle",
        title="Twinkle, Twinkle, Little Star",
        composer="Traditional (France)",
        source="Ah! vous dirai-je, maman, French air, printed in 1761",
        grade="beginner 1",
        file="twinkle.musicxml",
    ),
    Piece(
        name="scales-practice",
        title="Scales Practice",
        composer="Traditional exercise",
        source="Major scales of C and G in open position",
        grade="beginner 1",
        file="scales-practice.musicxml",
    ),
    Piece(
        name="long-long-ago",
        title="Long, Long Ago",
        composer="Thomas Haynes Bayly (1797-1839)",
        source="Song written in 1833, printed in the 1840s",
        grade="beginner 2",
        file="long-long-ago.musicxml",
    ),
    Piece(
        name="fur-elise",
        title="Für Elise",
        composer="Ludwig van Beethoven (1770-1827)",
        source="Bagatelle in A minor WoO 59, 1810, opening section, one octave lower",
        grade="beginner 3",
        file="fur-elise.musicxml",
    ),
    Piece(
        name="happy-birthday",
        title="Happy Birthday",
        composer="Mildred J. Hill (1859-1916) and Patty S. Hill (1868-1946)",
        source="Good Morning to All, Song Stories for the Kindergarten, 1893",
        grade="beginner 3",
        file="happy-birthday.musicxml",
    ),
    Piece(
        name="farewell",
        title="Farewell (Auld Lang Syne)",
        composer="Traditional (Scotland)",
        source="Scots air printed with the words of Robert Burns "
        "in Thomson's Select Collection, 1799",
        grade="beginner 3",
        file="farewell.musicxml",
    ),
    Piece(
        name="red-river-valley",
        title="Red River Valley",
        composer="Traditional (North America)",
        source="Folk song of the nineteenth century, printed by 1896",
        grade="beginner 3",
        file="red-river-valley.musicxml",
    ),
    Piece(
        name="chord-transition",
        title="Chord Transition",
        composer="Traditional exercise",
        source="Common open-position chords in C major and A minor",
        grade="beginner 2",
        file="chord-transition.musicxml",
    ),
)
"""All pieces in the order of the repertoire."""


def names() -> tuple[str, ...]:
    """Names of all pieces in the order of the repertoire."""
    return tuple(piece.name for piece in PIECES)


def find(name: str) -> Piece:
    """Piece of that name.

    Raises:
        RoboGuitaristError: If there is none; the message lists the names and the nearest one.
    """
    for piece in PIECES:
        if piece.name == name:
            return piece
    near = get_close_matches(name.lower(), names(), n=1)
    guess = f"did you mean {near[0]}? " if near else ""
    raise RoboGuitaristError(f"no piece {name!r} ({guess}there are {', '.join(names())})")


def path(name: str) -> Path:
    """Path of the MusicXML file of the piece of that name.

    Raises:
        RoboGuitaristError: As `find`.
    """
    return Path(__file__).parent / find(name).file
