"""Lyapunov exponents: how fast neighboring paths part.

`measuring` averages the growth of the offsets between a path and its neighbors, which are orthonormalized in
`neighbors`; `flows` takes neighbors of tracers along, `mechanics` those of all bodies of a scene.
"""

from __future__ import annotations

from physcore.studies.lyapunov.exponents import Lyapunov
from physcore.studies.lyapunov.measuring import lyapunov

__all__ = ["Lyapunov", "lyapunov"]
