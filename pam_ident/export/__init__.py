"""Models and results for other programs: as code, equations and tables. Each module stands alone, for some need JAX."""
