"""A cloth falls over a ball."""

import physcore as pc

level = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
cloth = pc.cloth((41, 41), 0.03, stiffness=200.0, damping=0.03, mass=2e-4, origin=(-0.6, -0.6, 0.55), axes=level)
ball = pc.Sphere((0.0, 0.0, 0.0), radius=0.4, inside=False, friction=0.3)
scene = pc.Scene(cloth, ball, pc.Floor(-0.4), pc.Gravity(), pc.Drag(linear=2e-4))
recording = pc.simulate(scene, duration=2.0, fps=25)
pc.film(recording, "cloth.gif", style=pc.styles.Surface(color=cloth.positions[:, 0], colormap="plasma"))
