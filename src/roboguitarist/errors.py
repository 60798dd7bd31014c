"""The one family of errors that users can cause and mend."""

from __future__ import annotations


class RoboGuitaristError(Exception):
    """Input that cannot be used. The message is one line: what, where, what would work."""

    def __str__(self) -> str:
        """The message on one line, whatever names from files it quotes."""
        return " ".join(super().__str__().split())


class TabError(RoboGuitaristError):
    """A score that cannot be read or makes no sense as a guitar tablature.

    Args:
        reason: What is wrong, without a full stop.
        file: The file's name.
        part: Name or id of the part.
        bar: Written bar, counted from 1.
        beat: Beat in the bar in quarter notes, counted from 1.
        hint: What would be accepted.
    """

    def __init__(
        self,
        reason: str,
        *,
        file: str | None = None,
        part: str | None = None,
        bar: int | str | None = None,
        beat: float | None = None,
        hint: str | None = None,
    ) -> None:
        self.reason, self.file, self.part = reason, file, part
        self.bar, self.beat, self.hint = bar, beat, hint
        places = (
            file,
            part and f"part {part}",
            bar is not None and f"bar {bar}",
            beat is not None and f"beat {beat:g}",
        )
        where = ", ".join(str(place) for place in places if place)
        message = f"{where}: {reason}" if where else reason
        super().__init__(f"{message} ({hint})" if hint else message)

    def in_file(self, name: str) -> TabError:
        """The same error with the name of the file in its message."""
        return TabError(
            self.reason, file=name, part=self.part, bar=self.bar, beat=self.beat, hint=self.hint
        )
