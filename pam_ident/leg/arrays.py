"""JAX in double precision; everything in `leg` takes it from here.

`Array` is one of JAX's, traced or not. Both are untyped, because the layers below are typed for NumPy's arrays, whose
methods these share.
"""

from typing import Any

import jax

jax.config.update("jax_enable_x64", True)
jnp: Any = jax.numpy
Array = Any

__all__ = ["Array", "jax", "jnp"]
