"""Figures, one a file. Each file has `data(...)`, what would be drawn, and `draw(...)`, a matplotlib Figure of it.

Figures are built without pyplot and leave no global state behind; what they show is tested through `data`.
"""

from . import (
    calibration as calibration,
)
from . import (
    candidates as candidates,
)
from . import (
    coefficients as coefficients,
)
from . import (
    confusion as confusion,
)
from . import (
    failure_map as failure_map,
)
from . import (
    follows as follows,
)
from . import (
    four_bar as four_bar,
)
from . import (
    isobars as isobars,
)
from . import (
    ladder as ladder,
)
from . import (
    laws_compared as laws_compared,
)
from . import (
    measured_against_model as measured_against_model,
)
from . import (
    over_pressure as over_pressure,
)
from . import (
    profiles as profiles,
)
from . import (
    residual_pattern as residual_pattern,
)
from . import (
    signature as signature,
)
from .style import to_png as to_png
from .style import to_svg as to_svg
