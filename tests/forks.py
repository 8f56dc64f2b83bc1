"""Scripts in processes of their own, forked from one that has imported the package: imports take longer than most."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

PARENT = """
import json, os, signal, sys
import numpy, physcore.film, physcore.studies

for line in sys.stdin:
    script, arguments, output, errors = json.loads(line)
    child = os.fork()
    if child == 0:
        break
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
else:
    sys.exit()
signal.alarm(3600)  # against hanging alone: no test depends on load
for descriptor, name in enumerate((os.devnull, output, errors)):
    os.dup2(os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC), descriptor)
sys.argv[1:] = arguments
exec(compile(script, "<script>", "exec"), {"__name__": "__main__"})
"""
"""Forks a process for each line that it reads, and prints its number, and how it has ended."""


class Ended(NamedTuple):
    """A script that has ended, and what it has printed."""

    returncode: int
    stdout: str
    stderr: str


class Forks:
    """Runs scripts, one at a time."""

    def __init__(self, **environment: str) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._output, self._errors = (Path(self._folder.name, name) for name in ("output", "errors"))
        self._parent = subprocess.Popen(
            [sys.executable, "-c", PARENT],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **environment},
            text=True,
        )

    def start(self, script: str, *arguments: object) -> int:
        """Begin a script, and return the number of its process."""
        assert self._parent.stdin is not None
        line = json.dumps([script, [str(each) for each in arguments], str(self._output), str(self._errors)])
        print(line, file=self._parent.stdin, flush=True)
        return self._number()

    def end(self) -> Ended:
        """Wait for the script."""
        return Ended(self._number(), self._output.read_text(), self._errors.read_text())

    def run(self, script: str, *arguments: object) -> Ended:
        """Run a script to its end."""
        self.start(script, *arguments)
        return self.end()

    def close(self) -> None:
        """End the process that forks the others."""
        self._parent.communicate()
        self._folder.cleanup()

    def _number(self) -> int:
        assert self._parent.stdout is not None
        return int(self._parent.stdout.readline())
