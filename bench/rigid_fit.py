"""How fast is our rigid fit beside batched `jnp.linalg.svd`?

    python bench/rigid_fit.py [--runs N]

Both are compiled and warmed up first (compiling is timed apart); then they run in turns, and the medians are printed.
`batch` is the face with the batch first, `lanes` the one that other kernels call. On two shared CPU cores, jax 0.10:

      fits points        svd      batch      lanes  svd/lanes  compile
      1024      4       3672        693        559        6.6     2.87
      1024     16       5530       1819       1458        3.8     2.74
     16384      4      84209      15387      17059        4.9     3.38
     16384     16     126088      52062      49946        2.5     4.44
"""

import argparse
import time
from collections.abc import Callable
from statistics import median

import jax
import jax.numpy as jnp
import numpy as np

from dshpm_jax._kernels.rigid_fit import rigid_fit, rigid_fit_lanes


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


def timed(function: Callable, *arguments) -> float:
    start = time.perf_counter()
    jax.block_until_ready(function(*arguments))
    return time.perf_counter() - start


def cases(fits: int, markers: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    model = rng.normal(0, 100, (fits, markers, 3)).astype(np.float32)
    turn = np.linalg.qr(rng.normal(size=(fits, 3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))[:, None, None]
    data = (model @ turn + rng.normal(0, 3, model.shape) + 1000).astype(np.float32)
    return model, data, np.ones((fits, markers), np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=30)
    runs = parser.parse_args().runs
    print(f"{jax.devices()[0]}; medians of {runs} runs in turns, microseconds; first call in seconds")
    print(f"{'fits':>6} {'points':>6} {'svd':>10} {'batch':>10} {'lanes':>10} {'svd/lanes':>10} {'compile':>8}")
    for fits in (64, 1024, 16384):
        for markers in (4, 10, 16):
            batch = tuple(jnp.asarray(x) for x in cases(fits, markers))
            lanes = tuple(jnp.moveaxis(x, 0, -1) for x in batch)
            contests = [(jax.jit(svd_fit), batch), (jax.jit(rigid_fit), batch), (jax.jit(rigid_fit_lanes), lanes)]
            first = [timed(function, *arguments) for function, arguments in contests]
            times = [[timed(function, *arguments) for function, arguments in contests] for _ in range(runs)]
            svd, ours, inner = (1e6 * median(t[k] for t in times) for k in range(3))
            print(f"{fits:6} {markers:6} {svd:10.0f} {ours:10.0f} {inner:10.0f} {svd / inner:10.1f} {first[1]:8.2f}")


if __name__ == "__main__":
    main()
