"""Answers kept in a folder, each by its key: all that decides it, and nothing else.

A command that goes on after an interruption finds them there, and asks for the rest. The key is that of the function
with its arguments, the modules that it imports, and Python with its numerical libraries. Of each engine among the
arguments it is the adapter with its imports, the engine's distribution and those that this requires, by content; of a
program the files that its entry names. A changed document, report or study makes no run anew, a changed adapter those
of its engines only.
"""

from __future__ import annotations

import ast
import hashlib
import io
import pickle
import platform
import struct
from collections import Counter
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from sysconfig import get_path
from types import FunctionType
from typing import TYPE_CHECKING, Any

from adapters.registry import ENGINES, Registration, engines
from barchain.record.environment import blas, package_version, processor
from barchain.record.sources import contents_digest, digest_of, required_by
from barchain.runs.call import FILE_B, Answer, CallEnd
from barchain.runs.pool import Session
from reference_impl.kernel.build import source_digest, why_missing
from reports.results.writing import make_folder, write_atomically

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator

    from barchain.runs.call import Call

OURS = ("adapters", "barchain", "reference_impl", "scenarios")
"""Packages whose modules count one by one"""
PRESENTATION = "reports"
"""Package that decides no run"""
LIBRARIES = ("numpy", "scipy", "gmpy2")
"""Libraries beside those of engines that compute; a version of one is one content"""
KERNEL = "reference_impl.kernel"
"""Package whose sources in C count with its modules, and whether it can be used"""
DIGITS = 40
CHECK_B, SECONDS = hashlib.sha256().digest_size, struct.Struct("<d")
HEAD_B = CHECK_B + SECONDS.size
"""Bytes in front of an answer's content: the check, and the time that it took, s"""
ASKED, KEPT = "asked", "kept"


class Ingredients(pickle.Pickler):
    """Pickler that notes where the code of its objects lies."""

    def __init__(self, call: Call) -> None:
        """Pickle a call's function, arguments and number of the repetition."""
        self.sink = io.BytesIO()
        super().__init__(self.sink, protocol=5)
        self.modules: set[str] = set()
        """Modules of all functions, and of the classes of all objects"""
        self.registrations: set[Registration] = set()
        self.dump((call.function, call.given, call.repetition))
        self.content = self.sink.getvalue()
        for name, found in (other_engines() | ENGINES).items():  # some functions know engines by name: a short text
            if b"\x8c%c%s" % (len(name), name.encode("ascii")) in self.content:
                self.registrations.add(found)

    def reducer_override(self, found: Any) -> Any:
        """Note an object, and pickle it as usual."""
        if isinstance(found, Registration):
            self.registrations.add(found)
        code = found if isinstance(found, (type, FunctionType)) else type(found)
        self.modules.add(str(code.__module__))
        return NotImplemented


@cache
def other_engines() -> dict[str, Registration]:
    """Engines of other packages, which are looked for once in a process."""
    return {name: found for name, found in engines().items() if name not in ENGINES}


def answer_key(call: Call) -> str:
    """Key of a call's answer; limits do not count, as an answer that is there came within some."""
    found = Ingredients(call)
    targets = {registration.target.partition(":")[0] for registration in found.registrations}
    ours = frozenset(name for name in found.modules | targets if root_of(top_of(name)) is not None)
    others = sorted({top_of(name) for name in targets} - set(OURS))
    installed = {name for r in found.registrations for name in (r.requires, r.distribution) if name}
    programs = sorted(registration.version for registration in found.registrations if registration.entry)
    code = closure_digest(ours), *map(digest_of, others), *map(distribution_text, sorted(installed)), *programs
    parts = (*machine_parts(), *code)
    return hashlib.sha256("\0".join(parts).encode() + found.content).hexdigest()[:DIGITS]


def top_of(module: str) -> str:
    """Top-level package of a module."""
    return module.partition(".")[0]


@cache
def machine_parts() -> tuple[str, ...]:
    """Python, libraries that compute, and the processor: they decide the last bits, and times."""
    libraries = [f"{name} {package_version(name)}" for name in LIBRARIES]
    return platform.python_version(), *libraries, blas(), platform.machine(), processor()


@cache
def distribution_text(name: str) -> str:
    """Version and contents of a distribution, and of those that it requires."""
    names = (name, *sorted(required_by(name)))
    return " ".join(f"{each} {package_version(each)} {contents_digest(each)}" for each in names)


@cache
def closure_digest(modules: frozenset[str]) -> str:
    """Digest of modules of ours and of all that they import."""
    found, ahead = dict[str, str](), sorted(modules)
    while ahead:
        name = ahead.pop()
        if name not in found:
            found[name], more = known_module(name)
            ahead += more
    content = sorted(found.items())
    kernel = source_digest() + why_missing() if any(name.startswith(KERNEL) for name in found) else ""
    return hashlib.sha256(f"{content} {kernel}".encode()).hexdigest()


