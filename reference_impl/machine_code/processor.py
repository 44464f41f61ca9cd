"""Processor that code is compiled for, and the width of its vector registers."""

from __future__ import annotations

import os
from functools import cache

from llvmlite import binding as llvm

PROCESSOR = "BARCHAIN_PROCESSOR"
"""Environment variable: LLVM's name of a processor to compile for, by default this machine's"""
WIDE = "avx512f"
"""Feature of processors with registers of eight doubles"""


@cache
def processor() -> tuple[str, str]:
    """Name and features of the processor to compile for."""
    given = os.environ.get(PROCESSOR)
    if given:
        return given, ""
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@cache
def register_width() -> int:
    """Doubles in the widest vector register: eight with AVX-512, otherwise four, or two registers of two."""
    return 8 if f"+{WIDE}" in processor()[1].split(",") else 4
