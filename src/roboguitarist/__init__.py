"""Two simulated robotic hands play the guitar from a tablature."""

__version__ = "0.1.0"
