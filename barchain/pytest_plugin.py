"""Plugin of pytest for authors of engines: ``pytest --barchain-engine NAME``, a test for each scene of conformance.

Nothing else of barchain is imported unless the option is given: the plugin is loaded wherever barchain is installed.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.nightly.gate.known import KnownFailure

MARK = "barchain"


class SceneFailedError(Exception):
    """Raised for a scene that fails; the message is all that is shown."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("barchain")
    group.addoption(
        "--barchain-engine", action="append", default=[], metavar="NAME",
        help="Examine this engine: a test for each scene of `barchain conform`. May be repeated.",
    )  # fmt: skip
    group.addoption(
        "--barchain-known", default="known_failures.toml", metavar="FILE",
        help="Expect the failures that this file lists; default: known_failures.toml, if it is there.",
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark by which scenes are selected, or left out."""
    config.addinivalue_line("markers", f"{MARK}: a scene in which barchain examines an engine")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the scenes of each engine, before other plugins select."""
    for name in config.getoption("barchain_engine"):
        items += EngineScenes.from_parent(session, name=name, nodeid=f"{MARK}::{name}").collect()


class EngineScenes(pytest.Collector):
    """Scenes of one engine, whose runs are made together with the first test."""

    def collect(self) -> Iterable[SceneItem]:
        """One test for each scene; one that is known to fail is expected to."""
        from adapters.registry import UnknownEngineError  # noqa: PLC0415
        from barchain.conform.scenes_alone import EVERY, ScenesAlone  # noqa: PLC0415
        from barchain.nightly.errors import HistoryError  # noqa: PLC0415
        from barchain.nightly.gate.known import known_failures  # noqa: PLC0415

        try:
            self.scenes = ScenesAlone(self.name)
            known = known_failures(self.config.rootpath / Path(self.config.getoption("barchain_known")))
        except (UnknownEngineError, HistoryError) as error:
            raise pytest.UsageError(str(error)) from None
        made: list[SceneItem] = [SceneItem.from_parent(self, name=name) for name in EVERY]
        for item in made:
            item.expect(known)
        return made


class SceneItem(pytest.Item):
    """Test of one scene."""

    parent: EngineScenes
    over: KnownFailure | None = None
    """Known failure that has ended"""

    def expect(self, known: Iterable[KnownFailure]) -> None:
        """Mark the test, by the known failures that cover the verdict of its scene."""
        self.add_marker(MARK)
        for one in known:
            if one.covers(f"{self.name}:{self.parent.name}::verdict"):
                if one.ended:
                    self.over = self.over or one
                else:
                    self.add_marker(pytest.mark.xfail(reason=one.words, raises=SceneFailedError, strict=False))

    def runtest(self) -> None:
        """Examine the scene: it passes also with a warning, and is skipped if the engine does not support it."""
        wanted = [
            item.name for item in self.session.items if isinstance(item, self.__class__) and item.parent is self.parent
        ]
        check = self.parent.scenes.check(self.name, wanted)
        said = (
            f"{self.parent.name} in {self.name} {check.state}: {check.words}{f' ({check.page})' if check.page else ''}"
        )
        if self.over is not None:
            pytest.fail(f"a known failure has ended: {self.over.words}\n{said}", pytrace=False)
        if check.state == "failed":
            raise SceneFailedError(said)
        if check.state in {"unsupported", "not run"}:
            pytest.skip(said)
        self.user_properties.append((MARK, said))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *more: Any, **named: Any) -> Any:
        """Words on the scene alone: a traceback through barchain tells an author nothing."""
        if isinstance(excinfo.value, SceneFailedError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, *more, **named)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Place and title of the test."""
        return self.config.rootpath, None, f"{self.parent.name} in {self.name}"
