"""Commands `nightly`, `history`, `attribute`, `bisect` and `releases`; `documents` also decides a night's exit code."""
