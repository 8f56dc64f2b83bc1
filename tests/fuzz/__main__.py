"""`make fuzz`: many random calls in several processes, and what they found.

A worker is a process of its own for some thousand calls of one target, so that one that aborts, hangs or needs too much
memory is seen: it writes down each call before it makes it.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import mmap
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Any

TARGETS = ("arguments", "scenes", "balance", "files", "functions", "command_line", "limits")
JOB = 5_000
"""The most examples of one worker."""
START = 20
"""How many calls an example is taken to make before that is known."""
MEMORY = 4 << 30
"""What a worker may use [bytes]."""
SILENCE = 60.0
"""A worker that has begun no call for so much processor time hangs [s]; before its first one it may take ten times as
long.
"""
STILL = 3600.0
"""A worker that has begun no call for so long hangs [s], whatever the load of the machine."""
JOURNAL = 1 << 16
"""The size of what a worker writes down [bytes]."""


def work(name: str, count: int, seed: int, journal: Path, result: Path) -> None:
    """Draw examples of a target and check them; what each one is goes into the journal before it begins.

    What is found is written at once: the process may die of the next example.
    """
    import hypothesis
    from oracle import Fault, Target

    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    target: Target = import_module(name).TARGET
    os.fsync = lambda descriptor: None  # type: ignore[assignment]  # Nobody needs these files after a power cut.
    target.prepare()
    found: dict[str, dict[str, Any]] = {}
    calls = examples = 0

    def report() -> None:
        text = json.dumps({"calls": calls, "examples": examples, "found": found})
        result.write_text(text, encoding="utf-8", errors="backslashreplace")

    with open(journal, "r+b") as file:
        page = mmap.mmap(file.fileno(), JOURNAL)

        @hypothesis.seed(seed)
        @hypothesis.settings(
            max_examples=count,
            phases=[hypothesis.Phase.generate],
            database=None,
            deadline=None,
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        @hypothesis.given(target.examples)
        def run(example: object) -> None:
            nonlocal calls, examples
            text = f"{examples} {calls} {example!r}".encode("utf-8", "backslashreplace")[: JOURNAL - 1]
            page[: len(text) + 1] = text + b"\0"
            examples += 1
            try:
                calls += target.check(example)
            except Fault as fault:
                calls += 1
                new = fault.kind not in found
                known = found.setdefault(fault.kind, {"times": 0, "script": fault.script})
                known["times"] = known["times"] + 1
                known["script"] = min(known["script"], fault.script, key=len)
                if new:
                    report()

        run()
    report()


def launch(name: str, count: int, seed: int) -> dict[str, Any]:
    """Run a worker to its end, or to where it dies, which counts as found."""
    with tempfile.TemporaryDirectory() as folder:
        journal, result, log = (Path(folder) / part for part in ("journal", "result", "log"))
        journal.write_bytes(bytes(JOURNAL))
        Path(folder, "room").mkdir()
        command = [sys.executable, __file__, "--worker", name, str(count), str(seed), str(journal), str(result)]
        paths = os.pathsep.join(
            os.path.abspath(path) for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path
        )
        with open(log, "wb") as output:
            room, environment = Path(folder, "room"), {**os.environ, "PYTHONPATH": paths, "MALLOC_ARENA_MAX": "1"}
            process = subprocess.Popen(command, cwd=room, env=environment, stdout=output, stderr=output)
            last, since, worked = b"", time.monotonic(), _worked(process.pid)
            while True:
                try:
                    process.wait(1.0)
                    break
                except subprocess.TimeoutExpired:
                    pass
                now = journal.read_bytes()
                if now != last:
                    last, since, worked = now, time.monotonic(), _worked(process.pid)
                    continue
                silence = SILENCE if now[0] else 10.0 * SILENCE
                if _worked(process.pid) - worked > silence or time.monotonic() - since > STILL:
                    process.kill()
        if process.returncode > 0:
            raise RuntimeError(f"{name}: the worker failed:\n{log.read_text(errors='replace')}")
        outcome: dict[str, Any] = json.loads(result.read_text()) if result.exists() else {"found": {}}
        if process.returncode < 0:
            begun = (
                journal.read_bytes().partition(b"\0")[0].decode("utf-8", "replace") or "0 0 before the first example"
            )
            examples, calls, example = begun.split(" ", 2)
            why = "hangs" if process.returncode == -signal.SIGKILL else f"ends the process ({process.returncode})"
            outcome["found"][why] = {"times": 1, "script": example}
            outcome |= {"calls": int(calls) + 1, "examples": int(examples) + 1}
        return outcome


def _worked(pid: int) -> float:
    """The processor time of a running process [s]; of one that has ended, 0."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except FileNotFoundError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def fuzz(calls: int | None, processes: int, seed: int, names: list[str]) -> int:
    """Share calls among targets and processes, or make a quick run of each; print and count what was found."""
    sys.path.insert(0, str(Path(__file__).parent))
    targets = {name: import_module(name).TARGET for name in names}
    whole = sum(target.share for target in targets.values())
    totals = {name: [0, 0.0] for name in targets}
    found: dict[tuple[str, str], dict[str, Any]] = {}

    def part(name: str, examples: int, first: int) -> tuple[int, float]:
        """One worker: how many calls it made, and how many in an example."""
        begin = time.monotonic()
        outcome = launch(name, examples, first)
        done = outcome["calls"]
        totals[name][0] += done
        totals[name][1] += time.monotonic() - begin
        for kind, fault in outcome["found"].items():
            if (name, kind) not in found:
                print(f"{name}: found: {kind}\n    {fault['script'][:1000]}", file=sys.stderr, flush=True)
            known = found.setdefault((name, kind), {"times": 0, "script": fault["script"]})
            known["times"] = known["times"] + fault["times"]
            known["script"] = min(known["script"], fault["script"], key=len)
        return done, done / max(1, outcome["examples"])

    def run(name: str, goal: int, first: int) -> None:
        """Go on with new seeds until there were enough calls: an example may make several, and a worker may die."""
        done, turn, rate = 0, 0, float(START)
        while done < goal:
            made, rate = part(name, max(1, min(JOB, round((goal - done) / max(rate, 1.0)))), first + turn)
            done, turn = done + max(1, made), turn + 1
            print(f"{name}: {done} of {goal} calls", file=sys.stderr, flush=True)

    begin = time.monotonic()
    with ThreadPoolExecutor(processes) as pool:
        jobs: list[Future[object]] = []
        for name, target in targets.items():
            if calls is None:
                jobs.append(pool.submit(part, name, target.quick, seed))
                continue
            share = round(calls * target.share / whole)
            parts = max(1, min(processes, share // 100))
            jobs += [pool.submit(run, name, -(-share // parts), seed + 1000 * index) for index in range(parts)]
        for job in jobs:
            job.result()
    print("| target | calls | seconds | found |\n|---|---|---|---|")
    for name, (number, seconds) in totals.items():
        print(f"| {name} | {number:.0f} | {seconds:.0f} | {sum(where == name for where, _ in found)} |")
    print(f"\n{sum(number for number, _ in totals.values()):.0f} calls in {time.monotonic() - begin:.0f} s.")
    for (name, kind), fault in sorted(found.items()):
        print(f"\n{name}: {kind} ({fault['times']} times)\n    {fault['script'][:1000]}")
    return len(found)


def main() -> int:
    """Read the command line."""
    if sys.argv[1:2] == ["--worker"]:
        sys.path.insert(0, str(Path(__file__).parent))
        name, count, seed, journal, result = sys.argv[2:]
        work(name, int(count), int(seed), Path(journal), Path(result))
        return 0
    parser = argparse.ArgumentParser(description="Call physcore with hostile arguments, scenes, files and functions.")
    parser.add_argument("--calls", type=int, default=100_000, help="how many calls (default: 100000)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="how many at a time (default: all)")
    parser.add_argument("--seed", type=int, default=int(time.time()), help="where the random numbers begin")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"some of {', '.join(TARGETS)}; all by default")
    parser.add_argument("--quick", action="store_true", help="the same few calls each time, as in `make test`")
    options = parser.parse_args()
    calls, seed = (None, 0) if options.quick else (options.calls, options.seed)
    return 1 if fuzz(calls, options.processes, seed, options.targets or list(TARGETS)) else 0


if __name__ == "__main__":
    sys.exit(main())
