"""The base of all boundaries."""

from __future__ import annotations

from dataclasses import dataclass, field

from physcore.checks import flag, number
from physcore.influence import Influence


@dataclass(frozen=True)
class Boundary(Influence):
    """A wall that particles bounce off. To add one: a file here, a line in `BOUNDARIES`, and its twin in Rust.

    A contact happens at center ± radius. It turns the normal velocity v_n into −restitution · v_n, and the tangential
    impulse follows Coulomb: at most friction times the normal impulse, and never more than what stops the sliding.
    What a contact takes counts as dissipated.
    """

    restitution: float = field(default=1.0, kw_only=True)
    """Ratio of the normal speeds after and before a contact, from 0 (no bounce) to 1 (no loss)."""
    friction: float = field(default=0.0, kw_only=True)
    """Coulomb's coefficient of friction, at least zero."""
    no_slip: bool = field(default=False, kw_only=True)
    """Whether fluids stick to it; by default they slip along it freely."""

    def __post_init__(self) -> None:
        super().__post_init__()
        kind = type(self).__name__
        self._set(
            restitution=number(self.restitution, f"{kind}.restitution", least=0.0, most=1.0),
            friction=number(self.friction, f"{kind}.friction", least=0.0),
            no_slip=flag(self.no_slip, f"{kind}.no_slip"),
        )
