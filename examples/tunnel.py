"""A wave packet meets a barrier: a part of it tunnels."""

import physcore as pc

line = pc.Grid(600, spacing=0.1)
packet = pc.wave_packet(line, center=20.0, momentum=2.0, width=2.0)
electron = pc.Schrodinger(line, packet, potential=lambda x: 2.2 * (abs(x - 30.0) < 0.5), edges="absorbing")
recording = pc.simulate(pc.Scene(electron), duration=10.0, fps=20)
density = recording[electron].density
print(f"{density[-1, 300:].sum() * line.spacing:.1%} went through")
pc.film(recording, "tunnel.gif")
