"""The only door between host and device."""

from dshpm_jax._driver.driver import Driver

__all__ = ["Driver"]
