"""Runs on worker processes: the same results, and deaths that cost no other file."""

import json
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Event

import dask
import distributed
import numpy as np
import pytest
from making import make_model, make_recording
from planted_faults import CRASHES, EATS_MEMORY, RAISES, plant
from running import MARKERS

from dshpm_jax import io
from dshpm_jax._archive import FAILED, LABELLED, Order, find_jobs, label_archive
from dshpm_jax._archive.dispatcher import label_on
from dshpm_jax._archive.outcomes import Outcome
from dshpm_jax._archive.workers import Workers, local_workers, workers_of
from dshpm_jax._messages import UsageError
from dshpm_jax._processes import ProcessPool

MEMORY = 600 << 20  # bytes; a worker without jax takes a fifth of it


@contextmanager
def planted(count, how_many=None):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dshpm_jax._archive.workers.ProcessPool", partial(ProcessPool, set_up=plant))
        with local_workers(count, MEMORY) as workers:
            yield workers._replace(how_many=lambda: how_many or count)


@contextmanager
def scheduler(count):
    """The address of a dask scheduler with planted workers."""
    options = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": False}
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        with distributed.LocalCluster(count, **options) as cluster, distributed.Client(cluster) as client:
            client.register_plugin(PlantedFaults())
            yield cluster.scheduler_address


class PlantedFaults(distributed.WorkerPlugin):
    def setup(self, worker):
        plant()


@pytest.fixture
def archive(tmp_path):
    folder = tmp_path / "archive"
    folder.mkdir()
    for k in range(8):
        io.write_c3d(make_recording(20, seed=k), folder / f"{k}.c3d")
    io.write_model(make_model(MARKERS), folder / "model.json")
    return folder


def run(archive, out, connect, told=None):
    """The outcomes, each of which comes once; what workers say is going on goes to `told`."""
    jobs, order = find_jobs([archive], (), out), Order(out, workers=2)
    if told is not None:
        order = replace(order, notice=told.append)
    outcomes = list(label_archive(jobs, order, label_on(connect)))
    assert len({o.job.target for o in outcomes}) == len(outcomes)
    return {o.job.target.name: o for o in outcomes}


def rows(out: Path) -> list[dict]:
    return [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]


@pytest.mark.slow
def test_deaths_cost_no_other_file(archive, tmp_path):
    for name, rate in {"crash": CRASHES, "hog": EATS_MEMORY, "raises": RAISES}.items():
        io.write_c3d(make_recording(20, rate=rate), archive / f"{name}.c3d")
    outcomes = run(archive, tmp_path / "out", partial(planted, 2))
    messages = {name: o.message for name, o in outcomes.items() if o.outcome == FAILED}
    assert sorted(messages) == ["crash.c3d", "hog.c3d", "raises.c3d"]
    for name in ("crash.c3d", "hog.c3d"):
        assert f"{name}: killed its worker 2 times" in messages[name] and "0.6 GB" in messages[name]
    assert messages["raises.c3d"].endswith("raises.c3d: RuntimeError: thirteen frames a second")
    assert sorted(row["output"] for row in rows(tmp_path / "out")) == sorted(outcomes)
    labelled = [name for name, o in outcomes.items() if o.outcome == LABELLED]
    assert sorted(labelled) == [f"{k}.c3d" for k in range(8)]
    assert all((tmp_path / "out" / name).exists() == (name in labelled) for name in outcomes)


@pytest.mark.slow
def test_who_waits_behind_a_file_that_kills_is_not_to_blame(archive, tmp_path):
    """A worker may be given several at a time, as where another has died and nobody has noticed."""
    for name in ("00.c3d", "01.c3d"):
        io.write_c3d(make_recording(20, rate=CRASHES), archive / name)
    outcomes = run(archive, tmp_path / "out", partial(planted, 1, 5))
    assert sorted(name for name, o in outcomes.items() if o.outcome == FAILED) == ["00.c3d", "01.c3d"]


def test_what_a_worker_tells_goes_on_before_its_batch_ends(archive, tmp_path):
    """A batch of all eight; the last is told of only when the first has gone on."""
    first = Event()

    def submit(told, function, jobs, *_):
        def label():
            told("reading 8 files")
            told(Outcome(jobs[0], LABELLED))
            assert first.wait(60)
            told(Outcome(jobs[1], LABELLED))
            return [Outcome(job, LABELLED) for job in jobs]

        return threads.submit(label)

    @contextmanager
    def connect():
        yield Workers(submit, lambda: 1, lambda error: 0)

    notices = []
    with ThreadPoolExecutor() as threads, pytest.MonkeyPatch.context() as patch:
        patch.setattr("dshpm_jax._archive.run._most", lambda *_: 8)
        jobs = find_jobs([archive], (), tmp_path / "out")
        outcomes = []
        for outcome in label_archive(jobs, Order(tmp_path / "out", notice=notices.append), label_on(connect)):
            outcomes.append(outcome.job)
            first.set()
    assert sorted(outcomes, key=str) == sorted(jobs, key=str) and notices == ["reading 8 files"]


def test_no_worker_is_started_for_nothing(tmp_path):
    @contextmanager
    def never():
        pytest.fail("there is nothing to do")
        yield

    (tmp_path / "archive").mkdir()
    (tmp_path / "archive" / "walk.c3d").write_bytes(b"")
    assert run(tmp_path / "archive", tmp_path / "out", never)["walk.c3d"].outcome == FAILED  # it has no model


def test_schedulers_that_are_not_there(tmp_path):
    (tmp_path / "scheduler.json").write_text("{}")
    for address, file in ((None, tmp_path / "nowhere.json"), (None, tmp_path / "scheduler.json"), ("tcp://", None)):
        with pytest.raises(UsageError), workers_of(address, file):
            pass


@pytest.mark.slow
def test_workers_of_a_scheduler_that_runs(archive, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # they run in another folder
    told = []
    whole = run(Path("archive"), tmp_path / "whole", partial(planted, 1), told)
    assert {"reading 1 file", "labelling 1 file"} <= set(told)
    told.clear()
    with scheduler(1) as address:
        monkeypatch.chdir(archive)
        found = run(Path("."), Path("../out"), partial(workers_of, address, None), told)
    assert {"reading 1 file", "labelling 1 file"} <= set(told)
    assert {name: o.outcome for name, o in found.items()} == {name: o.outcome for name, o in whole.items()}
    for path in (tmp_path / "whole").glob("*.c3d"):
        assert (tmp_path / "out" / path.name).read_bytes() == path.read_bytes()
    assert np.all([o.job.source == Path(o.job.target) for o in found.values()])
