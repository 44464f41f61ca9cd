"""Files that are judged: a right run, scenes from text, and verdicts."""

import pytest

from barchain import load_scene
from barchain.judge.diagnosis.diagnose import Diagnosis
from barchain.judge.written import Declared
from barchain.result_files import accuracy, verdict
from barchain.result_files.judging import judge_files
from tests.result_files.examples import frame_of

FREE = "basics/two_bars_free"
NOTHING = Declared()


@pytest.fixture
def scene_of(tmp_path):
    """Function that loads a scene from its text."""

    def made(text):
        (tmp_path / "scene.toml").write_text(text)
        return load_scene(tmp_path / "scene.toml")

    return made


@pytest.fixture(scope="module")
def right():
    return frame_of(FREE, rtol=1e-10)


@pytest.fixture
def judged(tmp_path):
    """Function that writes one or two tables with the options of pandas, and judges the files."""

    def made(frame, declared=NOTHING, finer=None, scene=FREE, mapping=None, digits=None, **how):
        paths = [tmp_path / "run.csv"] + [tmp_path / "finer.csv"] * (finer is not None)
        for path, each in zip(paths, (frame, finer), strict=False):
            each.to_csv(path, index=False, **how)
        return judge_files(scene, *paths, declared=declared, mapping=mapping, digits=digits, time_limit_s=60.0)

    return made


@pytest.fixture
def verdict_alone(judged, monkeypatch):
    """The same without a search for mistakes, which takes seconds where none explains a file, and moves no verdict."""

    def made(*given, **how):
        with monkeypatch.context() as patched:
            for searching in (verdict, accuracy):
                patched.setattr(searching, "diagnosis", lambda *_: Diagnosis(()))
            return judged(*given, **how)

    return made
