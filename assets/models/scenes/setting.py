"""What a layout gives: things, light, and how to look at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .light import Lamp, Lighting
from .parts import Kit, Parts


@dataclass(frozen=True)
class Setting:
    """A scene before it is photographed.

    Parameters
    ----------
    parts : list of (Shape, int)
        All there is.
    stand, look : tuple of two ndarray (3,)
        Opposite corners of the boxes in which camera and target are drawn [m].
    inside : bool
        A closed room, which keeps out the sky's light.
    lamps : tuple of Lamp
        Besides those that every room gets.
    roll : float
        Standard deviation of the camera's roll [degrees].
    """

    parts: Parts
    stand: tuple[np.ndarray, np.ndarray]
    look: tuple[np.ndarray, np.ndarray]
    inside: bool = True
    lamps: tuple[Lamp, ...] = ()
    roll: float = 3.0


def lighting(kit: Kit, setting: Setting) -> Lighting:
    """Lamps and ambient light to suit a setting."""
    tint = 1 + kit.rng.normal(0, 0.08, 3)
    return _inside(kit, setting, tint) if setting.inside else _daylight(kit)


def _daylight(kit: Kit) -> Lighting:
    """Sun and sky, or clouds."""
    colour = np.array([1.0, 0.93, 0.8])
    sun = Lamp(_up(kit, 0.2), 3.0 * kit.between(0.2, 1.6) * colour, kit.between(0, 0.1), sun=True)
    sky = np.array([0.55, 0.75, 1.0]) * kit.between(0.4, 1.2)
    lamps, above = ([], 2.2 * sky) if kit.chance(0.35) else ([sun], sky)
    return Lighting(lamps, above, sky * 0.4, sky * kit.between(0.6, 1.3), kit.between(0.3, 1.5))


def _inside(kit: Kit, setting: Setting, tint: np.ndarray) -> Lighting:
    """The setting's lamps and a few more, at times sunlight."""
    low = np.minimum(setting.stand[0], setting.look[0])
    high = np.maximum(setting.stand[1], setting.look[1])
    lamps = list(setting.lamps)
    for _ in range(kit.number(1, 2) if not lamps else kit.number(0, 1)):
        at = kit.rng.uniform(low, high)
        at[1] = max(high[1], 1.2) + kit.between(0.1, 0.9)
        strength = kit.between(1, 4) * tint * (1 + kit.rng.normal(0, 0.1, 3))
        if kit.chance(0.2):
            target = kit.rng.uniform(*setting.look)
            lamps.append(Lamp(at, 3 * strength, kit.between(0, 0.05), target=target, cone=kit.between(0.7, 0.95)))
        else:
            lamps.append(Lamp(at, strength, float(kit.rng.choice([0.0, 0.1, 0.5]))))
    if kit.chance(0.3):
        lamps.append(_sunlight(kit, setting, tint))
    level = kit.between(0.1, 1.0) * tint
    return Lighting(lamps, level * 1.1, level * kit.between(0.5, 1), level * 0.5, kit.between(0.2, 1.2))


def _sunlight(kit: Kit, setting: Setting, tint: np.ndarray) -> Lamp:
    """Sharp patches of sunlight, as through a window."""
    target = kit.rng.uniform(*setting.look)
    way = _up(kit, 0.5)
    away = kit.between(2, 5)
    # The lamp shines from within the room, just under its ceiling, past what is in the way.
    at = target + away * way * min(1.0, max(2.2 - target[1], 0.3) / (away * way[1]))
    strength = kit.between(3, 12) * float(np.sum((at - target) ** 2)) * tint * (1.0, 0.9, 0.75)
    return Lamp(at, strength, 0.0, target=target, cone=kit.between(0.8, 0.98), panes=kit.number(1, 4))


def _up(kit: Kit, lowest: float) -> np.ndarray:
    """Direction above the horizon."""
    way = kit.rng.standard_normal(3)
    way[1] = abs(way[1]) + lowest
    return way / np.linalg.norm(way)
