"""Write this folder's record with the virtual rig, and the plant and the ladder that `pam-ident track` runs by itself.

python datasets/leg_muscle/make.py [DATASETS]
"""

import subprocess
import sys
from pathlib import Path

from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case

SPEEDS = (4.0, 30.0, 200.0)
"""mm/s; a knee at 1 Hz drives its muscles at up to 200."""
PROTOCOL = Protocol((0.1, 0.2, 0.3, 0.4, 0.5, 0.6), SPEEDS, cycles_per_speed=3, hold_s=1.0)
SECRETS = (
    Secret("pressure_friction", "contact_area", 8.0),
    Secret("viscous_damping", "textbook", 4.0),
    Secret("presliding_hysteresis", "textbook", 4.0),
)
PLANT = ("viscous_damping", "pressure_friction:contact_area", "presliding_hysteresis:maxwell_slip_3")


def main(datasets: Path) -> None:
    """Write record.csv, specimen.toml, plant.json and ladder.json to DATASETS/leg_muscle."""
    folder = datasets / "leg_muscle"
    write_case(folder, make_record(Plan(5, "exponential_law", SECRETS, protocol=PROTOCOL)))
    effects = [word for name in PLANT for word in ("--effect", name)]
    tasks = {
        "plant": ["fit", "record.csv", "--law", "exponential_law", *effects],
        "ladder": ["ladder", "record.csv", "--law", "chou_hannaford", "--free-geometry"],
    }
    for name, words in tasks.items():
        subprocess.run([sys.executable, "-m", "pam_ident", *words, "--json", f"{name}.json"], cwd=folder, check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1])
