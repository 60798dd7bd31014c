"""Which part of a score is played."""

from __future__ import annotations

from roboguitarist.errors import TabError
from roboguitarist.formats.written import WrittenPart, WrittenScore
from roboguitarist.tablature import N_STRINGS


def choose(score: WrittenScore, track: int | str | None) -> tuple[WrittenPart, tuple[str, ...]]:
    """The part that is asked for, else the first playable one, those with a tab staff first.

    Args:
        score: All parts.
        track: Number of the part from 1, its name, or None.

    Returns:
        The part, and a warning if it was chosen among several.

    Raises:
        TabError: If there is no such part or it cannot be played; the message says why.
    """
    if track is not None:
        part = _asked(score.parts, track)
        if _obstacle(part):
            raise TabError(f"cannot be played: {_obstacle(part)}", part=part.name)
        return part, ()
    playable = [part for part in score.parts if not _obstacle(part)]
    if not playable:
        raise TabError(f"no part can be played: {_why(score.parts)}")
    part = next((part for part in playable if part.has_places), playable[0])
    if len(score.parts) == 1:
        return part, ()
    number = next(k for k, other in enumerate(score.parts, 1) if other is part)
    return part, (f"part {number} ({part.name}) of {len(score.parts)} is played",)


def _asked(parts: tuple[WrittenPart, ...], track: int | str) -> WrittenPart:
    for number, part in enumerate(parts, 1):
        if str(track).strip().casefold() in (str(number), part.name.casefold()):
            return part
    listed = ", ".join(f"{k} {part.name}" for k, part in enumerate(parts[:12], 1))
    raise TabError(f"no part {track!r}", hint=f"there are {listed}")


def _obstacle(part: WrittenPart) -> str:
    if part.obstacle:
        return part.obstacle
    n_strings = part.n_strings or (len(part.tuning) if part.tuning else N_STRINGS)
    if n_strings != N_STRINGS:
        return f"it has {n_strings} strings, not {N_STRINGS}"
    return "" if part.notes else "it has no notes"


def _why(parts: tuple[WrittenPart, ...]) -> str:
    if not parts:
        return "there is none"
    if len(parts) == 1:
        return _obstacle(parts[0])
    return "; ".join(f"{part.name}: {_obstacle(part)}" for part in parts[:6])
