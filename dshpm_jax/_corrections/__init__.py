"""What persons say about the labels of a result, kept beside it and never made twice."""

from dshpm_jax._corrections._file import Corrections as Corrections
from dshpm_jax._corrections._file import CorrectionsError as CorrectionsError
from dshpm_jax._corrections._file import append as append
from dshpm_jax._corrections._file import check_belongs as check_belongs
from dshpm_jax._corrections._file import corrections_path as corrections_path
from dshpm_jax._corrections._file import read_corrections as read_corrections
from dshpm_jax._corrections._format import Change as Change
from dshpm_jax._corrections._format import Correction as Correction
from dshpm_jax._corrections._locking import Locked as Locked
from dshpm_jax._corrections._locking import locked as locked
