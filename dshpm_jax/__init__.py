"""Labels unlabelled optical motion capture against an articulated marker model, without training."""

from dshpm_jax._hierarchy import Segment as Segment
from dshpm_jax._labelling import Labelling as Labelling
from dshpm_jax._labelling import Reason as Reason
from dshpm_jax._model import SubjectModel as SubjectModel
from dshpm_jax._recording import Recording as Recording
