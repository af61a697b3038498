"""Files to recordings and models, and back; nothing here imports jax."""

from dshpm_jax.io._c3d import write_c3d as write_c3d
from dshpm_jax.io._errors import NoPoints as NoPoints
from dshpm_jax.io._errors import ReadError as ReadError
from dshpm_jax.io._errors import WriteError as WriteError
from dshpm_jax.io._filled import write_filled as write_filled
from dshpm_jax.io._form import Form as Form
from dshpm_jax.io._frame_numbers import first_frame as first_frame
from dshpm_jax.io._how import kept as kept
from dshpm_jax.io._labelled import write_labelled as write_labelled
from dshpm_jax.io._model_file import SUBJECT_FILES as SUBJECT_FILES
from dshpm_jax.io._model_file import is_model as is_model
from dshpm_jax.io._model_file import read_model as read_model
from dshpm_jax.io._model_file import write_model as write_model
from dshpm_jax.io._points_hash import points_hash as points_hash
from dshpm_jax.io._read import SUFFIXES as SUFFIXES
from dshpm_jax.io._read import may_be_recording as may_be_recording
from dshpm_jax.io._read import read as read
from dshpm_jax.io._segments_file import read_segments as read_segments
from dshpm_jax.io._sidecar import read_sidecar as read_sidecar
from dshpm_jax.io._sidecar import read_sidecar_head as read_sidecar_head
from dshpm_jax.io._sidecar import sidecar as sidecar
from dshpm_jax.io._sidecar import sidecar_path as sidecar_path
from dshpm_jax.io._sidecar import write_sidecar as write_sidecar
