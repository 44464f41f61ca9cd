"""Chapters of all studies, in the order of the report."""

from __future__ import annotations

from reports.chapter import Chapter
from reports.chapters.campaign.view import view_campaign
from reports.chapters.cost.view import view_cost
from reports.chapters.effects.view import view_effects
from reports.chapters.ensemble.view import view_ensemble
from reports.chapters.releases.view import view_releases
from reports.chapters.roundoff.view import view_roundoff
from reports.chapters.scaling.view import view_scaling
from reports.chapters.selftest.view import view_selftest
from reports.chapters.stability.view import view_stability
from reports.tables.schema import RECORD

CHAPTERS = (
    Chapter("cost", "Cost of accuracy", ("points.csv", RECORD), view_cost),
    Chapter("scaling", "Cost against the number of bars", ("points.csv", RECORD), view_scaling),
    Chapter("roundoff", "Round-off in absolute and relative coordinates", (RECORD,), view_roundoff),
    Chapter("effects", "Relevance of each effect", ("effects.csv", RECORD), view_effects),
    Chapter(
        "selftest",
        "Detection of inserted faults",
        ("selftest.csv", RECORD),
        view_selftest,
        in_report=False,
    ),
    Chapter(
        "campaign",
        "Random campaign",
        ("campaign.csv", "rates.csv", RECORD),
        view_campaign,
        command="selftest --random N",
        in_report=False,
    ),
    Chapter(
        "stability",
        "Numerical stability on hard scenes",
        ("outcomes.csv", "evidence.csv", RECORD),
        view_stability,
        in_report=False,
    ),
    Chapter(
        "releases",
        "Releases of an engine",
        ("releases.csv", RECORD),
        view_releases,
        in_report=False,
    ),
    Chapter("ensemble", "Ensemble of perturbed runs", ("quantiles.csv", RECORD), view_ensemble, in_report=False),
)
