"""What is there already, and what is left to do."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.hashes import FORM, INPUT, MODEL, SETTINGS, hash_file, hash_form, hash_settings, read_models
from dshpm_jax._archive.jobs import Job
from dshpm_jax._archive.outcomes import Outcome, failed, figures_in, judged
from dshpm_jax._archive.said import APPLIED, applied_of, corrections_of
from dshpm_jax._outcomes import FAILED, KEPT
from dshpm_jax._settings import Settings

_REMEDY = "move it away or give another folder for the results"
_KINDS = {INPUT: "its input", MODEL: "its model", SETTINGS: "the settings", FORM: "the form of results"}

_CORRECTIONS = "what persons corrected"


@dataclass(frozen=True)
class Due:
    """A job with something to do, and why."""

    job: Job
    why: str


class ResultStatus:
    """Tells jobs that are due from those whose result is up to date, has to stay, or cannot be.

    Files are hashed only where there is a result to compare with, so that a first run starts at once.
    """

    def __init__(self, out: Path, settings: Settings, force: bool, owners: Mapping[str, str] | None = None):
        """`owners` says of results, by their places in `out`, which recordings they are of."""
        self._out, self._settings, self._force = out, settings, force
        self._owners = owners or {}
        self._models: dict[tuple[Path, ...], str] = {}

    def of(self, job: Job) -> Due | Outcome:
        if job.problem:
            return Outcome(job, FAILED, f"{job.source}: {job.problem}")
        try:
            return self._of(job)
        except Exception as error:
            return failed(job, error)

    def _of(self, job: Job) -> Due | Outcome:
        if job.models not in self._models:
            self._models[job.models] = read_models(job.models)[1]
        target, sidecar = self._out / job.target, self._out / job.sidecar
        if not target.exists() and not sidecar.exists():
            return Due(job, "has no result yet")
        head = io.read_sidecar(sidecar, column_runs=False) or {}
        hashes = {
            INPUT: hash_file(job.source),
            SETTINGS: hash_settings(self._settings),
            MODEL: self._models[job.models],
            **hash_form(job.form),
        }
        applied = applied_of(corrections_of(job, self._out))
        changed = [kind for name, kind in _KINDS.items() if head.get("hashes", {}).get(name) != hashes.get(name)]
        changed += [_CORRECTIONS] if head.get(APPLIED, []) != applied else []
        own = head.get("result", target.name) == target.name
        if target.exists() and "figures" in head and own and not changed and not self._force:
            return judged(job, self._settings, hashes, figures_in(head), was_there=True)
        places = (job.target, job.target.with_name(head.get("result", target.name)))
        if _KINDS[INPUT] in changed and (reason := self._owned_by_another(job, places)):
            return Outcome(replace(job, clashes=True), KEPT, reason, hashes)
        reason = kept_because(target, sidecar)
        earlier = None if own else replaced_by(target, sidecar)
        if earlier is not None and earlier.exists() and os.path.samefile(earlier, job.source):
            reason = f"{job.source}: its result would take its place; give another folder for the results"
        if reason:
            return Outcome(job, KEPT, reason, hashes)
        return Due(job, _why(target, changed, "" if own else head["result"]))

    def _owned_by_another(self, job: Job, places: Iterable[Path]) -> str:
        """Why a result at one of `places` must not give way, as it is that of another recording; or nothing."""
        for place in places:
            path, owner = self._out / place, self._owners.get(place.as_posix())
            if owner is None or not path.exists() or not os.path.exists(owner):
                continue
            if not os.path.samefile(owner, job.source):
                return f"{path}: is the result of {owner}, not overwritten; {_REMEDY}"
        return ""


def _why(target: Path, changed: list[str], other: str) -> str:
    if other:
        return f"has a result in another format, {other}, which gives way"
    if not target.exists():
        return "has no result any more"
    return f"{' and '.join(changed)} changed since it was labelled" if changed else "is labelled again by force"


def kept_because(target: Path, sidecar: Path) -> str:
    """Why the result at `target` must not be overwritten, or nothing: it is not ours, or not as we wrote it."""
    head = io.read_sidecar_head(sidecar)
    if head is None:
        foreign = next((path for path in (target, sidecar) if path.exists()), None)
        return f"{foreign}: is there and none of our results, not overwritten; {_REMEDY}" if foreign else ""
    of = sidecar.with_name(head.get("result", target.name))
    if target.exists() and of != target:
        return f"{target}: is there, and {sidecar.name} is that of {of.name}, not overwritten; {_REMEDY}"
    if of.exists() and hash_file(of) != head.get("output"):
        return f"{of}: was changed by somebody after it was labelled, not overwritten; {_REMEDY}"
    return ""


def replaced_by(target: Path, sidecar: Path) -> Path | None:
    """The result that gives way to one at `target`, as it is that of the same recording in another format."""
    head = io.read_sidecar_head(sidecar)
    earlier = sidecar.with_name(head.get("result", target.name)) if head else target
    return earlier if earlier != target else None
