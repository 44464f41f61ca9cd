"""Process whose free address space is a few small holes far above one wide gap, as after the loading of many libraries.

Run with Python: prints the last angle of a compiled run. Linux.
"""

from __future__ import annotations

import ctypes

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from reference_impl.machine_code.library import Library, engine
from scenarios import load_scene

PAGE_B, APART_B = 4096, 4 << 30
PRIVATE_UNRESERVED = 0x4022  # MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE
HOLES, HOLE_PAGES = 60, 3  # which take the constants
FILLED, GAP_PAGES = 1000, 8  # larger gaps could take the code

libc = ctypes.CDLL(None)
libc.mmap.restype = ctypes.c_void_p
libc.mmap.argtypes = (ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3, ctypes.c_long)
libc.munmap.argtypes = (ctypes.c_void_p, ctypes.c_size_t)


def taken(size_B: int) -> int:
    """Address of unused address space that is taken."""
    found: int = libc.mmap(None, size_B, 0, PRIVATE_UNRESERVED, -1, 0)
    return found


def crowd() -> None:
    """Fill the address space below the libraries, but for holes."""
    for pages in (1024, 256, 64, 16, 4, 1):
        for _ in range(HOLES):
            taken(pages * PAGE_B)
    holes = []
    for _ in range(HOLES):
        holes.append(taken(HOLE_PAGES * PAGE_B))
        taken(PAGE_B)
    taken(APART_B)
    for _ in range(FILLED):
        taken(GAP_PAGES * PAGE_B)
    for hole in holes:
        libc.munmap(hole, HOLE_PAGES * PAGE_B)


def main() -> None:
    """Crowd the process just before code is linked."""
    read = Library.code.func  # type: ignore[attr-defined]

    def read_and_crowd(library: Library) -> bytes:
        found: bytes = read(library)
        engine()
        crowd()
        return found

    Library.code = property(read_and_crowd)  # type: ignore[assignment]
    scene, setting = load_scene("paper/fig05"), Setting(AccuracyParameter.RTOL, 1e-8)
    print(ENGINES["reference-fast"].load()().run(scene, setting).angle_rad[-1, 0].hex())  # type: ignore[index]


if __name__ == "__main__":
    main()
