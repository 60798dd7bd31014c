"""Two Shadow Hands E3M5, built from their published figures with capsules and boxes.

Figures: Shadow Dexterous Hand E3M5 as published in MuJoCo Menagerie (Apache-2.0). They are those
of the left hand; the right hand mirrors x. In the frame of every finger link the finger points
along +z, the palm faces -y and flexion is positive about +x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

Side = Literal["left", "right"]
Variant = Literal["linkage", "tendon"]
VARIANTS = ("linkage", "tendon")
"""`tendon`: as published, one servo drives the sum J1 + J2 of a finger and the load decides the
split. `linkage`: the same with J1 = J2 coupled, as a human finger's tendons nearly do."""

PREFIX = {"left": "lh_", "right": "rh_"}
FINGERS = ("FF", "MF", "RF", "LF", "TH")
TIP_RADIUS_M = 0.0065
TIP_Z_M = 0.0255
"""Centre of the fingertip's sphere over the J1 axis; the fingertip ends at 32 mm."""

KNUCKLE_GAP_M = 0.022
"""Distance between neighbouring fingers' knuckles."""
PROXIMAL_M, MIDDLE_M = 0.045, 0.025
HALF_TURN = np.pi / 2


@dataclass(frozen=True)
class Joint:
    """A hinge: axis in its body, range in rad, damping in N m s/rad."""

    name: str
    axis: tuple[float, float, float]
    low: float
    high: float
    damping: float = 0.05


@dataclass(frozen=True)
class Link:
    """A rigid body: pose in its parent (m, quaternion w x y z), mass in kg, inertia in kg m^2."""

    name: str
    parent: str
    pos: tuple[float, float, float]
    mass: float
    inertia: tuple[float, float, float]
    com_z: float
    joint: Joint | None = None
    quat: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Servo:
    """A position servo on a joint, or on the tendon J1 + J2 when the name ends in J0.

    Gain in N m/rad, control range in rad, force limit in N m.
    """

    name: str
    gain: float
    low: float
    high: float
    force_limit: float = 1.0


def _finger(name: str, base: tuple[float, float, float], parent: str, spread: float) -> list[Link]:
    low = name.lower()
    return [
        Link(f"{low}knuckle", parent, base, 0.008, (3.2e-7, 2.6e-7, 2.6e-7), 0.0,
             Joint(f"{name}J4", (0, spread, 0), -0.349066, 0.349066)),
        Link(f"{low}proximal", f"{low}knuckle", (0, 0, 0), 0.03, (1e-5, 9.8e-6, 1.8e-6), 0.0225,
             Joint(f"{name}J3", (1, 0, 0), -0.261799, HALF_TURN)),
        Link(f"{low}middle", f"{low}proximal", (0, 0, PROXIMAL_M), 0.017,
             (2.7e-6, 2.6e-6, 8.7e-7), 0.0125, Joint(f"{name}J2", (1, 0, 0), 0.0, HALF_TURN)),
        Link(f"{low}distal", f"{low}middle", (0, 0, MIDDLE_M), 0.013,
             (1.281e-6, 1.121e-6, 5.3e-7), 0.013077, Joint(f"{name}J1", (1, 0, 0), 0.0, HALF_TURN)),
    ]  # fmt: skip


LINKS: tuple[Link, ...] = (
    Link("wrist", "forearm", (0, -0.01, 0.21301), 0.1, (6.4e-5, 4.38e-5, 3.5e-5), 0.029,
         Joint("WRJ2", (0, -1, 0), -0.523599, 0.174533, 0.5)),
    Link("palm", "wrist", (0, 0, 0.034), 0.3, (5.287e-4, 3.581e-4, 1.91e-4), 0.035,
         Joint("WRJ1", (1, 0, 0), -0.698132, 0.488692, 0.5)),
    *_finger("FF", (-0.033, 0, 0.095), "palm", 1),
    *_finger("MF", (-0.011, 0, 0.099), "palm", 1),
    *_finger("RF", (0.011, 0, 0.095), "palm", -1),
    Link("lfmetacarpal", "palm", (0.033, 0, 0.02071), 0.03, (1.638e-5, 1.45e-5, 4.272e-6), 0.04,
         Joint("LFJ5", (0.573576, 0, -0.819152), 0.0, 0.785398)),
    *_finger("LF", (0, 0, 0.06579), "lfmetacarpal", -1),
    Link("thbase", "palm", (-0.034, -0.00858, 0.029), 0.01, (1.6e-7, 1.6e-7, 1.6e-7), 0.0,
         Joint("THJ5", (0, 0, 1), -1.0472, 1.0472), (0, -0.38268, 0, 0.92388)),
    Link("thproximal", "thbase", (0, 0, 0), 0.04, (1.36e-5, 1.36e-5, 3.13e-6), 0.019,
         Joint("THJ4", (-1, 0, 0), 0.0, 1.22173)),
    Link("thhub", "thproximal", (0, 0, 0.038), 0.005, (1e-6, 1e-6, 3e-7), 0.0,
         Joint("THJ3", (-1, 0, 0), -0.20944, 0.20944)),
    Link("thmiddle", "thhub", (0, 0, 0), 0.02, (5.1e-6, 5.1e-6, 1.21e-6), 0.016,
         Joint("THJ2", (0, -1, 0), -0.698132, 0.698132)),
    Link("thdistal", "thmiddle", (0, 0, 0.032), 0.017, (2.378e-6, 2.278e-6, 1e-6), 0.014559,
         Joint("THJ1", (1, 0, 0), -0.261799, HALF_TURN), (0.70711, 0, 0, -0.70711)),
)  # fmt: skip

