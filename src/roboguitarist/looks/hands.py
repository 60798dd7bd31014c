"""Rounded shells over the links of a hand, as thick as what touches."""

from __future__ import annotations

import mujoco

from roboguitarist.hands import FINGERS, PREFIX, TIP_RADIUS_M, TIP_Z_M, Side
from roboguitarist.looks.shapes import (
    ALONG_X,
    ALONG_Y,
    add_disc,
    add_ellipsoid,
    add_geom,
    add_mesh,
    rounded,
    tapered_capsule,
)

# Start and end on the z axis and the radii there, in metres.
_CAPSULES = {
    "proximal": (0.005, 0.045, 0.009, 0.0088),
    "middle": (0.0, 0.025, 0.0088, 0.0078),
    "distal": (0.005, TIP_Z_M, 0.0075, TIP_RADIUS_M),
    "tip": (0.0155, TIP_Z_M, TIP_RADIUS_M + 0.0006, TIP_RADIUS_M + 0.0001),
    "thproximal": (0.004, 0.034, 0.0125, 0.0105),
    "thmiddle": (0.002, 0.030, 0.0105, 0.0092),
    "thdistal": (0.005, TIP_Z_M, 0.0088, TIP_RADIUS_M),
    "thtip": (0.0155, TIP_Z_M, 0.0078, TIP_RADIUS_M + 0.0001),
}
# Rows of z, centre x, centre y, half width, half depth (see `ellipses`), left hand.
_PALM = (
    (-0.016, 0.0, 0.0, 0.0, 0.0),
    (0.000, 0.002, 0.0, 0.031, 0.0135),
    (0.020, 0.002, 0.0, 0.038, 0.0145),
    (0.045, -0.005, 0.0, 0.036, 0.0140),
    (0.070, -0.010, 0.0, 0.0335, 0.0125),
    (0.086, -0.011, 0.0, 0.033, 0.0110),
    (0.097, -0.011, 0.0, 0.0, 0.0),
)
_BACK_PLATE = (
    (0.012, -0.002, 0.0125, 0.0, 0.0),
    (0.022, -0.004, 0.0125, 0.021, 0.0045),
    (0.060, -0.010, 0.0115, 0.023, 0.0035),
    (0.080, -0.011, 0.0095, 0.0, 0.0),
)
_METACARPAL = (
    (-0.016, -0.004, 0.0, 0.0, 0.0),
    (0.000, -0.002, 0.0, 0.0115, 0.0125),
    (0.045, -0.001, 0.0, 0.0105, 0.0110),
    (0.063, 0.0, 0.0, 0.0, 0.0),
)
_WRIST = (
    (-0.016, 0.0, 0.0, 0.0, 0.0),
    (0.000, 0.0, 0.0, 0.024, 0.018),
    (0.020, 0.0, 0.0, 0.023, 0.014),
    (0.034, 0.0, 0.0, 0.0, 0.0),
)
_FOREARM = (
    (-0.110, 0.0, 0.0, 0.0, 0.0),
    (-0.080, 0.0, 0.0, 0.044, 0.044),
    (0.060, 0.0, -0.002, 0.043, 0.043),
    (0.130, 0.0, -0.006, 0.038, 0.037),
    (0.175, 0.0, -0.009, 0.031, 0.028),
    (0.200, 0.0, -0.010, 0.0, 0.0),
)
_CUFF = (
    (0.160, 0.0, -0.008, 0.0, 0.0),
    (0.167, 0.0, -0.009, 0.0335, 0.0305),
    (0.180, 0.0, -0.009, 0.0315, 0.0285),
    (0.188, 0.0, -0.010, 0.0, 0.0),
)
# Mesh, body, material, rows, power.
_SHELLS = (
    ("palm", "palm", "shell", _PALM, 3.0),
    ("back", "palm", "plate", _BACK_PLATE, 3.0),
    ("metacarpal", "lfmetacarpal", "shell", _METACARPAL, 2.6),
    ("wrist", "wrist", "plate", _WRIST, 2.6),
    ("forearm", "forearm", "shell", _FOREARM, 2.2),
    ("cuff", "forearm", "steel", _CUFF, 2.2),
)


