"""Public names of the integrators, which are defined in `physcore.numerics.integrators`."""

from __future__ import annotations

from physcore.numerics.integrators import *  # noqa: F403
from physcore.numerics.integrators import __all__ as __all__
