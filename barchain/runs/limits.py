"""Limits of a process that runs an engine of another package."""

from __future__ import annotations

from dataclasses import dataclass

QUESTION_S = 30.0  # for an import, a declaration or a claim: the slowest package known here imports in eight seconds
MEMORY_B = 4 * 2**30
"""Memory of an engine and its children: a hundred times what the largest scene of the core suite needs"""
OUTPUT_B = 32 * 2**20
"""Text that an engine may print in one run"""
FILE_B = 2 * 2**30
"""Largest file that an engine may write, its answer included"""
TEXT_LENGTH = 500
"""Characters of a message that are kept"""


@dataclass(frozen=True)
class OutsideLimits:
    """Limits of one process."""

    time_s: float = QUESTION_S
    """Wall time"""
    memory_B: int = MEMORY_B
    """Resident memory of the engine and its children, B"""
    output_B: int = OUTPUT_B
    """Text on standard output and error, B"""
