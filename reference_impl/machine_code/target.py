"""Machine code for this processor from LLVM's representation."""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

import llvmlite
from llvmlite import binding as llvm

from reference_impl.machine_code.processor import processor

SPEED = 3
"""Level of optimization"""


@cache
def machine() -> Any:
    """LLVM's description of the processor."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = processor()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=SPEED, reloc="pic", codemodel="small")


def digest() -> bytes:
    """Hash of compiler and processor, which decide the machine code of a source."""
    name, features = processor()
    known = f"{llvmlite.__version__} {llvm.llvm_version_info} {name} {features} {SPEED}"
    return hashlib.sha256(known.encode()).digest()


def object_code(text: str) -> bytes:
    """Optimized machine code of a module, as an object file."""
    module = llvm.parse_assembly(text)
    options = llvm.create_pipeline_tuning_options(speed_level=SPEED)
    options.loop_vectorization = True
    options.slp_vectorization = False  # it would pair unlike operations, and round them in another order
    builder = llvm.create_pass_builder(machine(), options)
    builder.getModulePassManager().run(module, builder)
    made: bytes = machine().emit_object(module)
    return made
