"""What is said of an attribute that nobody has: which may be meant."""

from typing import TYPE_CHECKING, Any

from ..core.nearest import no_attribute

HERE = {
    "to_frame": "dataframe describe df head iloc loc pandas shape tail to_dataframe to_pandas",
    "inputs.displacement_mm": "displacement length",
    "inputs.velocity": "speed velocity",
    "inputs.temperature": "temperature",
    "inputs.seconds": "duration",
    "inputs.interval": "dt sample_rate sampling_rate",
    "pam.read(record, where=…)": "at_pressure filter query select where",
    "params": "best_values bse ci coef_ conf_int confidence_intervals parameters std_errors",
    "values": "coef",
    "n": "nobs ndata size",
    "valid": "converged success",
    "summary": "fit_report",
    "model": "equation formula to_latex",
    "r2": "rsquared score",
    "predict": "best_fit eval",
    "noise_floor": "noise sigma",
    "pam.diagnose(record, model)": "diagnose noise",
    "pam.compare(record, model)": "compare",
    "pam.ladder(record, law)": "ladder",
    "pam.fit(record, law)": "fit",
}
"""Names of other libraries for what has another name here, or lies elsewhere."""


class Hinting:
    """Names, for an attribute that is not there, those that look like it or whose documentation speaks of it."""

    if not TYPE_CHECKING:  # a checker would take any name for known

        def __getattr__(self, name: str) -> Any:
            kind = type(self)
            if name.startswith("_") or hasattr(kind, name):  # or one whose own work has failed
                return object.__getattribute__(self, name)
            public = [one for one in dir(self) if not one.startswith("_")]
            known = {one: getattr(kind, one).__doc__ or "" if hasattr(kind, one) else "" for one in public}
            usual = [one for one, names in HERE.items() if name in names.split()]
            there = [one for one in usual if one.split(".")[0] in (*known, "pam")]
            said = no_attribute(f"{kind.__name__!r} object", name, known, there)
            raise AttributeError(said, name=name, obj=None)  # of an obj Python would make a guess of its own, too
