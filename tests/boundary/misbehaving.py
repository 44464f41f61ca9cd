"""Engines that misbehave in one way each; ``<phase>_<act>`` is an act in a phase, others return something wrong."""

import contextlib
import ctypes
import dataclasses
import os
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Engine
from adapters.reference.numpy_engines import Reference

TRACE = Path(__file__).with_name("code-was-run")
"""File that code in an answer makes, if the comparing process runs it"""


class UnprintableError(Exception):
    def __str__(self) -> str:
        raise ValueError("no text")


class Own(BaseException):
    """An exception beside Exception."""


def raising(error: BaseException | type[BaseException]) -> Callable[[], None]:
    def act() -> None:
        raise error

    return act


def flood() -> None:
    while True:
        os.write(1, b"x" * 65536)


def hoard() -> None:
    kept = []
    while True:
        kept.append(np.ones(2**24))


def detach() -> None:
    """A grandchild that outlives its parent, in a session of its own."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(600)
        os._exit(0)


def write_files() -> None:
    """Write to every open file."""
    for number in range(3, 64):
        with contextlib.suppress(OSError):
            os.write(number, b"\0" * 8)


def hold_by_thread() -> None:
    threading.Thread(target=time.sleep, args=(600,)).start()


def stop_worker() -> None:
    """Stop the process that would end this one."""
    os.kill(os.getppid(), signal.SIGSTOP)
    time.sleep(600)


def kill_worker() -> None:
    """Leave a child in a session of its own, and kill the process that would end it."""
    subprocess.Popen(["sleep", "600"], start_new_session=True)
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(600)


def claim_memory() -> None:
    """Write to every pipe that an answer of 700 TB comes."""
    for number in range(3, 1024):
        with contextlib.suppress(OSError):
            os.write(number, struct.pack("<Q", 7 * 10**14))
    os._exit(0)


ACTS: dict[str, Callable[[], Any]] = {
    "exits_0": lambda: sys.exit(0),
    "exits_bye": lambda: sys.exit("bye"),
    "exits_3": lambda: sys.exit(3),
    "interrupts": raising(KeyboardInterrupt()),
    "stops": raising(GeneratorExit()),
    "raises_own": raising(Own("mine")),
    "raises": raising(ZeroDivisionError("inside")),
    "raises_unprintable": raising(UnprintableError()),
    "raises_surrogates": raising(RuntimeError("lone \udc80 surrogate \x1b[2J \u202e and\nlines")),
    "raises_long": raising(RuntimeError("x" * 10**6)),
    "recurses": lambda: recursion(0),
    "leaves_0": lambda: os._exit(0),
    "leaves_3": lambda: os._exit(3),
    "kills_itself": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "terminates_itself": lambda: os.kill(os.getpid(), signal.SIGTERM),
    "segfaults": lambda: ctypes.string_at(0),
    "aborts": os.abort,
    "closes_files": lambda: os.closerange(0, 200) or os._exit(0),
    "floods": flood,
    "hoards": hoard,
    "hangs": lambda: time.sleep(600),
    "stops_worker": stop_worker,
    "kills_worker": kill_worker,
    "claims_memory": claim_memory,
    "removes_folder": lambda: (shutil.rmtree(Path.cwd().parent), os._exit(0)),
    "hangs_deaf": lambda: (signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 64)), time.sleep(600)),
}
HARMLESS: dict[str, Callable[[], Any]] = {
    "prints": lambda: print("hello", flush=True),
    "prints_binary": lambda: os.write(2, bytes(range(256))),
    "starts_thread": hold_by_thread,
    "starts_child": lambda: subprocess.Popen(["sleep", "600"]),
    "detaches": detach,
    "changes_folder": lambda: os.chdir("/"),
    "writes_files": write_files,
    "changes_environment": os.environ.clear,
}
"""Acts that cost nothing: the run passes, and nothing of it stays"""
PHASES = ("made", "build", "simulate", "read", "unsupported", "noise", "motion")


def recursion(depth: int) -> int:
    return recursion(depth + 1) + 1


class Plain(Engine):
    """The reference behind the contract."""

    title = "the reference, misbehaving"
    coordinates = Reference.coordinates
    order = None
    sweep = Reference.sweep
    effects = Reference.effects
    observables: ClassVar = Reference.observables

    def build(self, scene, setting):
        self.inner = Reference()
        self.inner.build(scene, setting)

    def simulate(self):
        self.inner.simulate()

    def read(self):
        return self.inner.read()


OF_CLASS: dict[str, tuple[str, Any]] = {
    "unsupported": ("unsupported", None),
    "motion": ("unsupported_motion", None),
    "noise": ("noise", {}),
}
"""Phases in which a class is asked, by the methods that answer, with right answers"""


def acting(phase: str, act: Callable[[], Any]) -> type[Engine]:
    """Class of an engine that acts in one phase."""
    if phase in OF_CLASS:
        name, answer = OF_CLASS[phase]
        return type("Acting", (Plain,), {name: classmethod(lambda cls, *asked: (act(), answer)[1])})
    name = "__init__" if phase == "made" else phase

    def acts(self, *given):
        found = getattr(Plain, name)(self, *given)
        act()
        return found

    return type("Acting", (Plain,), {name: acts})


class Runs:
    """An object that runs code when it is unpickled."""

    def __reduce__(self):
        return os.system, (f"touch {TRACE}",)


INFO: dict[str, Any] = {
    "set": {1, 2}, "array": np.ones(3), "object": object(), "nan": float("nan"), "infinite": float("inf"),
    "bytes": b"x", "nested": {"a": {"b": 1}}, "list": [1, 2], "none": None, "code": Runs(), "huge": 10**400,
    "complex": 1j, "class": Engine, "lambda": lambda: 0,
}  # fmt: skip
INFO_FINE: dict[str, Any] = {
    "scalar": np.float64(3.0),
    "integer": np.int64(3),
    "text": "a\nb \udc80",
    "float32": np.float32(2),
}


def with_info(value: Any) -> type[Engine]:
    class Info(Plain):
        def read(self):
            seen = super().read()
            seen.info["odd"] = value
            return seen

    return Info


CHANGES: dict[str, Callable[[Any], Any]] = {
    "list_for_array": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.tolist()),
    "tuple_for_time": lambda s: dataclasses.replace(s, t_s=tuple(s.t_s)),
    "complex": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.astype(complex)),
    "float32": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.astype(np.float32)),
    "integers": lambda s: dataclasses.replace(s, com_m=s.com_m.astype(int)),
    "long_double": lambda s: dataclasses.replace(s, com_m=s.com_m.astype(np.longdouble)),
    "objects": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.astype(object)),
    "code_in_array": lambda s: dataclasses.replace(s, angle_rad=np.array([Runs()], dtype=object)),
    "text_array": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.astype(str)),
    "masked": lambda s: dataclasses.replace(s, angle_rad=np.ma.masked_array(s.angle_rad, mask=True).astype(np.float32)),
    "structured": lambda s: dataclasses.replace(s, t_s=np.zeros(3, dtype=[("a", float)])),
    "no_time": lambda s: dataclasses.replace(s, t_s=None),
    "no_com": lambda s: dataclasses.replace(s, com_m=None),
    "scalar_time": lambda s: dataclasses.replace(s, t_s=np.array(1.0)),
    "empty": lambda s: dataclasses.replace(s, t_s=np.array([])),
    "flat_angles": lambda s: dataclasses.replace(s, angle_rad=s.angle_rad.ravel()),
    "transposed": lambda s: dataclasses.replace(s, angle_rad=np.asarray(s.angle_rad.T)),
    "too_many_samples": lambda s: dataclasses.replace(s, t_s=np.append(s.t_s, s.t_s[-1] + 1.0)),
    "condition_short": lambda s: dataclasses.replace(s, condition=np.ones(3)),
    "five_dimensions": lambda s: dataclasses.replace(s, reaction_N=np.zeros((len(s.t_s), 1, 2, 1, 1))),
    "nan": lambda s: dataclasses.replace(s, rate_rad_s=s.rate_rad_s * np.nan),
    "infinite": lambda s: dataclasses.replace(s, com_m=s.com_m * np.inf),
    "ended_number": lambda s: dataclasses.replace(s, ended=3),
    "info_list": lambda s: dataclasses.replace(s, info=[1]),
    "info_large": lambda s: dataclasses.replace(s, info={str(k): k for k in range(1000)}),
    "info_key": lambda s: dataclasses.replace(s, info={3: 4}),
    "none": lambda s: None,
    "dictionary": lambda s: dict(vars(s)),
    "generator": lambda s: (x for x in s.t_s),
    "code": lambda s: Runs(),
}


def with_change(change: Callable[[Any], Any]) -> type[Engine]:
    class Changed(Plain):
        def read(self):
            return change(super().read())

    return Changed


def without(name: str) -> type:
    """Class that lacks a declaration."""
    return type(
        "Lacking",
        (Engine,),
        {k: v for k, v in {**vars(Plain), **DECLARED}.items() if k not in {name, "__dict__", "__weakref__"}},
    )


DECLARED = {"observables": Reference.observables}
ODD: dict[str, dict[str, Any]] = {
    "effects_text": {"effects": "gravity"},
    "effects_numbers": {"effects": [1, 2]},
    "observables_odd": {"observables": frozenset({"speed"})},
    "order_text": {"order": "second"},
    "order_true": {"order": True},
    "title_number": {"title": 7},
    "coordinates_odd": {"coordinates": "spherical"},
    "sweep_text": {"sweep": "rtol"},
    "sweep_unsorted": {"sweep": AccuracySweep(AccuracyParameter.RTOL, (1e-6, 1e-9, 1e-7), 1e-9)},
    "sweep_empty": {"sweep": AccuracySweep(AccuracyParameter.RTOL, (), 1e-9)},
    "order_nan": {"order": float("nan")},
    "step_constant_nan": {"step_constant": float("nan")},
    "step_constant_text": {"step_constant": "ten"},
    "reasons_list": {"unsupported_reasons": ["no"]},
}
CLAIMS: dict[str, dict[str, Any]] = {
    "noise_list": {"noise": classmethod(lambda cls, scene, setting, t_s: [1.0])},
    "noise_misspelt": {"noise": classmethod(lambda cls, scene, setting, t_s: {"reactions": 1e-9})},
    "noise_shape": {"noise": classmethod(lambda cls, scene, setting, t_s: {"reaction": np.ones(3)})},
    "noise_nan": {"noise": classmethod(lambda cls, scene, setting, t_s: {"reaction": np.nan})},
    "noise_text": {"noise": classmethod(lambda cls, scene, setting, t_s: {"reaction": "small"})},
    "noise_none": {"noise": classmethod(lambda cls, scene, setting, t_s: None)},
    "reason_number": {"unsupported": classmethod(lambda cls, scene: 3)},
    "reason_true": {"unsupported": classmethod(lambda cls, scene: True)},
    "reason_empty": {"unsupported": classmethod(lambda cls, scene: "")},
    "motion_object": {"unsupported_motion": classmethod(lambda cls, scene, motion: object())},
}
NO_CLASS: dict[str, Any] = {"no_class_text": "Engine", "no_class_function": lambda: None, "no_class_other": dict}

ENGINES: dict[str, Callable[[], Any]] = (
    {f"{p}_{name}": (lambda p=p, a=a: acting(p, a)) for p in PHASES for name, a in ACTS.items()}
    | {f"info_{name}": (lambda v=v: with_info(v)) for name, v in INFO.items()}
    | {f"gives_{name}": (lambda c=c: with_change(c)) for name, c in CHANGES.items()}
    | {
        f"lacks_{n}": (lambda n=n: without(n))
        for n in ("title", "order", "sweep", "effects", "observables", "coordinates", "read")
    }
    | {f"declares_{n}": (lambda d=d: type("Odd", (Plain,), d)) for n, d in ODD.items()}
    | {f"claims_{n}": (lambda d=d: type("Claims", (Plain,), d)) for n, d in CLAIMS.items()}
    | {n: (lambda v=v: v) for n, v in NO_CLASS.items()}
)
"""Engines that must cost their own row"""
FINE: dict[str, Callable[[], Any]] = (
    {
        f"{p}_{name}": (lambda p=p, a=a: acting(p, a))
        for p in ("build", "simulate", "read")
        for name, a in HARMLESS.items()
    }
    | {f"info_{name}": (lambda v=v: with_info(v)) for name, v in INFO_FINE.items()}
    | {"plain": lambda: Plain}
)
"""Engines that pass"""


def __getattr__(name: str) -> Any:
    made = (ENGINES | FINE).get(name)
    if made is None:
        raise AttributeError(name)
    return made()
