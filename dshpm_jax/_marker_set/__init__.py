"""What subjects of one marker set have in common, made from labelled recordings of some."""

from dshpm_jax._marker_set.marker_set import HandedFour as HandedFour
from dshpm_jax._marker_set.marker_set import MarkerSet as MarkerSet
from dshpm_jax._marker_set.marker_set import OddSubject as OddSubject
from dshpm_jax._marker_set.member import Member as Member
