"""Three double pendulums of rods that start a centimeter apart."""

import math

import physcore as pc

pendulums = [
    pc.SpringNetwork(
        [[0.0, 0.0], [1.0, offset], [2.0, offset]], [[0, 1], [1, 2]], math.inf, fixed=[0], name=f"{offset:g} m"
    )
    for offset in (0.0, 0.01, 0.02)
]
scene = pc.Scene(*pendulums, pc.Gravity((0.0, -9.81)))
recording = pc.simulate(scene, duration=10.0, fps=25, integrator=pc.RATTLE(order=4))
print(recording.energy)
pc.film(recording, "pendulum.gif", style=pc.styles.Paths())
