"""Libraries of compiled functions: built when first called, kept on disk, called from Python."""

from __future__ import annotations

import hashlib
import threading
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import scipy
from llvmlite import binding as llvm

from reference_impl.machine_code import signatures, store, target
from reference_impl.machine_code.functions import Compiled
from reference_impl.machine_code.unit import lowered

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


@cache
def package_digest() -> bytes:
    """Hash of the package's sources, with all constants of compiled code, and of SciPy's version: its coefficients."""
    found = hashlib.sha256(scipy.__version__.encode())
    for source in sorted(Path(__file__).parents[1].rglob("*.py")):
        found.update(source.read_bytes())
    return found.digest()


LINKING = threading.RLock()
"""Held while code is compiled and linked: threads that call a function first at the same time link it once"""


@cache
def engine() -> Any:
    """LLVM's linker of this process.

    JITLink takes memory for all sections of a library at once. The older RuntimeDyld takes memory for code and for
    constants separately. In a process with gigabytes of mapped memory they came to lie more than 2 GiB apart, beyond
    the reach of the code's references, and LLVM aborted the process.
    """
    return llvm.create_lljit_compiler(target.machine(), use_jit_link=True)


class Library:
    """Machine code of functions that Python calls, and of those that they call."""

    def __init__(self, name: str, functions: Iterable[Callable[..., object]]) -> None:
        """Claim functions decorated by ``compiled``; they are compiled when one is called first."""
        self.name = name
        self.entries = [function for function in functions if isinstance(function, Compiled)]
        for function in self.entries:
            function.entries = self.entry

    @cached_property
    def key(self) -> str:
        """Name of its file: hash of sources, compiler and processor."""
        found = hashlib.sha256(target.digest() + package_digest())
        for function in self.entries:  # which may lie outside the package
            found.update(f"{self.name} {function.source.name} {function.source.text}".encode())
        return found.hexdigest()[:32]

    @property
    def is_kept(self) -> bool:
        """Whether its machine code is on disk."""
        return store.read(self.key) is not None

    @cached_property
    def code(self) -> bytes:
        """Machine code, from disk or compiled now."""
        found = store.read(self.key)
        if found is None:
            machine = target.machine()
            found = target.object_code(lowered(self.name, self.entries, machine.triple, str(machine.target_data)))
            store.write(self.key, found)
        return found

    @cached_property
    def addresses(self) -> dict[str, int]:
        """Addresses of the entries in this process."""
        linked = llvm.JITLibraryBuilder().add_object_img(self.code).add_current_process()
        for function in self.entries:
            linked.export_symbol(function.source.name)
        self.tracker = linked.link(engine(), f"{self.name} {self.key}")
        return {f.source.name: self.tracker[f.source.name] for f in self.entries}

    def entry(self, function: Compiled) -> Callable[..., Any]:
        """Entry as a function of Python."""
        signature = signatures.signature(function.source)
        with LINKING:
            address = self.addresses[function.source.name]
        machine_code = signature.c_type(address)

        def call(*arguments: Any) -> Any:
            return machine_code(*signature.words(arguments))

        call.address = address  # type: ignore[attr-defined]
        return call
