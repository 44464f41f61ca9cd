"""Answers kept in a folder: a command that goes on after an interruption finds them there, and asks for the rest."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

from barchain.runs.answer_key import answer_key
from barchain.runs.call import Answer, CallEnd
from barchain.runs.session import Session
from reports.tables.files import ANSWERS
from reports.tables.writing import make_folder, write_atomically

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator
    from pathlib import Path

    from barchain.runs.call import Call

CHECK_B = hashlib.sha256().digest_size


class AnswerStore:
    """Answers of calls in a study's folder, each in a file of its own."""

    def __init__(self, folder: Path | None = None) -> None:
        """Open the store inside the folder of a study; without a folder nothing is kept."""
        self.folder = None if folder is None else make_folder(folder, ANSWERS)

    def find(self, call: Call) -> Answer | None:
        """Answer of an earlier call; None if there is none, or a damaged one, which is asked for again."""
        file = None if self.folder is None else self.folder / answer_key(call)
        if file is None or not file.is_file():
            return None
        found = file.read_bytes()
        check, content = found[:CHECK_B], found[CHECK_B:]
        return Answer(content) if check == checksum(content) else None

    def keep(self, call: Call, answer: Answer) -> None:
        """Keep an answer; a failure is not kept, and is tried again."""
        if self.folder is not None and answer.end is CallEnd.ANSWERED and call.worth_keeping(answer.content):
            write_atomically(self.folder / answer_key(call), checksum(answer.content) + answer.content)

    def answer(self, call: Call, make: Callable[[Call], Answer]) -> Answer:
        """Answer of an earlier call, or the one that `make` gives now, which is kept."""
        found = self.find(call)
        if found is None:
            found = make(call)
            self.keep(call, found)
        return found


class KeptSession(Session):
    """Session that passes on calls without a kept answer, and keeps the answers that come."""

    def __init__(self, inside: Session, folder: Path) -> None:
        super().__init__()
        self.inside, self.store = inside, AnswerStore(folder)
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
        """Answers, as :meth:`barchain.runs.session.Session.answers`, each kept before it is given."""
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


def checksum(content: bytes) -> bytes:
    """Bytes in front of a kept content, by which a damaged one is known."""
    return hashlib.sha256(content).digest()
