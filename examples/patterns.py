"""Worms that grow from a drop: the reaction of Gray and Scott."""

import numpy as np

import physcore as pc

grid = pc.Grid((128, 128), spacing=0.01, periodic=True)
x, y = grid.coordinates
drop = np.hypot(x - 0.64, y - 0.64) < 0.1
start = {"u": 1.0 - 0.5 * drop, "v": 0.25 * drop}
dish = pc.ReactionDiffusion(grid, pc.GrayScott.pearson("mu"), {"u": 2e-5, "v": 1e-5}, start)
recording = pc.simulate(pc.Scene(dish), duration=8000.0, fps=0.02)
pc.film(recording, "patterns.gif", style=pc.styles.Field("v"), speed=1500.0)
