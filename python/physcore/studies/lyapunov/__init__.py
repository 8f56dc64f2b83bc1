"""Lyapunov exponents: the rates at which neighboring trajectories separate.

The submodules are as follows:

- `measuring`: the growth of the offsets between a trajectory and its neighbors, averaged;
- `neighbors`: the orthonormalization of the offsets;
- `flows`: the neighbors of tracers;
- `mechanics`: the neighbors of all bodies of a scene.
"""

from __future__ import annotations

from physcore.studies.lyapunov.exponents import Lyapunov
from physcore.studies.lyapunov.measuring import lyapunov

__all__ = ["Lyapunov", "lyapunov"]
