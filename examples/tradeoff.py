"""What speed costs: a rope with every integrator and several time steps, against a reference."""

import physcore as pc

rope = pc.rope(20, 1.0, stiffness=500.0, damping=0.05, mass=0.01, pinned="start")
scene = pc.Scene(rope, pc.Gravity((0.0, -9.81)))
trade = pc.tradeoff(scene, duration=1.0, budget=5.0)
best = trade.best(error=1e-3)
print(trade)
print("fastest within a millimeter:", best.integrator, f"dt = {best.dt:.2g} s")
simulation = pc.Simulation(scene, **best.numerics)
simulation.run(trade.duration)