@cache
def known_module(name: str) -> tuple[str, tuple[str, ...]]:
    """Digest of a module, and the names that it imports; nothing of what is installed, or no module."""
    path = source_of(name)
    if path is None:
        return "", ()
    text = path.read_bytes()
    return hashlib.sha256(text).hexdigest(), tuple(dict.fromkeys(imported(ast.parse(text).body)))


@cache
def root_of(top: str) -> Path | None:
    """Folder of a top-level package, or file of a module; None if it is installed, and so known by its distribution.

    Our own packages count wherever they are; others where they lie beside an engine, on the path of somebody's own.
    """
    if top in OURS:
        return Path(import_module(top).__path__[0])
    if top == PRESENTATION:
        return None
    try:
        found = find_spec(top)
    except (ImportError, ValueError):
        return None
    if found is None or found.origin is None or not found.has_location:
        return None
    path = Path(found.origin)
    root = path.parent if found.submodule_search_locations else path
    with_python = any(path.is_relative_to(get_path(kind)) for kind in ("stdlib", "platstdlib", "purelib", "platlib"))
    return None if with_python or any(root.parent.glob("*.dist-info")) else root  # or of another environment


def source_of(module: str) -> Path | None:
    """Source of a module that is not installed; None if it is none."""
    top, *inside = module.split(".")
    root = root_of(top)
    if root is None or root.is_file():
        return None if inside else root
    folder = root.joinpath(*inside)
    place = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    return place if place.is_file() else None


def imported(statements: Iterable[Any]) -> Iterator[str]:
    """Names that statements import, those in functions too, but not those for type checking alone."""
    for each in statements:
        if isinstance(each, ast.Import):
            yield from (alias.name for alias in each.names)
        elif isinstance(each, ast.ImportFrom) and each.module:
            yield from (each.module, *(f"{each.module}.{alias.name}" for alias in each.names))
        elif not (isinstance(each, ast.If) and "TYPE_CHECKING" in ast.unparse(each.test)):
            for inner in ("body", "orelse", "finalbody", "handlers"):
                yield from imported(getattr(each, inner, ()))


class AnswerStore:
    """Answers of calls in a folder, each in a file of its own with the time that it took."""

    def __init__(self, folder: Path | None = None, tally: Counter[str] | None = None) -> None:
        """Open the store in a folder; without one nothing is kept.

        A `tally` counts the answers that are asked for, and those of them that are there.
        """
        self.folder = None if folder is None else make_folder(folder, "")
        self.tally = Counter[str]() if tally is None else tally

    def find(self, call: Call) -> Answer | None:
        """Answer of an earlier call; None if there is none, or a damaged one, which is asked for again."""
        self.tally[ASKED] += 1
        file = None if self.folder is None else self.folder / answer_key(call)
        if file is None or not file.is_file() or file.stat().st_size > FILE_B:
            return None
        found = file.read_bytes()
        check, content = found[:CHECK_B], found[CHECK_B:]
        answer = unpacked(content) if check == checksum(content) else None
        self.tally[KEPT] += answer is not None
        return answer

    def keep(self, call: Call, answer: Answer) -> None:
        """Keep an answer; a failure is not kept, and is tried again."""
        if self.folder is not None and answer.end is CallEnd.ANSWERED and call.worth_keeping(answer.content):
            content = SECONDS.pack(answer.seconds) + answer.content
            write_atomically(self.folder / answer_key(call), checksum(content) + content)

    def answer(self, call: Call, make: Callable[[Call], Answer]) -> Answer:
        """Answer of an earlier call, or the one that `make` gives now, which is kept."""
        found = self.find(call)
        if found is None:
            found = make(call)
            self.keep(call, found)
        return found


class KeptSession(Session):
    """Session that passes on calls without a kept answer, and keeps the answers that come."""

    def __init__(self, inside: Session, folder: Path, tally: Counter[str] | None = None) -> None:
        super().__init__()
        self.inside, self.store = inside, AnswerStore(folder, tally)
        self.done = inside.done
        self.calls: dict[Hashable, Call] = {}
        """Calls whose answers are still to come"""

    def start(self, key: Hashable, call: Call) -> None:
        """Give the kept answer, or pass the call on."""
        found = self.store.find(call)
        if found is not None:
            self.done.put((key, found))
            return
        self.calls[key] = call
        self.inside.submit(key, call)

    def answers(self, *, wait: bool = True) -> Iterator[tuple[Any, Answer]]:
        """Answers, as :meth:`barchain.runs.pool.Session.answers`, each kept before it is given."""
        for key, answer in super().answers(wait=wait):
            call = self.calls.pop(key, None)
            if call is not None:
                self.inside.left -= 1
                self.store.keep(call, answer)
            yield key, answer

    def side_by_side(self) -> int:
        """Calls that run at the same time."""
        return self.inside.side_by_side()

    def close(self) -> None:
        """End everything."""
        self.inside.close()


def unpacked(content: bytes) -> Answer:
    """Answer from the kept content behind its check."""
    return Answer(content[SECONDS.size :], seconds=SECONDS.unpack_from(content)[0])


def checksum(content: bytes) -> bytes:
    """Bytes in front of a kept content, by which a damaged one is known."""
    return hashlib.sha256(content).digest()
