"""Pictures and pages of what was labelled; nothing here labels, and nothing imports jax."""

from dshpm_jax.report._view import Page as Page
from dshpm_jax.report._view import view as view
from dshpm_jax.report._view import view_frame as view_frame
