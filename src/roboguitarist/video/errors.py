"""What goes wrong when a machine lacks a library that pictures need."""

from __future__ import annotations

from roboguitarist.errors import RoboGuitaristError


class UnavailableError(RoboGuitaristError):
    """This machine lacks something that pictures need. The message says what to install."""
