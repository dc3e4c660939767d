"""Springs and grippers at a blank's edge: what pulls it to the frame while it draws in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, one_of, positive, said
from warpdrape.tools.chosen import Chosen, chosen_vertices
from warpdrape.tools.motion import vector


@dataclass(frozen=True, kw_only=True, eq=False)
class Spring:
    """Springs from chosen vertices of a ply to a frame that stands still.

    Forces are those of the whole device, shared by its vertices alike. Springs pull and never push:
    one that is shortened beyond its preload goes slack.

    Attributes:
        name: how results call it.
        ply: name of the ply.
        where: vertex indices, or a function of the flat points [m] (shape [n, 3]) to a mask.
        to: from a vertex where it starts to the point of the frame that it hangs on [m], shape [3].
        stiffness: of all springs together [N/m].
        preload: force at the start [N].
        direction: "following": along the line from the vertex to the frame, wherever it goes;
            "fixed": along ``to``, as with a gripper on a rail.
        slip_force: at which the ply slips through the grip, which goes on pulling with it [N].
        break_force: at which the grip lets go for good [N]; one of the two.
    """

    name: str
    ply: str
    where: Chosen
    to: Sequence[float]
    stiffness: float
    preload: float = 0.0
    direction: str = "following"
    slip_force: float | None = None
    break_force: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(f"spring name = {said(self.name)} must be a plain identifier")
        if np.linalg.norm(vector(f"spring {self.name!r}: to", self.to)) == 0.0:
            raise InputError(f"spring {self.name!r}: to must not be the zero vector")
        what = f"of spring {self.name!r}"
        positive(f"stiffness {what}", self.stiffness, unit="N/m", zero=True)
        positive(f"preload {what}", self.preload, unit="N", zero=True)
        if self.stiffness == 0.0 and self.preload == 0.0:
            raise InputError(f"spring {self.name!r} has neither stiffness nor preload: give one")
        one_of(f"direction {what}", self.direction, ("following", "fixed"))
        if self.slip_force is not None and self.break_force is not None:
            raise InputError(
                f"spring {self.name!r} has slip_force and break_force: a grip that slips never "
                "pulls harder, one that breaks first never slips; leave one out"
            )
        for name in ("slip_force", "break_force"):
            limit = getattr(self, name)
            if limit is not None and finite(f"{name} {what}", limit, unit="N") <= self.preload:
                raise InputError(
                    f"{name} {what} = {limit:g} N must lie above its preload of {self.preload:g} N"
                )

    def vertices(self, points: np.ndarray) -> np.ndarray:
        """Indices of the pulled vertices among flat points [m], shape [n, 3].

        Raises:
            InputError: if there are none, or what ``where`` gives is no choice of them.
        """
        return chosen_vertices(f"spring {self.name!r}", self.where, self.ply, points)
