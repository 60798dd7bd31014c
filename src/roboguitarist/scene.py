"""One MuJoCo model with the guitar and the hands."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.hands import FINGERS, PREFIX, Side, Variant, add_hand
from roboguitarist.looks import dress

CONTACTS_PER_STRING = 4
"""Contacts that a string's sensor reports, the largest force first."""
SENSOR_WIDTH = 7
"""Numbers for each contact: found, force (3), position (3)."""

# Collision groups: fingers of one hand meet each other, left fingers also the guitar. Right
# fingertips pass through the strings: a string here cannot bend out of their way.
_GUITAR, _LEFT, _RIGHT = 1, 2, 4

PAD_SOLREF, PAD_SOLIMP = (0.012, 1.0), (0.9, 0.99, 0.003, 0.5, 2.0)
"""How finger and string give way to each other: about 1.9 N/mm at 1 to 3 N, as a fingertip's flesh
does, and stiffer from 3 mm on. Fingers meet each other as hard plastic, as published."""
STRING_FRICTION = 0.5
"""Nylon on skin; with more, fingertips that land between two strings stay wedged there."""
PAD_M = 0.002
"""How much deeper than the strings a fingertip can sink until the fretboard stops it."""
LEFT_BASE_M = (0.0, 0.055, -0.350)
"""Forearm origin of the left hand at zero slides: knuckles level with the strings."""
SLIDE_RANGE_M = {"x": (-0.06, 0.42), "y": (-0.08, 0.10), "z": (-0.08, 0.08)}
"""Travel of the left forearm, wide enough for frets 1 to 15."""
SLIDE_GAIN_N_M = 8000.0
SLIDE_FORCE_N = 200.0
"""A human arm shifts 10 cm in about 150 ms, which for this hand's 4.3 kg takes up to 110 N."""
RIGHT_BASE_M = (0.068, -0.326, 0.110)
RIGHT_TURN_RAD, RIGHT_PITCH_RAD = 0.170, -0.058
"""Fixed pose of the right forearm as seen from the centre of the sound hole, found by least squares
over all stroke points of p, i, m, a."""
LEFT_TIPS = ("lh_fftip", "lh_mftip", "lh_rftip", "lh_lftip")
"""Centres of the fingertips that fret: fingers 1 to 4."""
NAILS = ("rh_thnail", "rh_ffnail", "rh_mfnail", "rh_rfnail")
"""Sites that pluck: p, i, m, a."""


@dataclass(frozen=True)
class SceneConfig:
    """What the model contains.

    Attributes:
        guitar: Dimensions of the guitar.
        hand: Variant of both hands, `linkage` or `tendon`.
        sides: Which hands are there.
        timestep_s: Physics time step.
        visuals: Add what only the eye needs.
    """

    guitar: Guitar = field(default_factory=Guitar)
    hand: Variant = "linkage"
    sides: tuple[Side, ...] = ("left", "right")
    timestep_s: float = 1 / 480
    visuals: bool = True


def build(config: SceneConfig | None = None) -> mujoco.MjModel:
    """Compile the model.

    The world frame is the guitar's (see `Guitar`); gravity points along +y, towards the treble
    side, as on a guitar that is held to play.
    """
    return build_spec(config or SceneConfig()).compile()


def build_spec(config: SceneConfig) -> mujoco.MjSpec:
    """The model before it is compiled, for those who want to add to it."""
    spec = mujoco.MjSpec()
    spec.modelname = "roboguitarist"
    spec.compiler.degree = False
    option = spec.option
    option.timestep = config.timestep_s
    option.gravity = (0, 9.81, 0)
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
    option.iterations, option.ls_iterations = 20, 20
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE  # the same numbers, a quarter faster
    _add_neck(spec, config.guitar)
    _add_string_sensors(spec)
    if "left" in config.sides:
        base = _add_slides(spec)
        add_hand(spec, base, "left", config.hand)
        _add_collision(spec, "left")
        _add_power_sensors(spec)
        _add_site_sensors(spec, LEFT_TIPS)
    if "right" in config.sides:
        x, y, z = RIGHT_BASE_M
        pos = (config.guitar.sound_hole_x_m + x, y, z)
        base = spec.worldbody.add_body(name="rh_forearm", pos=pos, quat=_right_orientation())
        add_hand(spec, base, "right", config.hand)
        _add_collision(spec, "right")
        _add_site_sensors(spec, NAILS)
    if config.visuals:
        dress(spec, config.guitar, config.sides)
    return spec


