"""The sound of a performance: what the fingers really did, as a guitar would sound it.

The way of the signal: fingers' events (`events`) -> excitation and string loop (`strings`) ->
guitar body (`body`) -> stereo mix and file (`mix`).
"""

from roboguitarist.sound.mix import synthesize, write_wav

__all__ = ["synthesize", "write_wav"]
