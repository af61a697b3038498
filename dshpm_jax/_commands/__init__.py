"""The commands, a file each, in the order in which `--help` lists them.

Each file has `ABOUT`, a line for `--help`; `add_options`, which adds its options to a parser; and `run`, which does
what they ask and gives the exit status. Examples are in `examples.py`. Nothing here imports jax before it is needed:
`--help` and wrong usage answer at once.
"""

from types import ModuleType

from dshpm_jax._commands import check, demo, experiment, label, model, models, reconstruct, review, view

COMMANDS: dict[str, ModuleType] = {
    "demo": demo,
    "model": model,
    "models": models,
    "label": label,
    "check": check,
    "view": view,
    "review": review,
    "experiment": experiment,
    "reconstruct": reconstruct,
}
