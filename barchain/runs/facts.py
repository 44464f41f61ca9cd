"""Entries of engines, scenes and runs in a record."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from barchain.record.scene_description import effect_words, invariant_words
from barchain.runs.asking import engine_class, engine_fault
from reports.tables.reading import digest
from reports.tables.rows import frame_digest
from reports.tables.writing import parquet

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.registry import Registration
    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job, RunResult
    from scenarios import Scene


def engine_facts(registration: Registration) -> dict[str, Any]:
    """Entry of an engine in record.json."""
    facts: dict[str, Any] = {
        "external": registration.external,
        "version": registration.version,
        "missing": registration.missing,
    }
    try:
        loaded = engine_class(registration)
    except Exception as error:
        return facts | {"missing": facts["missing"] or engine_fault(error)}
    return facts | {
        "title": loaded.title,
        "coordinates": str(loaded.coordinates),
        "parameter": str(loaded.sweep.parameter),
        "default": loaded.sweep.default,
        "order": loaded.order,
    }


def scene_facts(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in record.json; lengths in m, times in s."""
    return {
        "title": scene.title,
        "source": scene.source,
        "description": scene.description,
        "tags": list(scene.tags),
        "digest": scene.digest,
        "bars": scene.bars,
        "length_m": list(scene.chain.length_m),
        "mass_kg": list(scene.chain.mass_kg),
        "angle_deg": [math.degrees(angle) for angle in scene.chain.angle_rad],
        "angle_from": scene.chain.angle_from,
        "rate_factor": list(scene.chain.rate_factor),
        "period_s": scene.period_s,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "gravity": str(scene.effects.gravity),
        "effects": effect_words(scene),
        "conserved": invariant_words(scene),
        "radius0_m": scene.radius0_m,
        "speed_factor": scene.orbit.speed_factor,
        "body_radius_m": scene.central_body.radius_m,
        "mean_motion_rad_s": scene.mean_motion_rad_s,
        "prescribed": [
            {
                "bar": p.bar,
                "amplitude_deg": math.degrees(p.amplitude_rad),
                "start_s": p.start_s,
                "duration_s": p.duration_s,
                "frame": str(p.frame),
                "actuator": str(p.actuator),
            }
            for p in scene.effects.prescribed_rotation
        ],
    }


def external_versions(engines: Mapping[str, Registration]) -> dict[str, str]:
    """Versions of the distributions that the engines require."""
    return {name: r.version for r in engines.values() if (name := r.requires or r.distribution)}


def scene_words(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in a study's record."""
    return {
        "title": scene.title,
        "source": scene.source,
        "orbits": scene.run.duration_s / scene.period_s,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "bars": scene.bars,
    }


def keep_run(store: StudyStore, job: Job, result: RunResult) -> None:
    """Write a run's samples as the series ``trajectories/<scene>/<engine>``, and note the run in the record."""
    trajectory = result.trajectory
    frame = None if trajectory is None else trajectory.of_run(job.scene).to_frame()
    content = None if frame is None else parquet(frame)
    name = f"trajectories/{job.scene.name}/{job.file_stem}"
    file = None if content is None else store.files.series_name(name)
    store.record["runs"].append({
        "scene": job.scene.name,
        "engine": job.engine,
        "setting": str(job.setting),
        "role": str(job.role),
        "outcome": str(result.outcome),
        "reason": result.reason,
        "seconds": result.seconds,
        "info": {} if trajectory is None else trajectory.info,
        "file": file,
        "digest": None if content is None else digest(content),
        "rejected": result.rejected,
        "bits": "" if frame is None else frame_digest(frame),
    })  # fmt: skip
    if file is None or content is None:
        store.write_record()
    else:
        store.write_file(file, content)
