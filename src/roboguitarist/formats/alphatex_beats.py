"""Words, notes and beats of alphaTex."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_marks import DYNAMICS
from roboguitarist.formats.note_values import dotted
from roboguitarist.tablature import MAX_BEND, Technique

_SPACE = re.compile(r"(\s+|//[^\n]*|/\*.*?\*/)*", re.DOTALL)
_WORD = re.compile(r"\\?[A-Za-z#][A-Za-z0-9#]*")
_NUMBER = re.compile(r"-?\d{1,6}(\.\d{1,6})?")
_INTEGER = re.compile(r"-?\d{1,6}")
_STRING = re.compile(r'"([^"]*)"|\'([^\']*)\'')
_DURATIONS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
_NOTE_EFFECTS = {
    "v": Technique.VIBRATO, "vw": Technique.VIBRATO, "pm": Technique.PALM_MUTE,
    "lr": Technique.LET_RING, "nh": Technique.HARMONIC, "ah": Technique.ARTIFICIAL_HARMONIC,
    "th": Technique.ARTIFICIAL_HARMONIC, "ph": Technique.ARTIFICIAL_HARMONIC,
    "sh": Technique.ARTIFICIAL_HARMONIC, "st": Technique.STACCATO, "tr": Technique.TRILL,
    "x": Technique.DEAD, "sou": Technique.SLIDE_OUT, "sod": Technique.SLIDE_OUT,
    "sib": Technique.SLIDE_IN, "sia": Technique.SLIDE_IN, "b": Technique.BEND,
    "be": Technique.BEND, "tp": Technique.TREMOLO, "bu": Technique.STRUM_UP,
    "bd": Technique.STRUM_DOWN, "au": Technique.STRUM_UP, "ad": Technique.STRUM_DOWN,
    "rasg": Technique.RASGUEADO,
}  # fmt: skip
_IGNORED = {"g", "ac", "hac", "ten", "t", "tt", "txt", "ch", "su", "sd", "f", "fo", "vs", "spd",
            "spu", "s", "p", "lyrics", "string", "hide", "psu", "psd", "slur", "fermata", "tempo",
            "cre", "dec", "accfrc", "tb", "tbe", "beam", "timer", "barre"}  # fmt: skip
_LEFT = {1: None, 2: 1, 3: 2, 4: 3, 5: 4}
_RIGHT = {1: "p", 2: "i", 3: "m", 4: "a", 5: "c"}
_MAX_REPEATS = 1000


class Scanner:
    """The text and how far it has been read."""

    def __init__(self, text: str) -> None:
        self._text, self._at = text, 0

    def _skip(self) -> None:
        found = _SPACE.match(self._text, self._at)
        self._at = found.end() if found else self._at

    def at_end(self) -> bool:
        """Whether nothing is left."""
        self._skip()
        return self._at >= len(self._text)

    def peek(self) -> str:
        """The next sign, empty at the end."""
        self._skip()
        return self._text[self._at : self._at + 1]

    def take(self, sign: str) -> bool:
        """Read a sign if it is the next one."""
        self._skip()
        if not self._text.startswith(sign, self._at):
            return False
        self._at += len(sign)
        return True

    def follows(self, sign: str) -> bool:
        """Read a sign if it is the next one without space before."""
        if not self._text.startswith(sign, self._at):
            return False
        self._at += len(sign)
        return True

    def take_dot(self) -> bool:
        """Read the lone dot that ends the head of a piece."""
        return self.take(".")

    def _match(self, pattern: re.Pattern[str]) -> str | None:
        self._skip()
        found = pattern.match(self._text, self._at)
        if found is None:
            return None
        self._at = found.end()
        return found[0]

    def word(self) -> str:
        """A word, without the backslash before it.

        Raises:
            TabError: If there is none.
        """
        found = self._match(_WORD)
        if found is None:
            raise self.error()
        return found.lstrip("\\")

    def words(self) -> list[str]:
        """Words up to the next sign, in parentheses or not."""
        inside = self.take("(")
        found = []
        while re.match(r"[A-Za-z]", self.peek()):
            found.append(self.word())
        if inside:
            self.take(")")
        return found

    def string(self) -> str:
        """A text in quotation marks, empty if there is none."""
        found = self._match(_STRING)
        return found[1:-1][:200] if found else ""

    def argument(self) -> str:
        """A text, word or number in any number; the first is returned."""
        first = ""
        while True:
            found = self._match(_STRING) or self._match(re.compile(r"[A-Za-z][A-Za-z0-9]*|\(.*?\)"))
            if found is None:
                found = self._match(re.compile(r"-?\d+(?![.\d])")) if not first else None
            if found is None:
                return first
            first = first or found.strip("\"'")[:200]

    def number(self, name: str) -> Fraction:
        """A number.

        Raises:
            TabError: If there is none.
        """
        inside = self.take("(")
        found = self._match(_NUMBER)
        if found is None:
            raise TabError(f"{name} without a number, but {self.peek()!r}")
        if inside:
            self._match(re.compile(r"[^)]{0,200}\)"))
        return Fraction(found)

    def integer(self) -> int | None:
        """A whole number, if one comes next."""
        found = self._match(_INTEGER)
        return None if found is None else int(found)

    def duration(self) -> Fraction:
        """Length in quarter notes of a duration such as 8.

        Raises:
            TabError: If it is none.
        """
        found = self.integer()
        if found not in _DURATIONS:
            raise TabError(f"duration {found}", hint="1, 2, 4, 8, 16, 32 or 64")
        return Fraction(4, found)

    def endings(self) -> frozenset[int]:
        """Numbers of an ending, one or several in parentheses."""
        inside = self.take("(")
        found = set()
        while (number := self.integer()) is not None:
            found.add(number)
            if not inside:
                break
        if inside:
            self.take(")")
        return frozenset(found)

    def braces(self) -> str:
        """What stands in braces, empty if there are none."""
        found = self._match(re.compile(r"\{[^{}]{0,1000}\}"))
        return found[1:-1] if found else ""

    def error(self) -> TabError:
        """What cannot be read here."""
        return TabError(f"{self._text[self._at : self._at + 12]!r} is no alphaTex that is read")


@dataclass
class Sign:
    """A note; a fret of None continues the note before on its string."""

    string: int
    fret: int | None
    techniques: set[Technique] = field(default_factory=set)
    bend: tuple[tuple[float, float], ...] = ()
    left_finger: int | None = None
    right_finger: str | None = None
    slurs: bool = False
    slides: bool = False


@dataclass
class Beat:
    """Notes that begin together; lengths in quarter notes, without and with dots and tuplets."""

    notes: list[Sign]
    plain_length: Fraction
    length: Fraction
    techniques: set[Technique] = field(default_factory=set)
    velocity: int | None = None
    grace: bool = False


def read_beat(scan: Scanner, length: Fraction) -> tuple[Beat, int]:
    """Read a note, a chord or a rest, and how often it is written in short.

    Args:
        scan: Where to read.
        length: Length in quarter notes unless the beat says another.

    Raises:
        TabError: If there is none.
    """
    notes: list[Sign] = []
    if scan.take("("):
        while not scan.take(")"):
            notes.append(_note(scan))
            _note_effects(notes[-1:], scan.braces())
    elif scan.take("r"):
        pass
    else:
        notes.append(_note(scan))
    beat = Beat(notes, length, length)
    _effects(beat, scan.braces())
    if scan.follows("."):
        beat.plain_length = beat.length = scan.duration()
    while scan.peek() == "{":
        inside = scan.braces()
        if not inside:
            raise scan.error()
        _effects(beat, inside)
    times = 1
    if scan.take("*"):
        times = scan.integer() or 1
        if not 0 < times <= _MAX_REPEATS:
            raise TabError(f"a beat {times} times", hint=f"1 to {_MAX_REPEATS}")
    return beat, times


def _note(scan: Scanner) -> Sign:
    dead = scan.take("x") or scan.take("X")
    tied = not dead and scan.peek() == "-" and scan.take("-.")
    fret = 0 if dead else None if tied else scan.integer()
    if not tied and (fret is None or not scan.follows(".")):
        raise scan.error()
    string = scan.integer()
    if string is None:
        raise scan.error()
    return Sign(string, fret, {Technique.DEAD} if dead else set())


def _effects(beat: Beat, inside: str) -> None:
    """Take over effects of a beat and of its notes."""
    words = _split(inside)
    for name, numbers in words:
        match name:
            case "d" | "dd":
                beat.length = dotted(beat.plain_length, len(name))
            case "tu":
                actual = numbers[0] if numbers else 3
                normal = numbers[1] if len(numbers) > 1 else _normal(actual)
                if not 0 < actual <= 64 or not 0 < normal <= 64:
                    raise TabError(f"tuplet of {actual}")
                beat.length = beat.length * normal / actual
            case "gr":
                beat.grace = True
            case "dy":
                pass
            case _ if name.startswith("dy "):
                beat.velocity = DYNAMICS.get(name[3:])
    _note_effects(beat.notes, inside)


def _normal(actual: int) -> int:
    """How many plain notes take the time of a tuplet: the next lower power of two."""
    return 1 << max(0, actual.bit_length() - 1 - (actual & (actual - 1) == 0))


def _note_effects(notes: list[Sign], inside: str) -> None:
    for name, numbers in _split(inside):
        for note in notes:
            _note_effect(note, name, numbers)


def _note_effect(note: Sign, name: str, numbers: list[int]) -> None:
    match name:
        case "h":
            note.slurs = True
        case "sl" | "ss":
            note.slides = True
        case "lf":
            note.left_finger = _LEFT.get(numbers[0] if numbers else 0)
        case "rf":
            note.right_finger = _RIGHT.get(numbers[0] if numbers else 0)
        case _ if name in _NOTE_EFFECTS:
            note.techniques.add(_NOTE_EFFECTS[name])
            if name in ("b", "be"):
                note.bend = _curve(numbers, exact=name == "be")


def _curve(numbers: list[int], *, exact: bool) -> tuple[tuple[float, float], ...]:
    """A bend in quarter tones: heights at even distances, or pairs of sixtieths and heights."""
    if exact:
        points = {
            min(1.0, max(0.0, x / 60)): y for x, y in zip(numbers[::2], numbers[1::2], strict=False)
        }
    else:
        last = max(1, len(numbers) - 1)
        points = {k / last: height for k, height in enumerate(numbers)}
    return tuple(
        (round(share, 4), min(float(MAX_BEND), max(0.0, height / 2)))
        for share, height in sorted(points.items())
    )


def _split(inside: str) -> list[tuple[str, list[int]]]:
    """Names of effects with the numbers behind them.

    Raises:
        TabError: On a name that alphaTex has not.
    """
    found: list[tuple[str, list[int]]] = []
    for token in re.findall(r'"[^"]*"|[A-Za-z]+|-?\d{1,6}', inside):
        if token.startswith('"'):
            continue
        if token.lstrip("-").isdecimal():
            if found:
                found[-1][1].append(int(token))
        elif found and found[-1][0] == "dy":
            found[-1] = (f"dy {token.lower()}", [])
        else:
            found.append((token.lower(), []))
    known = {*_NOTE_EFFECTS, *_IGNORED, "h", "sl", "ss", "lf", "rf", "d", "dd", "tu", "gr", "dy"}
    strange = [name for name, _ in found if name not in known and not name.startswith("dy ")]
    after = {"be", "b", "gr", "tr", "ch", "txt", "dy", "barre", "tu", "tempo", "fermata"}
    if strange and not any(name in after for name, _ in found):
        raise TabError(f"effect {strange[0][:20]!r} is not read")
    return found
