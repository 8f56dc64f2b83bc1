"""A column of water collapses; a sensor on the far wall feels it arrive."""

import physcore as pc

spacing = 0.02
water = pc.Fluid(pc.block((0.0, 0.0), (0.5, 1.0), spacing), spacing, name="water")
sensor = pc.Probe((2.0, 0.1), name="wall")
scene = pc.Scene(water, pc.Box((0.0, 0.0), (2.0, 1.5)), pc.Gravity((0.0, -9.81)), sensor)
recording = pc.simulate(scene, duration=1.5, fps=25, fluids=pc.WeaklyCompressible(sound_speed=60.0))
print(f"{recording['wall'].pressure.max():.0f} Pa at the wall")
pc.film(recording, "dam.gif")
