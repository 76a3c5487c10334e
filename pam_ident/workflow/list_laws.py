"""The force laws that are known."""

from ..laws import Law, catalogue


def list_laws() -> tuple[Law, ...]:
    """Every law, those with the fewest parameters first."""
    return tuple(sorted(catalogue().values(), key=lambda law: (len(law.params), law.name)))
