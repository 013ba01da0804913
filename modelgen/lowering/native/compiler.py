"""The C compiler of this machine: which one, what it is known by, and how it is called.

Part of the compiler. Taken is the first that exists of $CC, gcc, clang, and the ziglang package of this Python (the extra
``native``). Flags: fused multiply-add is allowed (sums of waves are made of it; results differ from the virtual machine's by
rounding), but nothing that assumes away NaN, infinity or the order of a sum: with -ffast-math a run that leaves the numbers ends
in success (tests/solvers/test_native.py notices).
"""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from modelgen.errors import LoweringError

COMMANDS = ("gcc", "clang")
FLAGS = (
    "-std=gnu11",
    "-O3",
    "-ffp-contract=fast",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-strict-aliasing",
    "-fPIC",
    "-shared",
)
LONGEST_BUILD = 60.0  # s; drivelines of a thousand inertias take a few


class NoCompilerError(LoweringError):
    """There is no working C compiler: run the model on CasADi's virtual machine."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the command that starts it, and a text that changes with its version."""

    command: tuple[str, ...]
    version: str

    def flags(self) -> tuple[str, ...]:
        """Options for this processor."""
        return (*FLAGS, "-march=native" if platform.machine() in ("x86_64", "AMD64") else "-mcpu=native")

    def identity(self) -> str:
        """What a build depends on besides its source: compiler, version, options, processor."""
        return "\n".join((*self.command, self.version, *self.flags(), processor()))

    def build(self, source: Path, library: Path) -> None:
        """Compile one file to a shared library. Raises NoCompilerError with the compiler's first complaint."""
        order = [*self.command, *self.flags(), source.name, "-o", str(library), "-lm"]
        try:
            done = subprocess.run(
                order,
                cwd=source.parent,
                capture_output=True,
                text=True,
                timeout=LONGEST_BUILD,
                check=False,
                stdin=subprocess.DEVNULL,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise self._failure(type(error).__name__) from None
        if done.returncode or not library.is_file():
            complaints = (
                [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines() or ["no message"]
            )
            raise self._failure(complaints[0].strip())

    def _failure(self, words: str) -> NoCompilerError:
        return NoCompilerError("native code", f"{' '.join(self.command)} failed: {words:.200}", "run on CasADi's virtual machine")


def find_compiler(environment: Mapping[str, str] | None = None) -> Compiler:
    """The compiler to use. Raises NoCompilerError where there is none, or $CC names one that is not there.

    >>> find_compiler({"CC": "no-such-compiler -x"})
    Traceback (most recent call last):
    ...
    modelgen.lowering.native.compiler.NoCompilerError: native code: $CC names 'no-such-compiler', which is not there; ...
    """
    env = os.environ if environment is None else environment
    path = env.get("PATH", os.defpath)
    try:
        wanted = shlex.split(env.get("CC", ""))
    except ValueError as error:
        problem = f"$CC is {env['CC']!r:.60}: {error}"
        raise NoCompilerError("native code", problem, "correct it, or run on CasADi's virtual machine") from None
    if wanted:
        if (found := shutil.which(wanted[0], path=path)) is None:
            problem = f"$CC names {wanted[0]!r}, which is not there"
            raise NoCompilerError("native code", problem, "correct it, or run on CasADi's virtual machine")
        return Compiler((found, *wanted[1:]), _version((found, *wanted[1:]), _stamp(found)))
    for name in COMMANDS:
        if found := shutil.which(name, path=path):
            return Compiler((found,), _version((found,), _stamp(found)))
    try:
        return Compiler((sys.executable, "-m", "ziglang", "cc"), f"ziglang {importlib.metadata.version('ziglang')}")
    except importlib.metadata.PackageNotFoundError:
        remedy = "install gcc or clang or the extra modelgen[native], or run on CasADi's virtual machine"
        raise NoCompilerError("native code", "there is no C compiler ($CC, gcc, clang, ziglang)", remedy) from None


def _stamp(program: str) -> tuple[int, int]:
    status = os.stat(program)
    return status.st_mtime_ns, status.st_size


@functools.lru_cache(maxsize=8)
def _version(command: tuple[str, ...], stamp: tuple[int, int]) -> str:
    """What the compiler says about itself; asked once, and again when its file changes."""
    try:
        done = subprocess.run(
            [*command, "--version"], capture_output=True, text=True, timeout=10, check=False, stdin=subprocess.DEVNULL
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise NoCompilerError(
            "native code", f"{command[0]} does not start ({type(error).__name__})", "correct $CC or PATH"
        ) from None
    if done.returncode:
        raise NoCompilerError("native code", f"{command[0]} --version ends with code {done.returncode}", "correct $CC or PATH")
    return f"{done.stdout}{stamp}"


@functools.cache
def processor() -> str:
    """A text that changes with the processor: code made for one may not run on another."""
    lines = [platform.machine(), platform.processor(), platform.system()]
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
        lines += [
            line for line in first.splitlines() if line.split(":")[0].strip() in ("model name", "flags", "Features", "CPU part")
        ]
    except OSError:
        pass
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()