def dress_hand(spec: mujoco.MjSpec, side: Side) -> None:
    """Add shells, pins and fingertips to the links of a hand that is in the model."""
    prefix, mirror = PREFIX[side], 1.0 if side == "left" else -1.0
    meshes = {name: f"{prefix}{name}" for name in _CAPSULES}
    for name, (start, end, thick, thin) in _CAPSULES.items():
        add_mesh(spec, meshes[name], tapered_capsule(start, end, thick, thin))
    for name, link, material, rows, power in _SHELLS:
        mirrored = [(z, mirror * x, y, width, depth) for z, x, y, width, depth in rows]
        mesh = add_mesh(spec, f"{prefix}{name}", rounded(mirrored, power))
        add_geom(spec.body(prefix + link), f"{prefix}{name}_seen", material, meshname=mesh)
    _add_wrist(spec, prefix, mirror)
    for finger in FINGERS[:4]:
        _dress_finger(spec, prefix, finger.lower(), meshes)
    _dress_thumb(spec, prefix, meshes)


def _add_wrist(spec: mujoco.MjSpec, prefix: str, mirror: float) -> None:
    palm = spec.body(f"{prefix}palm")
    add_disc(
        palm,
        f"{prefix}wrist_pin",
        "steel",
        centre=(0, 0, 0),
        radius=0.0095,
        half_height=0.027,
        quat=ALONG_X,
    )
    ball = (mirror * -0.025, -0.009, 0.030)
    add_ellipsoid(
        palm, f"{prefix}thumb_ball", "shell", centre=ball, half_size=(0.015, 0.0125, 0.026)
    )


def _dress_finger(spec: mujoco.MjSpec, prefix: str, finger: str, meshes: dict[str, str]) -> None:
    stem = prefix + finger
    pins = {"knuckle": (0.0075, 0.0092), "middle": (0.0056, 0.0089), "distal": (0.0048, 0.0078)}
    for link, (radius, half) in pins.items():
        body = spec.body(stem + link)
        add_disc(
            body,
            f"{stem}{link}_pin",
            "steel",
            centre=(0, 0, 0),
            radius=radius,
            half_height=half,
            quat=ALONG_X,
        )
    for link in ("proximal", "middle", "distal"):
        add_geom(spec.body(stem + link), f"{stem}{link}_seen", "shell", meshname=meshes[link])
    tip = f"{stem}distal_tip"
    add_geom(spec.body(f"{stem}distal"), tip, f"tip_{finger}", meshname=meshes["tip"])
    # Plates on the backs of the two longer links.
    for link, middle, length in (("proximal", 0.025, 0.014), ("middle", 0.0125, 0.007)):
        plate, half = (0, 0.0058, middle), (0.0055, 0.0042, length)
        add_ellipsoid(
            spec.body(stem + link), f"{stem}{link}_plate", "plate", centre=plate, half_size=half
        )


def _dress_thumb(spec: mujoco.MjSpec, prefix: str, meshes: dict[str, str]) -> None:
    stem = f"{prefix}th"
    add_ellipsoid(
        spec.body(f"{stem}base"),
        f"{stem}base_seen",
        "plate",
        centre=(0, 0, 0),
        half_size=(0.0135,) * 3,
    )
    for link in ("proximal", "middle", "distal"):
        body = spec.body(stem + link)
        add_geom(body, f"{stem}{link}_seen", "shell", meshname=meshes[f"th{link}"])
    for link, quat in (("hub", ALONG_Y), ("distal", ALONG_X)):
        pin = spec.body(stem + link)
        add_disc(
            pin,
            f"{stem}{link}_pin",
            "steel",
            centre=(0, 0, 0),
            radius=0.0065,
            half_height=0.0112,
            quat=quat,
        )
    add_geom(spec.body(f"{stem}distal"), f"{stem}distal_tip", "tip_th", meshname=meshes["thtip"])
