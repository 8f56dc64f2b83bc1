"""A comet around a star, by steps that follow its motion."""

import physcore as pc

star = pc.Particles([[0.0, 0.0]], mass=1.0, fixed=[0], name="star")
comet = pc.Particles([[1.9, 0.0]], [[0.0, 0.166]], mass=1e-9, name="comet")
scene = pc.Scene(star, comet, pc.Gravitation(constant=1.0))
recording = pc.simulate(scene, duration=25.2, fps=10, dt=pc.AdaptiveStep(), integrator=pc.BlanesMoan4())
print(f"energy drift {abs(recording.energy.drift).max():.1e}")
pc.film(recording, "orbit.gif", style=pc.styles.Trails())
