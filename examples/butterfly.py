"""200 000 tracers in the flow of Lorenz, and how fast their paths part."""

import numpy as np

import physcore as pc

rng = np.random.default_rng(1)
cloud = pc.Tracers(rng.normal((0.0, 0.0, 30.0), size=(200_000, 3)), pc.Lorenz())
recording = pc.simulate(pc.Scene(cloud), duration=8.0, fps=15, dt=0.01, integrator="RungeKutta4")
pc.film(recording, "butterfly.gif", style=pc.styles.Density())

few = pc.Tracers(rng.normal((0.0, 0.0, 25.0), size=(50, 3)), pc.Lorenz())
spectrum = pc.lyapunov(few, duration=50.0, transient=5.0, dt=0.01)
print("exponents", np.round(spectrum.exponents, 2), "dimension", round(spectrum.dimension, 2))
