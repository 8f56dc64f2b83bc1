"""A mass on a spring of one's own: measured, not believed."""

import numpy as np

import physcore as pc

spring = pc.CustomForce(lambda time, x, v: -100.0 * x, potential=lambda x: 50.0 * float((x * x).sum()))
scene = pc.Scene(pc.Particles([[0.2, 0.0]]), spring)
recording = pc.simulate(scene, duration=10.0, fps=30, accuracy=1e-6)
exact = 0.2 * np.cos(10.0 * recording.times)
print(f"off by {np.abs(recording.positions[:, 0, 0] - exact).max():.1e} m")
print(recording.plan)
