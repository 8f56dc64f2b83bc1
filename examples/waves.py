"""Waves from a lamp pass two slits and interfere."""

import numpy as np

import physcore as pc

grid = pc.Grid((240, 180), spacing=0.05)
x, y = grid.coordinates
slits = (abs(y - 3.5) < 0.2) | (abs(y - 5.5) < 0.2)
lamp = pc.Source(x < 0.05, amplitude=20.0, frequency=2.0)
pond = pc.Wave(grid, speed=1.0, walls=(abs(x - 4.0) < 0.08) & ~slits, edges="absorbing", sources=[lamp], name="pond")
recording = pc.simulate(pc.Scene(pond), duration=12.0, fps=20)
print(f"largest displacement {np.abs(recording[pond].displacement).max():.2f} m")
pc.film(recording, "waves.webp")
