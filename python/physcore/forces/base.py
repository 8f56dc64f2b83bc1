"""The base of all forces."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.influence import Influence


@dataclass(frozen=True)
class Force(Influence):
    """A force on the particles of some bodies. To add one: a file here, a line in `FORCES`, and its twin in Rust."""
