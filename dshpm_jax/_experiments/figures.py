"""How the figures look: one column of a journal a panel, the same colours throughout, as PNG and PDF."""

import io
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from dshpm_jax.io._atomic import write_whole

COLOURS = {"static": "#d55e00", "paper": "#0072b2", "full": "#009e73"}  # told apart by the colour-blind too
INK, FAINT = "#222222", "#dddddd"
PANEL = (3.5, 2.8)  # inches
DPI = 300
STYLE: Any = {
    **{"font.size": 8.5, "axes.titlesize": 9.5, "axes.labelsize": 9, "legend.fontsize": 8, "legend.frameon": False},
    **{"axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7, "axes.edgecolor": INK},
    **{"axes.grid": True, "grid.color": FAINT, "grid.linewidth": 0.5, "axes.axisbelow": True},
    **{"lines.linewidth": 1.4, "lines.markersize": 3.6, "xtick.major.width": 0.7, "ytick.major.width": 0.7},
    **{"xtick.direction": "out", "ytick.direction": "out", "pdf.fonttype": 42, "figure.constrained_layout.use": True},
}


def panels(count: int, size: tuple[float, float] = PANEL) -> tuple[Any, list[Any]]:
    """A figure of some panels side by side that share the vertical axis; to be made and drawn in `style`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(count * size[0], size[1]), facecolor="white")
    return figure, list(figure.subplots(1, count, sharey=True, squeeze=False)[0])


def style() -> AbstractContextManager[None]:
    """Within it, figures look as they should.

    Raises:
        ModuleNotFoundError: matplotlib is not there; the message says how to get it.
    """
    try:
        from matplotlib import rc_context
    except ImportError as missing:
        raise ModuleNotFoundError("figures need matplotlib: pip install 'dshpm-jax[pictures]'") from missing
    return rc_context(STYLE)


def save(figure: Any, path: Path) -> None:
    """Writes the figure as `path` with the suffixes .png and .pdf, each whole or not at all."""
    for suffix in (".png", ".pdf"):
        image = io.BytesIO()
        figure.savefig(image, format=suffix[1:], dpi=DPI)
        write_whole(path.with_suffix(suffix), [image.getvalue()])