SERVOS: tuple[Servo, ...] = (
    Servo("WRJ2", 10, -0.523599, 0.174533, 10),
    Servo("WRJ1", 8, -0.698132, 0.488692, 5),
    *(
        servo
        for finger in ("FF", "MF", "RF", "LF")
        for servo in (
            *((Servo("LFJ5", 1, 0.0, 0.785398),) if finger == "LF" else ()),
            Servo(f"{finger}J4", 1, -0.349066, 0.349066),
            Servo(f"{finger}J3", 1, -0.261799, HALF_TURN),
            Servo(f"{finger}J0", 0.5, 0.0, 3.1415),
        )
    ),
    Servo("THJ5", 0.4, -1.0472, 1.0472, 3),
    Servo("THJ4", 1, 0.0, 1.22173, 2),
    Servo("THJ3", 0.5, -0.20944, 0.20944),
    Servo("THJ2", 1.5, -0.698132, 0.698132),
    Servo("THJ1", 1, -0.261799, HALF_TURN),
)
FOREARM_MASS_KG = 3.0
FOREARM_INERTIA = (0.0138, 0.0138, 0.00744)


def add_hand(spec: mujoco.MjSpec, base: mujoco.MjsBody, side: Side, variant: Variant) -> None:
    """Add a hand to a model; its forearm becomes a part of `base`.

    Bodies, joints, tendons, servos (`A_` + joint) and sites carry the prefix `lh_` or `rh_`.
    Each finger has two sites: `fftip` in the centre of the fingertip's sphere and `ffnail` at
    its end. Masses are gravity compensated.

    Args:
        spec: The model under construction.
        base: Body at the forearm's origin, fingers along its +z, palm facing its -y.
        side: Which hand.
        variant: See `VARIANTS`.
    """
    prefix, mirror = PREFIX[side], np.array([1.0 if side == "left" else -1.0, 1.0, 1.0])
    base.mass, base.inertia, base.ipos = FOREARM_MASS_KG, FOREARM_INERTIA, (0, 0, 0.09)
    base.explicitinertial, base.gravcomp = True, 1.0
    bodies = {"forearm": base}
    for link in LINKS:
        bodies[link.name] = _add_link(bodies[link.parent], link, prefix, mirror)
    for finger in FINGERS:
        _add_fingertip(bodies[f"{finger.lower()}distal"], prefix + finger.lower())
    _add_servos(spec, prefix)
    if variant == "linkage":
        _couple(spec, prefix)


def _add_link(
    parent: mujoco.MjsBody, link: Link, prefix: str, mirror: np.ndarray
) -> mujoco.MjsBody:
    w, x, y, z = link.quat
    body = parent.add_body(
        name=prefix + link.name,
        pos=mirror * link.pos,
        quat=(w, x, y * mirror[0], z * mirror[0]),
        mass=link.mass,
        inertia=link.inertia,
        ipos=(0, 0, link.com_z),
        explicitinertial=True,
        gravcomp=1.0,
    )
    if link.joint is not None:
        # A rotation's axis is an axial vector: mirroring x turns its y and z.
        joint = link.joint
        body.add_joint(
            name=prefix + joint.name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=np.array(joint.axis) * (1.0, mirror[0], mirror[0]),
            range=(joint.low, joint.high),
            damping=joint.damping,
            armature=0.0002,
            frictionloss=0.01,
            solref_limit=(0.005, 1.0),  # as firm as plastic, as the published contacts are
            solimp_limit=(0.95, 0.99, 0.001, 0.5, 2.0),
        )
    return body


def _add_fingertip(distal: mujoco.MjsBody, stem: str) -> None:
    for name, height in (("tip", TIP_Z_M), ("nail", TIP_Z_M + TIP_RADIUS_M)):
        distal.add_site(name=stem + name, pos=(0, 0, height), size=(0.002,) * 3, group=4)


def _add_servos(spec: mujoco.MjSpec, prefix: str) -> None:
    for servo in SERVOS:
        target, kind = prefix + servo.name, mujoco.mjtTrn.mjTRN_JOINT
        if servo.name.endswith("J0"):
            kind = mujoco.mjtTrn.mjTRN_TENDON
            tendon = spec.add_tendon(name=target)
            tendon.wrap_joint(target[:-1] + "2", 1.0)
            tendon.wrap_joint(target[:-1] + "1", 1.0)
        actuator = spec.add_actuator(
            name=f"{prefix}A_{servo.name}",
            trntype=kind,
            target=target,
            ctrllimited=True,
            ctrlrange=(servo.low, servo.high),
            forcelimited=True,
            forcerange=(-servo.force_limit, servo.force_limit),
        )
        actuator.set_to_position(kp=servo.gain)


def _couple(spec: mujoco.MjSpec, prefix: str) -> None:
    for finger in ("FF", "MF", "RF", "LF"):
        spec.add_equality(
            name=f"{prefix}{finger}_linkage",
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=f"{prefix}{finger}J1",
            name2=f"{prefix}{finger}J2",
            data=np.eye(1, mujoco.mjNEQDATA, 1)[0],  # J1 = 0 + 1 J2
        )
