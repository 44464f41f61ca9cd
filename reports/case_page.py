"""Page of a case: one file for a browser, without a network, that compares a table with the case's certified samples.

It is the one page with a script. Its policy allows that script alone, by its hash.
"""

from __future__ import annotations

import base64
import hashlib
import json
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from reports.page import surroundings, templates

if TYPE_CHECKING:
    from collections.abc import Mapping

SCRIPT = "case/compare.js"


def case_page(case: Mapping[str, Any]) -> str:
    """HTML of a case's page.

    Parameters
    ----------
    case : mapping
        Samples, error bars and tubes, as `barchain.result_files.case.page_data` makes them.
    """
    loader = templates().loader
    assert loader is not None
    script = loader.get_source(templates(), SCRIPT)[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    data = json.dumps(case, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return templates().get_template("case/page.html.j2").render(
        case=case, script=Markup(script), script_hash=digest, data=Markup(data), **surroundings({})
    )  # fmt: skip
