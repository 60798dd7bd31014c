"""Colours and grain of everything that is seen."""

from __future__ import annotations

import mujoco
import numpy as np

FINGER_RGB = {
    "TH": (0.67, 0.56, 0.80),
    "FF": (0.33, 0.62, 0.84),
    "MF": (0.40, 0.73, 0.50),
    "RF": (0.94, 0.74, 0.33),
    "LF": (0.88, 0.47, 0.44),
}
"""Colour of each fingertip, here and wherever fingers are named."""

# Colour, specular, shininess.
_PLAIN = {
    "ebony": ((0.10, 0.085, 0.08), 0.3, 0.5),
    "dark": ((0.045, 0.035, 0.03), 0.0, 0.0),
    "bone": ((0.93, 0.90, 0.82), 0.4, 0.6),
    "pearl": ((0.90, 0.90, 0.86), 0.6, 0.8),
    "nickel": ((0.80, 0.80, 0.78), 0.9, 0.8),
    "brass": ((0.80, 0.66, 0.38), 0.9, 0.8),
    "nylon": ((0.93, 0.92, 0.88), 0.5, 0.6),
    "wound": ((0.80, 0.74, 0.60), 0.8, 0.7),
    "binding": ((0.30, 0.17, 0.09), 0.4, 0.6),
    "shell": ((0.17, 0.18, 0.20), 0.5, 0.5),
    "plate": ((0.46, 0.48, 0.51), 0.55, 0.6),
    "steel": ((0.70, 0.71, 0.73), 0.9, 0.75),
    **{f"tip_{finger.lower()}": (rgb, 0.25, 0.3) for finger, rgb in FINGER_RGB.items()},
}
# Colour, contrast of the grain, lines of grain on one copy of the texture.
_WOOD = {
    "spruce": ((0.87, 0.71, 0.47), 0.08, 120),
    "rosewood": ((0.40, 0.20, 0.11), 0.28, 40),
    "mahogany": ((0.50, 0.28, 0.16), 0.16, 50),
    "fingerboard": ((0.21, 0.12, 0.085), 0.25, 60),
}
_TEXELS = 512
_METAL = 0.75
"""What reflects more than this is a metal to renderers that tell metals apart."""


def add_materials(spec: mujoco.MjSpec) -> None:
    """Add all materials that the other functions of this package name."""
    for name, (rgb, specular, shininess) in _PLAIN.items():
        spec.add_material(
            name=name,
            rgba=(*rgb, 1),
            specular=specular,
            shininess=shininess,
            metallic=float(specular > _METAL),
            roughness=_roughness(shininess),
        )
    for name, (rgb, contrast, lines) in _WOOD.items():
        spec.add_texture(
            name=name,
            type=mujoco.mjtTexture.mjTEXTURE_2D,
            width=4,
            height=_TEXELS,
            nchannel=3,
            data=wood(rgb, contrast, lines).ravel().tolist(),
        )
        material = spec.add_material(
            name=name, specular=0.35, shininess=0.5, metallic=0.0, roughness=_roughness(0.5)
        )
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _roughness(shininess: float) -> float:
    """The same polish for renderers that count it the other way round."""
    return 1.0 - 0.8 * shininess


def wood(rgb: tuple[float, float, float], contrast: float, lines: int) -> np.ndarray:
    """Straight grain as an image (512, 4, 3) of uint8 that repeats without a seam.

    Args:
        rgb: Colour, 0 to 1.
        contrast: Depth of the grain, 0 to 1.
        lines: Number of lines over the height.
    """
    random = np.random.default_rng(lines)
    place = np.arange(_TEXELS) / _TEXELS
    waves = random.integers(max(1, lines // 4), lines, 24)
    grain = np.sin(2 * np.pi * (waves[:, None] * place + random.random((24, 1)))).mean(axis=0)
    light = 1 + contrast * grain / np.abs(grain).max()
    image = np.clip(255 * np.array(rgb) * light[:, None], 0, 255).astype(np.uint8)
    return np.repeat(image[:, None], 4, axis=1)
