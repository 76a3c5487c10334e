import sys

import lmfit
import numpy as np
import pandas as pd

data = pd.read_csv(sys.argv[1])


def law(p, e, a0, a1, b0, b1, c0, c1, mu):
    return a0 + a1 * p - (b0 + b1 * p) * e + (c0 + c1 * p) * np.exp(-mu * e)


fit = lmfit.Model(law, independent_vars=["p", "e"]).fit(
    data.force_N, p=data.pressure_MPa, e=data.displacement_mm / 200, a0=0, a1=2000, b0=0, b1=5000, c0=0, c1=500, mu=45
)
print(fit.fit_report())
