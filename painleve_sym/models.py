"""The named mechanisms as functions: ``painleve_sym.models.rod(mu=1.5)``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from painleve_sym.mechanics.mechanism import Mechanism
    from painleve_sym.units import Value


@dataclass(frozen=True)
class NamedModel:
    """A function that returns a named mechanism.

    Parameters
    ----------
    name : str
        As on the command line.

    Examples
    --------
    >>> from painleve_sym import models
    >>> models.rod(mu=1.5)
    Mechanism 'rod': coordinates x_A, y_A, theta; contact A
    """

    name: str

    def __call__(self, **parameters: Value) -> Mechanism:
        """Return the mechanism, with other defaults of its parameters where these are given.

        Parameters
        ----------
        **parameters : float
            By name, in the parameter's unit.

        Raises
        ------
        InputError
            Unknown names, values out of range.
        """
        from painleve_sym.codegen.named_mechanisms import model

        return model(self.name, **parameters)


rod = NamedModel("rod")
rod_inertia = NamedModel("rod-inertia")
rod_bending = NamedModel("rod-bending")
block = NamedModel("block")
block_two_feet = NamedModel("block-two-feet")
eccentric_disc = NamedModel("eccentric-disc")
cart_pendulum = NamedModel("cart-pendulum")
two_link_arm = NamedModel("two-link-arm")
pr_robot = NamedModel("pr-robot")
strut = NamedModel("strut")
painleve_klein = NamedModel("painleve-klein")
rod_3d = NamedModel("rod-3d")
top = NamedModel("top")
brick = NamedModel("brick")
slider_3d = NamedModel("slider-3d")
two_link_arm_3d = NamedModel("two-link-arm-3d")
drawer = NamedModel("drawer")
ladder = NamedModel("ladder")
door = NamedModel("door")
chalk = NamedModel("chalk")
drum_brake = NamedModel("drum-brake")
sprag = NamedModel("sprag")
lead_screw = NamedModel("lead-screw")
wheelbarrow = NamedModel("wheelbarrow")
ball_on_slope = NamedModel("ball-on-slope")
slider_crank = NamedModel("slider-crank")
rocking_block = NamedModel("rocking-block")
newtons_cradle = NamedModel("newtons-cradle")
woodpecker = NamedModel("woodpecker")
block_on_belt = NamedModel("block-on-belt")
