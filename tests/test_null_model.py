"""Errors against a background: the densities are those of scipy, and what is expected is what samples have."""

import numpy as np
import pytest
from scipy import stats

from dshpm_jax._control.tuning import TUNING
from dshpm_jax._null_model import expected_llr, llr_at_mean

NULL = TUNING.null_model


@pytest.mark.parametrize("dimensions", [1, 3])
@pytest.mark.parametrize("sd", [2.0, 15.0])
def test_the_ratio_is_that_of_a_t_density_to_an_even_one(dimensions, sd):
    density = stats.multivariate_t(np.zeros(dimensions), np.eye(dimensions) * sd**2, df=NULL.t_dof)
    wanted = density.logpdf(np.zeros(dimensions)) + dimensions * np.log(NULL.background_mm)
    assert llr_at_mean(NULL, np.log(sd), dimensions) == pytest.approx(wanted)


@pytest.mark.parametrize("dimensions", [1, 3])
def test_what_is_expected_is_the_mean_of_samples(dimensions):
    sd = 6.0
    density = stats.multivariate_t(np.zeros(dimensions), np.eye(dimensions) * sd**2, df=NULL.t_dof)
    errors = density.rvs(200_000, random_state=1)
    ratios = density.logpdf(errors) + dimensions * np.log(NULL.background_mm)
    assert expected_llr(NULL, np.float64(sd), dimensions) == pytest.approx(ratios.mean(), abs=0.02)
