"""The numbers of the full method as the benches move them."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, fields
from importlib import import_module
from unittest.mock import patch

import dshpm_jax


def _number(default, *names: str):
    return field(default=default, metadata={"places": names, "group": names[0].partition(":")[0]})


@dataclass(frozen=True)
class Tuning:
    """Stands in for `dshpm_jax._control.tuning`."""

    accept_llr: float = _number(2.0, "evidence:ACCEPT", "decision:ACCEPT", "settling:ACCEPT", "assignment:ACCEPT")
    extra_starts: tuple[float, ...] = _number((1.3, 2.0, 4.0), "full:MORE_STARTS")
    restart_frame_step: int = _number(3, "full:FEWER")
    patience: int = _number(3, "settling:PATIENCE")
    keep_llr: float = _number(0.5, "settling:HOLD")
    min_part_frames: int = _number(3, "dividing:LEAST_FRAMES")
    confidence_base: float = _number(0.6, "decision:BASE")
    confidence_per_nat: float = _number(0.75, "decision:PER_NAT")
    confidence_per_decade: float = _number(1.45, "decision:PER_DECADE")
    rescaled_share: float = _number(0.86, "decision:RESCALED")
    poor_fit_below: float = _number(0.8, "decision:POOR_FIT")
    poor_fit_share: float = _number(0.83, "decision:FITTED_BADLY")


TUNING = Tuning()


def label_many(recordings: Iterable, models, settings=None, driver=None, tuning: Tuning = TUNING) -> Iterator:
    with ExitStack() as stack:
        for one in fields(Tuning):
            for place in one.metadata["places"]:
                module, name = place.split(":")
                home = import_module(f"dshpm_jax._control.{module}")
                if hasattr(home, name):
                    stack.enter_context(patch.object(home, name, getattr(tuning, one.name)))
        yield from list(dshpm_jax.label_many(recordings, models, settings, driver))
