"""Which recordings of a subject's folder a model is made of, and why not the others."""

from dshpm_jax._model_choice.choice import Choice as Choice
from dshpm_jax._model_choice.choice import choose as choose
from dshpm_jax._model_choice.choice import compare_labels as compare_labels
from dshpm_jax._model_choice.folders import folders_of as folders_of
from dshpm_jax._model_choice.folders import recordings_in as recordings_in
