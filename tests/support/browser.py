"""An installed Chromium without a window, for tests of pages."""

from __future__ import annotations

import shutil
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tests.support.machine import needs

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def browser_path() -> str | None:
    """Path of an installed Chromium; None without one."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


in_browser = needs("an installed Chromium", there=browser_path() is not None)
"""Mark of a test that opens pages"""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Headless Chromium.

    Raises
    ------
    RuntimeError
        If none is installed.
    """
    from playwright.sync_api import sync_playwright

    path = browser_path()
    if path is None:
        raise RuntimeError(f"no Chromium is installed; looked for: {', '.join(BROWSERS)}")
    with sync_playwright() as driver:
        yield driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
