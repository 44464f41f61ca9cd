"""Engines, and planted faults in some of them, on random scenes: how often the judge is wrong.

    python benchmarks/random_scenes.py 100 --out random                      # scenes 0 to 99, all installed engines
    python benchmarks/random_scenes.py 100 --seed 5000                       # scenes 5000 to 5099
    python benchmarks/random_scenes.py 300 --engine pymunk --host none       # false alarms of one engine, no faults
    python benchmarks/random_scenes.py 20 --host exudyn --fault mu           # one fault in one engine

Exits with 1 if a fault is missed that is larger than the verdict's own limit of detection, or if more than 0.5 % of the
verdicts on unmodified engines are false alarms. docs/studies/selftest.md has the method and the ratings.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from random_campaign.campaign import FAULTS, HOSTS, MOST_RERUNS, on_random_scenes, passed, rates
from random_campaign.rating import Rating
from random_campaign.shrinking import kinds, written

from adapters.registry import engines
from barchain.cli.common.progress import counted
from barchain.cli.common.terminal import show_rows
from barchain.runs.choices import chosen_engines
from barchain.runs.executors import KeptAnswers, LocalProcesses

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from random_campaign.rating import RatedTrial

NONE = "none"
"""No host, for no faults"""
ENGINE_RATINGS = (Rating.PASS, Rating.LIMITED, Rating.FALSE_ALARM, Rating.UNSUPPORTED, Rating.LATE)
FAULT_RATINGS = (Rating.CAUGHT, Rating.MISSED, Rating.BELOW, Rating.BEYOND, Rating.NOTHING, Rating.BROKEN)
MOST_SHRUNK = 5
"""Kinds of findings that get a simpler scene"""
SHRINK_S = 60.0


def options() -> argparse.Namespace:
    """Command line, checked."""
    installed = [name for name, registration in engines().items() if not registration.missing]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=int, metavar="N", help="Draw N scenes.")
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="Begin with scene number K; default: 0.")
    parser.add_argument(
        "--engine", dest="engines", action="append", choices=installed, metavar="NAME",
        help="Judge this engine unmodified. May be repeated; default: the installed ones of the default set.",
    )  # fmt: skip
    parser.add_argument(
        "--host", dest="hosts", action="append", choices=[*installed, NONE], metavar="NAME",
        help=f"Insert faults into this engine, or `{NONE}`. May be repeated; default: {', '.join(HOSTS)}.",
    )  # fmt: skip
    parser.add_argument(
        "--fault", dest="faults", action="append", choices=FAULTS, metavar="NAME",
        help="Insert this fault. May be repeated; default: all.",
    )  # fmt: skip
    parser.add_argument(
        "--reruns", type=int, default=MOST_RERUNS, metavar="K",
        help="Run K faults that need runs of their own in each host and scene; default: 3.",
    )  # fmt: skip
    parser.add_argument(
        "--shrink-seconds", type=float, default=SHRINK_S, metavar="S",
        help="With --out: look for a simpler scene of each finding for this time, in seconds; default: 60.",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, metavar="FOLDER",
        help="Write scenes of findings into this folder, and keep runs there: another call goes on from them.",
    )  # fmt: skip
    asked = parser.parse_args()
    if asked.scenes < 1 or asked.seed < 0 or asked.reruns < 0 or not asked.shrink_seconds >= 0.0:
        parser.error("N is at least 1; --seed, --reruns and --shrink-seconds are not negative")
    return asked


def show_counts(
    what: str, names: Iterable[str], found: Iterable[tuple[str, Rating]], ratings: Sequence[Rating]
) -> None:
    """Print the numbers of ratings by name."""
    counts, headings = Counter(found), list(map(str, ratings))
    rows = [(name, *(str(counts[name, rating] or "") for rating in ratings)) for name in names]
    show_rows((what, *headings), rows, right=headings)


def finding_words(finding: RatedTrial, times: int) -> str:
    """Finding as one line of text."""
    what = f"{finding.fault} in {finding.engine}" if finding.fault else finding.engine
    often = f" ({times} times)" if times > 1 else ""
    size = "" if finding.size is None else f" {finding.size:.2g}, stated as detected from {finding.limit or 0.0:.2g} on"
    said = f"{finding.rating}: {what} on {finding.scene}{often}: {finding.outcome}, {finding.quantity}{size}"
    return " ".join(f"{said} {finding.reason}".split())


def main() -> int:
    """Try, and print ratings, findings and rates."""
    asked = options()
    hosts = tuple(name for name in dict.fromkeys(asked.hosts or HOSTS) if name != NONE)
    judged = asked.engines or [name for name, each in chosen_engines(None).items() if not each.missing]
    unmodified, faults = tuple(dict.fromkeys((*judged, *hosts))), tuple(dict.fromkeys(asked.faults or FAULTS))
    executor = KeptAnswers(asked.out / "answers", LocalProcesses()) if asked.out else LocalProcesses()
    numbers = range(asked.seed, asked.seed + asked.scenes)
    with counted("scenes", asked.scenes) as done:
        trials = on_random_scenes(numbers, unmodified, hosts, faults, asked.reruns, executor, done)
    sound, faulty = ([one for one in trials if bool(one.fault) is planted] for planted in (False, True))
    show_counts("engine", unmodified, ((one.engine, one.rating) for one in sound), ENGINE_RATINGS)
    if faulty:
        show_counts("fault", faults, ((one.fault, one.rating) for one in faulty), FAULT_RATINGS)
    for k, group in enumerate(kinds(one for one in trials if one.is_finding)):
        seconds, place = asked.shrink_seconds if k < MOST_SHRUNK else 0.0, ""
        if asked.out:
            place = f"; {written(group[0], asked.out, seconds, executor)}"
        print(finding_words(group[0], len(group)) + place, flush=True)
    print(*rates(trials), "passed" if passed(trials) else "not passed", sep="\n")
    return 0 if passed(trials) else 1


if __name__ == "__main__":
    sys.exit(main())
