"""Workers that stay from test to test, for tests of what runs compute and not of the processes that run it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.runs import pool

if TYPE_CHECKING:
    from collections.abc import Iterator

WORKERS = pool.Slots()
OF_PROCESSES = {"boundary", "execution", "test_isolation.py", "test_sources.py"}
"""Folders and modules of tests that look at processes themselves"""


class SharedSession(pool.LocalSession):
    """Calls in workers that its end leaves to the next session, with the engines that they have loaded."""

    def __init__(self, workers: int | None = None) -> None:
        super().__init__(workers)
        self.slots = WORKERS

    def close(self) -> None:
        """End the calls that wait; those at work are awaited."""
        self.threads.shutdown(cancel_futures=True)


@pytest.fixture(autouse=True, scope="module")
def shared_workers(request: pytest.FixtureRequest) -> Iterator[None]:
    """Use the same workers in all sessions of a module's tests, except where these look at processes."""
    if OF_PROCESSES & set(request.path.parts):
        yield
        return
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pool, "LocalSession", SharedSession)
        yield
    WORKERS.close_idle()