def _right_orientation() -> np.ndarray:
    """Fingers towards string 1, palm towards the guitar, turned in the plane of the strings."""
    # Columns: where the hand's x, y, z axes point in the guitar's frame before the turn.
    upright = np.column_stack([(-1, 0, 0), (0, 0, 1), (0, 1, 0)])
    turn = Rotation.from_euler("zx", [RIGHT_TURN_RAD, RIGHT_PITCH_RAD]).as_matrix()
    return Rotation.from_matrix(turn @ upright).as_quat(scalar_first=True)


def _add_neck(spec: mujoco.MjSpec, guitar: Guitar) -> None:
    """The fretboard's surface and the strings, which are all that fingers can touch."""
    end = guitar.fret_x(guitar.n_frets)
    half_width = float(guitar.string_y(1, end)) + 0.004
    spec.worldbody.add_geom(
        name="fretboard",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=(end / 2, 0, -guitar.action_m - PAD_M - 0.003),
        size=(end / 2, half_width, 0.003),
        contype=_GUITAR,
        conaffinity=_LEFT,
        rgba=(0.12, 0.07, 0.05, 1),
    )
    for string in STRINGS.tolist():
        ends = [(x, float(guitar.string_y(string, x)), 0.0) for x in (0.0, guitar.scale_length_m)]
        spec.worldbody.add_geom(
            name=f"string_{string}",
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[*ends[0], *ends[1]],
            size=(guitar.string_radius_m, 0, 0),
            contype=_GUITAR,
            conaffinity=_LEFT,
            rgba=(0.9, 0.88, 0.8, 1),
            priority=1,
            friction=(STRING_FRICTION, 0.005, 0.0001),
            solref=PAD_SOLREF,
            solimp=PAD_SOLIMP,
        )


def _add_string_sensors(spec: mujoco.MjSpec) -> None:
    for string in STRINGS:
        # Data: bit 0 found, bit 1 force, bit 4 position; 2: by largest force.
        spec.add_sensor(
            name=f"string_{string}",
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname=f"string_{string}",
            intprm=[0b10011, 2, CONTACTS_PER_STRING],
        )


def _add_slides(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    base = spec.worldbody.add_body(name="lh_forearm", pos=LEFT_BASE_M)
    for axis, direction in zip("xyz", np.eye(3), strict=True):
        name = f"lh_forearm_{axis}"
        base.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=direction,
            range=SLIDE_RANGE_M[axis],
        )
        actuator = spec.add_actuator(
            name=f"lh_A_forearm_{axis}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target=name,
            ctrllimited=True,
            ctrlrange=SLIDE_RANGE_M[axis],
            forcelimited=True,
            forcerange=(-SLIDE_FORCE_N, SLIDE_FORCE_N),
        )
        actuator.set_to_position(kp=SLIDE_GAIN_N_M, dampratio=1.0)
    return base


def _add_collision(spec: mujoco.MjSpec, side: Side) -> None:
    """Capsules of the four fingers; palm, wrist and thumb touch nothing."""
    own = _LEFT if side == "left" else _RIGHT
    others = _LEFT | _GUITAR if side == "left" else _RIGHT
    capsules = {
        "proximal": (0.009, 0.005, 0.045),
        "middle": (0.009, 0.0, 0.025),
        "distal": (0.0065, 0.007, 0.0255),
    }
    for finger in FINGERS[:4]:
        stem = PREFIX[side] + finger.lower()
        for link, (radius, start, end) in capsules.items():
            spec.body(stem + link).add_geom(
                name=f"{stem}{link}",
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=(0, 0, start, 0, 0, end),
                size=(radius, 0, 0),
                contype=own,
                conaffinity=others,
                mass=0,
                solref=(0.005, 1),
                solimp=(0.5, 0.99, 0.0001, 0.5, 2),
                rgba=(0.2, 0.2, 0.22, 1),
            )
        spec.add_exclude(bodyname1=stem + "proximal", bodyname2=stem + "distal")


def _add_power_sensors(spec: mujoco.MjSpec) -> None:
    left = [actuator.name for actuator in spec.actuators if actuator.name.startswith("lh_")]
    for kind, name in (
        (mujoco.mjtSensor.mjSENS_ACTUATORFRC, "force"),
        (mujoco.mjtSensor.mjSENS_ACTUATORVEL, "velocity"),
    ):
        for actuator in left:
            spec.add_sensor(
                name=f"{actuator}_{name}",
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_ACTUATOR,
                objname=actuator,
            )


def _add_site_sensors(spec: mujoco.MjSpec, sites: tuple[str, ...]) -> None:
    for site in sites:
        spec.add_sensor(
            name=site,
            type=mujoco.mjtSensor.mjSENS_FRAMEPOS,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=site,
        )
