"""What a model can be exported to."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from .fitted import Fitted


@dataclass(frozen=True)
class Written:
    """Text or bytes of a file, text of others beside it by their endings, what is to be said of them, and what those
    beside it hold by which an earlier one is known, that may be replaced."""

    text: str | bytes
    beside: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    mark: str = ""


@dataclass(frozen=True)
class Target:
    """Files of a kind end in `suffix`; `write` puts a model into the content of one, in which its function is called
    `name`. It raises UsageError for a name that the language does not take, or a model that cannot be exported."""

    suffix: str
    write: Callable[[Fitted, str], Written]
