"""Two simulated robotic hands play the guitar from a tablature."""

from roboguitarist.registration import register as _register

__version__ = "0.1.0"

_register()
