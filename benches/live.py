"""Live panels of three scenes, with a client in a process of its own: `python benches/live.py [SECONDS]`.

Asked are 60 pictures per second on two cores, and at most 100 ms from a slider to the picture. The client acknowledges
pictures as the page does, and moves a slider now and then: the latency is the time until the first picture after the
report with the new value. On a machine that is busy with other things the processor time per picture says more than the
pictures per second: two cores give 33 ms of it for each of 60 pictures per second. It includes physics, drawing and
sending, and is split by threads where Linux tells.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np
from measure import table

import physcore as pc

SECONDS = 6.0
MOVES = 8
"""Moves of the slider."""


def cloth(stiffness: float) -> pc.Scene:
    """5000 springs, held at the top, in a wind."""
    sheet = pc.cloth(
        (32, 41), 0.02, stiffness=stiffness, bend_stiffness=0.0, damping=0.02, mass=2e-4, pinned="top corners"
    )
    return pc.Scene(sheet, pc.Gravity(), pc.Drag(4e-4, wind=(0.5, 0.0)))


def box(gravity: float) -> pc.Scene:
    """20 000 particles that push each other away, in a box."""
    generator = np.random.default_rng(1)
    places = np.stack(np.meshgrid(np.arange(200), np.arange(100)), axis=-1).reshape(-1, 2) * 0.005 + 0.0025
    grains = pc.Particles(places, velocities=generator.normal(0.0, 0.2, places.shape), mass=1e-3, radius=0.002)
    return pc.Scene(grains, pc.SoftSpheres(200.0), pc.Gravity((0.0, -gravity)), pc.Box((0.0, 0.0), (1.0, 1.0)))


def wave(speed: float) -> pc.Scene:
    """A wave on 512 × 512 cells."""
    grid = pc.Grid((512, 512), 1.0 / 512)
    return pc.Scene(pc.Wave(grid, speed, displacement=lambda x, y: np.exp(-((x - 0.5) ** 2 + (y - 0.4) ** 2) / 2e-3)))


SCENES: dict[str, tuple[Callable[[float], pc.Scene], str, pc.Slider]] = {
    "cloth of 5000 springs": (cloth, "stiffness", pc.Slider(50.0, 200.0, 100.0)),
    "20 000 particles in a box": (box, "gravity", pc.Slider(0.0, 10.0, 2.0)),
    "wave on 512²": (wave, "speed", pc.Slider(0.05, 0.2, 0.1)),
}


def main(seconds: float) -> None:
    """Measure each scene, and print a table."""
    rows = []
    for name, (build, control, slider) in SCENES.items():
        with pc.live(build, show=False, **{control: slider}) as panel:
            panel.play()
            command = [
                sys.executable,
                __file__,
                "--client",
                panel.url,
                control,
                json.dumps([slider.lower, slider.upper]),
            ]
            client = subprocess.Popen([*command, str(seconds)], stdout=subprocess.PIPE, text=True)
            start, before, began = time.process_time(), panel.simulation.time, time.perf_counter()
            threads = thread_times()
            found = json.loads(client.communicate()[0])
            spent, played = time.process_time() - start, panel.simulation.time - before
            after = thread_times()
            share = {part: (after[part] - threads[part]) / found["pictures"] for part in threads if part in after}
            rows.append([
                name, f"{panel.simulation.dt * 1e3:.3g}", f"{found['pictures'] / found['seconds']:.0f}",
                f"{1e3 * spent / found['pictures']:.1f}", " + ".join(f"{1e3 * value:.1f}" for value in share.values()),
                f"{played / (time.perf_counter() - began):.2f}", f"{1e3 * median(found['latencies']):.0f}",
                f"{1e3 * max(found['latencies']):.0f}",
            ])  # fmt: skip
    heads = [
        "scene",
        "dt [ms]",
        "pictures/s",
        "CPU [ms/picture]",
        "physics + drawing + sending",
        "pace",
        "latency [ms]",
        "worst",
    ]
    table("Live panels", heads, rows)


def thread_times() -> dict[str, float]:
    """Processor time of the threads of physics, drawing and sending [s], where Linux tells."""
    times = {}
    for thread in threading.enumerate():
        path = Path(f"/proc/self/task/{thread.native_id}/schedstat")
        if thread.name.startswith("physcore-panel") and path.exists():
            times[thread.name.removeprefix("physcore-panel-")] = int(path.read_text().split()[0]) * 1e-9
    return {name: times[name] for name in ("physics", "pictures", "server") if name in times}


def client(url: str, control: str, values: list[float], seconds: float) -> None:
    """See pictures and move a slider, and print what was measured."""
    from websockets.sync.client import connect

    with connect(url.replace("http:", "ws:").replace("/?", "/socket?"), max_size=None, compression=None) as socket:
        pictures, latencies, moved, asked = 0, [], 0, None
        start = time.perf_counter()
        known = False
        while (now := time.perf_counter()) - start < seconds or len(latencies) < MOVES:
            message = socket.recv()
            if isinstance(message, bytes):
                pictures += 1
                socket.send('{"do": "seen", "number": 1}')
                if known and asked is not None:
                    latencies.append(time.perf_counter() - asked)
                    asked = None
            else:
                report = json.loads(message)
                known = asked is not None and report.get("values", {}).get(control) == values[moved % 2]
            if asked is None and now - start > (moved + 1) * seconds / (MOVES + 1):
                moved, asked, known = moved + 1, time.perf_counter(), False
                socket.send(json.dumps({"do": "set", "values": {control: values[moved % 2]}}))
        print(json.dumps({"pictures": pictures, "latencies": latencies, "seconds": time.perf_counter() - start}))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--client"]:
        client(sys.argv[2], sys.argv[3], json.loads(sys.argv[4]), float(sys.argv[5]))
    else:
        main(float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS)
