"""Ions in a Penning trap, by Boris' method."""

import numpy as np

import physcore as pc

rng = np.random.default_rng(2)
ions = pc.Particles(rng.normal(size=(40, 3)) * 0.2, rng.normal(size=(40, 3)) * 0.3, charge=1.0)
field = pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (0.0, 0.0, 6.0))
scene = pc.Scene(ions, field, pc.Coulomb(constant=0.01, softening=0.02))
recording = pc.simulate(scene, duration=8.0, fps=20, dt=0.005, integrator="Boris")
print(recording.energy)
pc.film(recording, "trap.gif", style=pc.styles.Trails())
