"""Whether an archive is labelled the same whatever happens to the run, and wherever it runs.

    python bench/archive_faults.py storm FOLDER [--every 10] [--runs 3]
    python bench/archive_faults.py ways FOLDER

FOLDER is what `bench/archive.py` made, with FOLDER/labelled from an undisturbed run.

`storm` labels it again with a random worker killed every 10 s, kills the whole run three times, and goes on each time
with the same command; then it goes on undisturbed. `ways` labels it in one process, on two workers, on the workers of a
scheduler, and in two shards at the same time. Both compare every file with the undisturbed run's and end with 1 if
any differs.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from archive import family, label_command

OF_THE_RUN = {"manifest.jsonl", "summary.csv", "report.html", "manifest-shards"}  # hold times


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("what", choices=("storm", "ways"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=float, default=10, help="seconds between two kills of a worker")
    parser.add_argument("--runs", type=int, default=3, help="how often the whole run is killed")
    parser.add_argument("--seconds", type=float, default=90, help="how long a run lives that is killed")
    arguments = parser.parse_args()
    good = storm(arguments) if arguments.what == "storm" else ways(arguments.folder)
    sys.exit(not good)


def storm(arguments: argparse.Namespace) -> bool:
    out = arguments.folder / "stormy"
    command = label_command(arguments.folder, out, "--workers", "2")
    kills = 0
    for run in range(arguments.runs):
        with subprocess.Popen(command, **quietly(arguments.folder, "stormy")) as process:
            kills += kill_workers(process, arguments.every, arguments.seconds)
            ended = process.poll()
            for pid in family(process.pid)[:1]:
                os.kill(pid, signal.SIGKILL)
        print(f"run {run + 1}: {f'ended by itself ({ended})' if ended is not None else 'killed'}, {standing(out)}")
    print(f"{kills} workers killed")
    status = subprocess.run(command, **quietly(arguments.folder, "stormy")).returncode
    print(f"last run, undisturbed: exit status {status}, {standing(out)}")
    return same(arguments.folder, out) and status == 0


def kill_workers(process: subprocess.Popen, every: float, seconds: float) -> int:
    """Kills a random worker again and again, until the run has ended or lived long enough."""
    end, kills = time.monotonic() + seconds, 0
    while time.monotonic() < end and process.poll() is None:
        time.sleep(every)
        workers = [pid for pid in family(process.pid)[1:] if is_worker(pid)]
        if workers:
            os.kill(random.choice(workers), signal.SIGKILL)
            kills += 1
    return kills


def is_worker(pid: int) -> bool:
    try:
        return b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def ways(folder: Path) -> bool:
    good = True
    for name, options in {"one": [], "two": ["--workers", "2"]}.items():
        good &= ran(folder, name, [options])
    with subprocess.Popen(scheduler(folder), **quietly(folder, "scheduler")) as running:
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-dashboard"]
        worker += ["--scheduler-file", str(folder / "scheduler.json"), "--local-directory", str(folder / "scratch")]
        with subprocess.Popen([*worker, "--nworkers", "2"], **quietly(folder, "workers")) as workers:
            while not (folder / "scheduler.json").exists():
                time.sleep(0.5)
            good &= ran(folder, "scheduler", [["--scheduler-file", str(folder / "scheduler.json")]])
            workers.terminate()
        running.terminate()
    return good & ran(folder, "shards", [["--shard", "0/2"], ["--shard", "1/2"]])


def scheduler(folder: Path) -> list[str]:
    (folder / "scheduler.json").unlink(missing_ok=True)
    module = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    return [*module, "--no-dashboard", "--scheduler-file", str(folder / "scheduler.json")]


def ran(folder: Path, name: str, options: list[list[str]]) -> bool:
    """Labels in one way, and compares."""
    out, start = folder / f"way {name}", time.monotonic()
    runs = [subprocess.Popen(label_command(folder, out, *some), **quietly(folder, name)) for some in options]
    statuses = [process.wait() for process in runs]
    print(f"{name}: exit status {statuses}, {time.monotonic() - start:.0f} s, {standing(out)}", flush=True)
    return same(folder, out)


def quietly(folder: Path, name: str) -> dict:
    """Where a process that speaks in the background writes."""
    stream = (folder / f"{name}.txt").open("a")
    return {"stdout": stream, "stderr": stream}


def standing(out: Path) -> str:
    results = len(list(out.rglob("*.labels.json")))
    manifest = out / "manifest.jsonl"
    outputs = []
    for line in manifest.read_text().splitlines() if manifest.exists() else ():
        try:
            outputs.append(json.loads(line)["output"])
        except ValueError:
            outputs.append(line)  # cut off
    return f"{results} results, {len(outputs)} rows for {len(set(outputs))} files"


def same(folder: Path, out: Path) -> bool:
    """Whether both runs wrote the same files, byte by byte, and the manifest has each recording once."""
    wanted, found = (contents(folder / "labelled"), contents(out))
    differing = [name for name in sorted(wanted.keys() | found.keys()) if wanted.get(name) != found.get(name)]
    rows = [json.loads(line)["output"] for line in (out / "manifest.jsonl").read_text().splitlines()]
    whole = sorted(rows) == sorted(name for name in wanted if not name.endswith((".labels.json", ".html")))
    print(
        f"{out.name}: {len(wanted)} files, {len(differing)} differ {differing[:3]}, each once in the manifest: {whole}"
    )
    return not differing and whole


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of the results, hidden ones too, but not those about the run."""
    files = (path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder): path for path in files}
    return {name.as_posix(): path.read_bytes() for name, path in names.items() if name.parts[0] not in OF_THE_RUN}


if __name__ == "__main__":
    main()
