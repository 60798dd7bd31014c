"""A performance for other programs: an animated scene, MIDI, joint angles, USD."""

from roboguitarist.export.glb import write_glb
from roboguitarist.export.joint_table import write_joints
from roboguitarist.export.midi_file import write_midi

__all__ = ["write_glb", "write_joints", "write_midi"]
