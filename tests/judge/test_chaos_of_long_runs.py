"""Right engines on chaotic scenes of many orbits: tight settings, sparse samples, parted attitudes in air and light."""

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.judge.checks.beyond_limit import doubtful_increments, fault_between_segments
from barchain.judge.checks.restart import LINEAR_RAD, restart_segments
from barchain.judge.error_model import ErrorModel
from barchain.solutions.reference import ReferenceSolution
from reports.results.outcome import Outcome
from scenarios import Scene, make_scene
from tests.judge.trust_cases import judged
from tests.support.solutions import REFERENCE, run, solution_of

TIGHT, DEFAULT = (Setting(AccuracyParameter.RTOL, rtol) for rtol in (1e-12, 1e-8))


def tumbling() -> Scene:
    """Three unequal bars that tumble about their joints for 34 orbits; two right runs part after 2 to 10."""
    return make_scene({
        "title": "Three bars that tumble", "source": "drawn at random",
        "orbit": {"altitude_m": 1.389e6, "speed_factor": 1.099},
        "chain": {
            "bars": 3, "mass_kg": [32.32, 136.9, 116.3], "length_m": [27.82, 7.169, 1.238],
            "angle_deg": [-155.9, -146.6, 88.77], "rate_factor": [-1.797, 0.2471, 1.297],
        },
        "effects": {"gravity": "gradient"},
        "run": {"orbits": 34.4, "samples": 801},
    })  # fmt: skip


@pytest.fixture(scope="module")
def chaos() -> ReferenceSolution:
    return solution_of(tumbling())


@pytest.mark.exhaustive
def test_a_tight_engine_is_restarted_only_as_far_as_its_amplification_was_measured(chaos: ReferenceSolution) -> None:
    """A perturbation of 3e-5 rad leaves the linear range 1e8 times sooner than an engine's errors of 1e-13."""
    main, finer = run(chaos.scene, 1e-12), run(chaos.scene, 1e-13)
    verdict = judged(chaos, main, finer, engine=REFERENCE, setting=TIGHT)
    assert verdict.outcome is Outcome.PASS
    errors = ErrorModel(REFERENCE, TIGHT, chaos, main)
    assert errors.limit_s < 0.8 * main.t_s[-1]  # there is something to restart
    first = int(np.count_nonzero(main.t_s <= errors.limit_s)) - 1
    segments = restart_segments(errors, main, first)
    assert max(s.allowed["attitude"].max() for s in segments) < LINEAR_RAD
    late = main.t_s > 1.1 * errors.limit_s
    wrong = main.replace(angle_rad=main.angle_rad + 1e-3 * late[:, None])
    assert judged(chaos, wrong, finer, engine=REFERENCE, setting=TIGHT).outcome is Outcome.EXCEEDS_BOUND


@pytest.mark.slow
def test_samples_far_apart_beside_the_motion_raise_a_doubt_that_a_restart_settles(chaos: ReferenceSolution) -> None:
    main = run(chaos.scene, 1e-8)
    errors = ErrorModel(REFERENCE, DEFAULT, chaos, main)
    first = int(np.count_nonzero(main.t_s <= errors.limit_s)) - 1
    few = restart_segments(errors, main, first)[:1]
    assert len(doubtful_increments(chaos.scene, main, first)) > 0  # rates that turn between two samples
    assert fault_between_segments(errors, main, few, first, extra={}) is None
    at = (np.arange(len(main.t_s)) == len(main.t_s) - 5)[:, None]
    turned = main.replace(angle_rad=main.angle_rad + 3.0 * at)
    assert fault_between_segments(errors, turned, few, first, extra={}) is not None


def test_a_setting_too_coarse_for_a_chaotic_scene_says_so_and_fails_nothing(chaos: ReferenceSolution) -> None:
    coarse = Setting(AccuracyParameter.RTOL, 1e-3)
    verdict = judged(chaos, run(chaos.scene, 1e-3), run(chaos.scene, 1e-4), engine=REFERENCE, setting=coarse)
    assert verdict.outcome is Outcome.TOO_COARSE
    assert verdict.outcome.ok
    assert not verdict.outcome.judged
    assert any("rtol=0.001" in row["reason"] for row in verdict.rows)
