"""How fast is our rigid fit beside batched `jnp.linalg.svd`?

    python bench/rigid_fit.py [--quick]

Both are compiled and warmed up first (compiling is timed apart); then they run in turns. `batch` is our face with the
batch first, `lanes` the one that other kernels call; ratios are over our time.
"""

from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np
from _rows import Row, run
from _timing import paired, seconds

from dshpm_jax._kernels.rigid_fit import rigid_fit, rigid_fit_lanes

MANY = 1024  # fits, from which on the time is that of the fits and not that of the call


def svd_fit(model, data, weights):
    """The textbook fit: the covariance's singular vectors, the third turned where they would reflect."""
    share = weights / weights.sum(-1, keepdims=True)
    model_mean, data_mean = (jnp.einsum("bm,bmi->bi", share, x) for x in (model, data))
    model, data = model - model_mean[:, None], data - data_mean[:, None]
    u, _, vt = jnp.linalg.svd(jnp.einsum("bm,bmi,bmj->bij", share, data, model))
    u = u.at[:, :, 2].multiply(jnp.sign(jnp.linalg.det(u @ vt))[:, None])
    rotation = u @ vt
    residuals = data - jnp.einsum("bij,bmj->bmi", rotation, model)
    rms = jnp.sqrt((share * (residuals**2).sum(-1)).sum(-1))
    return rotation, data_mean - jnp.einsum("bij,bj->bi", rotation, model_mean), rms


def cases(fits: int, markers: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    model = rng.normal(0, 100, (fits, markers, 3)).astype(np.float32)
    turn = np.linalg.qr(rng.normal(size=(fits, 3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))[:, None, None]
    data = (model @ turn + rng.normal(0, 3, model.shape) + 1000).astype(np.float32)
    return model, data, np.ones((fits, markers), np.float32)


def rows(quick: bool) -> Iterator[Row]:
    for fits in (64, 1024, 16384):
        for markers in (4,) if quick else (4, 10, 16):
            yield from contest(fits, markers, 7 if quick else 30)


def contest(fits: int, markers: int, runs: int) -> Iterator[Row]:
    batch = tuple(jnp.asarray(x) for x in cases(fits, markers))
    lanes = tuple(jnp.moveaxis(x, 0, -1) for x in batch)
    contests = [(jax.jit(rigid_fit_lanes), lanes), (jax.jit(rigid_fit), batch), (jax.jit(svd_fit), batch)]
    waiting = [lambda f=function, x=x: jax.block_until_ready(f(*x)) for function, x in contests]
    first = [seconds(function) for function in waiting]
    (ours, _, _), (_, in_batch, svd) = paired(waiting, runs)
    apart = jnp.abs(contests[1][0](*batch).rms - contests[2][0](*batch)[2]).max()
    case = f"{fits} fits of {markers} points"
    yield Row(case, "svd / batch", svd / in_batch, at_least=5.0 if fits >= MANY else None)
    yield Row(case, "svd / lanes", svd)
    yield Row(case, "lanes (us)", 1e6 * ours)
    yield Row(case, "compiling lanes (s)", first[0])
    yield Row(case, "residuals differ by (mm)", float(apart), at_most=1e-3)


if __name__ == "__main__":
    run(__doc__, rows)
