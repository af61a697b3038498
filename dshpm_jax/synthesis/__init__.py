"""Articulated figures in motion with markers on them: people, robot arms, hands, and ways to spoil their recordings.

Plain numpy, everything from seeds: for the demo, the tests, the bench and the paper's experiments (section 5.2).
"""

from dshpm_jax.synthesis._corruption import Truth as Truth
from dshpm_jax.synthesis._corruption import add_ghosts as add_ghosts
from dshpm_jax.synthesis._corruption import distort as distort
from dshpm_jax.synthesis._corruption import open_gaps as open_gaps
from dshpm_jax.synthesis._corruption import scramble as scramble
from dshpm_jax.synthesis._figure import SegmentNames as SegmentNames
from dshpm_jax.synthesis._figure import Synthetic as Synthetic
from dshpm_jax.synthesis._machines import hand as hand
from dshpm_jax.synthesis._machines import robot_arm as robot_arm
from dshpm_jax.synthesis._people import person as person
