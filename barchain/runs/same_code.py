"""Code of a cluster's processes: results are those of this machine only if all have the same versions."""

from __future__ import annotations

import json
from functools import cache
from typing import TYPE_CHECKING, Any

from barchain.record.environment import package_version
from barchain.record.sources import contents_digest, digest_of
from barchain.runs.call import WrongWorkerError
from barchain.runs.message import plain_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.registry import Registration

LIBRARIES = ("numpy",)
"""Packages beside barchain whose version decides the last bits"""
PROTOCOL = ("python", "dask", "distributed")
"""Packages whose difference breaks messages between processes"""
SOURCES = ("adapters", "barchain", "reference_impl", "scenarios")
REMEDY = "install the same versions there"


@cache
def code_versions() -> dict[str, str]:
    """Versions that decide results, in this process: barchain with its sources, and libraries."""
    found = {name: package_version(name) for name in LIBRARIES}
    return {"barchain": f"{package_version('barchain')} (sources {digest_of(*SOURCES)})"} | found


def versions_bytes() -> bytes:
    """These versions as JSON."""
    return json.dumps(code_versions()).encode("ascii")


def version_of(registration: Registration) -> str:
    """Version of the package that an engine needs, and of another's engine the digest of its installed files."""
    name = registration.requires or registration.distribution
    digest = f" {contents_digest(registration.distribution)}" if registration.distribution else ""
    return f"{name} {package_version(name)}{digest}" if name else ""


def need_same_version(here: str, there: str) -> None:
    """Check that a package has its sender's version; workers may join after the first check.

    Raises
    ------
    WrongWorkerError
        If it has not.
    """
    if here != there:
        raise WrongWorkerError(f"has {here}, expected {there}")


def difference(there: Mapping[str, object], here: Mapping[str, object]) -> str:
    """First version that differs, in words; empty if none does."""
    for name, version in here.items():
        if there.get(name) != version:
            return f"has {name} {plain_text(there.get(name), 80)}, here {plain_text(version, 80)}"
    return ""


def protocol_fault(found: Mapping[str, Any]) -> str:
    """First process of a cluster with another Python or Dask than here, in words; empty if there is none.

    Parameters
    ----------
    found : mapping
        From ``Client.get_versions``.
    """
    here = protocol(found["client"])
    places = {"the scheduler": found["scheduler"]} | {f"worker {k}": v for k, v in found["workers"].items()}
    return first_fault({place: difference(protocol(versions), here) for place, versions in places.items()})


def protocol(versions: Mapping[str, Any]) -> dict[str, str]:
    """Versions of the packages that messages depend on; of Python its major and minor number."""
    found = versions.get("packages", {})
    shown = {name: str(found.get(name)) for name in PROTOCOL}
    return shown | {"python": ".".join(shown["python"].split(".")[:2])}


def code_fault(found: Mapping[str, Any]) -> str:
    """First worker with other code than here, in words; empty if there is none.

    Parameters
    ----------
    found : mapping
        Versions of each worker, or the exception that it raised.
    """
    here = code_versions()
    return first_fault(
        {
            f"worker {worker}": import_words(there) if isinstance(there, BaseException) else difference(there, here)
            for worker, there in found.items()
        }
    )


def first_fault(places: Mapping[str, str]) -> str:
    """First place with a fault, and the remedy."""
    return next((f"{place} {why}; {REMEDY}" for place, why in places.items() if why), "")


def import_words(error: BaseException) -> str:
    """Words on a worker that can't load barchain's code."""
    return f"can't load barchain's code ({type(error).__name__}: {plain_text(error, 160)})"


def task_fault(error: BaseException) -> str:
    """Words on a batch of calls that failed on the cluster."""
    name = type(error).__name__  # classes of Dask are an extra
    if name == "KilledWorker":
        deaths = int(getattr(error, "allowed_failures", 0)) + 1
        return f"a task was lost with its worker (deaths: {deaths}); logs or memory limits of workers may tell why"
    if name == "FutureCancelledError":
        return f"the scheduler dropped a task ({plain_text(error, 160)})"
    if isinstance(error, (ImportError, AttributeError)):
        return f"a worker {import_words(error)}; {REMEDY}"
    return f"a task failed there ({name}: {plain_text(error, 200)})"
