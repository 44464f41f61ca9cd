"""Answers kept in a folder: a command that goes on after an interruption finds them there, and asks for the rest."""

from __future__ import annotations

import hashlib
import pickle
from functools import cache
from typing import TYPE_CHECKING, Any

from barchain.record.environment import package_version, packages
from barchain.runs.call import Answer, CallEnd
from barchain.runs.session import Session
from barchain.runs.versions import code_versions
from reports.tables.files import ANSWERS
from reports.tables.writing import make_folder, write_atomically

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterator
    from pathlib import Path

    from barchain.runs.call import Call

CHECK_B = hashlib.sha256().digest_size


class KeptSession(Session):
    """Session that passes on calls without a kept answer, and keeps the answers that come."""

    def __init__(self, inside: Session, folder: Path) -> None:
        super().__init__()
        self.inside, self.folder = inside, make_folder(folder, ANSWERS)
        self.done = inside.done
        self.files: dict[Hashable, Path] = {}
        """Files of the answers that are still to come"""

    def start(self, key: Hashable, call: Call) -> None:
        """Give the kept answer, or pass the call on."""
        file = self.folder / file_name(call)
        content = kept_content(file)
        if content is not None:
            self.done.put((key, Answer(content)))
            return
        self.files[key] = file
        self.inside.submit(key, call)

    def answers(self, *, wait: bool = True) -> Iterator[tuple[Any, Answer]]:
        """Answers, as :meth:`barchain.runs.session.Session.answers`; a failure is not kept, and is tried again."""
        for key, answer in super().answers(wait=wait):
            file = self.files.pop(key, None)
            if file is not None:
                self.inside.left -= 1
                if answer.end is CallEnd.ANSWERED:
                    write_atomically(file, checksum(answer.content) + answer.content)
            yield key, answer

    def side_by_side(self) -> int:
        """Calls that run at the same time."""
        return self.inside.side_by_side()

    def close(self) -> None:
        """End everything."""
        self.inside.close()


def file_name(call: Call) -> str:
    """Name of an answer's file: hash of the code, the function and its arguments.

    Limits do not count: an answer that is there came within some, and a call without one is made again.
    """
    work = pickle.dumps((call.function, call.given), protocol=5)
    return hashlib.sha256(versions_text() + work).hexdigest()[:40]


@cache
def versions_text() -> bytes:
    """Versions of barchain, of its engines and of what computes in them: all code that decides answers."""
    found = packages() | code_versions() | {"gmpy2": package_version("gmpy2")}
    return repr(sorted(found.items())).encode()


def checksum(content: bytes) -> bytes:
    """Bytes in front of a kept content, by which a damaged one is known."""
    return hashlib.sha256(content).digest()


def kept_content(file: Path) -> bytes | None:
    """Content of a kept answer; None if there is none, or a damaged one, which is asked for again."""
    if not file.is_file():
        return None
    found = file.read_bytes()
    check, content = found[:CHECK_B], found[CHECK_B:]
    return content if check == checksum(content) else None
