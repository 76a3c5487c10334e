"""Numbers as they are read, the same wherever they are shown."""

import math
from collections.abc import Sequence


def number(value: float | None, digits: int = 4) -> str:
    """Significant digits, without a power of ten for everyday sizes; a dash for no value."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0:
        return "0"
    size = _size(value, digits)
    return f"{value:.{max(digits - 1 - size, 0)}f}" if -4 <= size <= 6 else f"{value:.{digits - 1}e}"


def three(value: float | None) -> str:
    """Three significant digits."""
    return number(value, 3)


def newtons(value: float | None) -> str:
    """A force in N with three digits, as zero below a millionth of a newton and as that beyond a million: no muscle's,
    but a law's that does not carry to lengths it has not seen."""
    if value is not None and abs(value) < 1e-6:
        return "0 N"
    if value is not None and 1e6 < value < math.inf:
        return "over a million N"
    return f"{three(value)} N"


def millimetres(value: float | None) -> str:
    """A length in mm with three digits."""
    return f"{three(value)} mm"


def known_to(value: float, error: float) -> str:
    """A value to the place of its standard error's second digit, at most eight digits; six without an error."""
    if not (error > 0 and math.isfinite(error)) or value == 0:
        return f"{value:.6g}" if math.isfinite(value) else "-"
    places = 1 - _size(error)
    if not -2 <= places <= 8 or _size(value) > 6 or _size(value) + places >= 8:
        return number(value, min(max(_size(value) + places + 1, 1), 8))
    return f"{round(value, max(places, 0)) + 0.0:.{max(places, 0)}f}"  # no −0


def interval(low: float, high: float, error: float) -> str:
    """Both ends to the same place as the value that has this standard error, `open` for one that is not closed."""
    return " to ".join(known_to(end, error) if math.isfinite(end) else "open" for end in (low, high))


def probability(share: float) -> str:
    """A probability in per cent; nothing is certain, nor ruled out."""
    return percent(min(max(share, 1e-6), 1.0 - 1e-6))


def percent(share: float | None) -> str:
    """A share in whole per cent, a dash for no value; what is not all is not 100 %, what is not nothing not 0 %."""
    if share is None or not math.isfinite(share):
        return "-"
    if 1e-9 < share < 0.005:
        return "< 1 %"
    return "> 99 %" if 0.995 <= share < 1.0 - 1e-9 else f"{round(100.0 * share)} %"


def percents(shares: Sequence[float]) -> list[str]:
    """Shares of one whole as `percent` has them, rounded so that together they are the whole: of the whole per cent
    that rounding down leaves each goes to one of the largest remainders (Hamilton's method)."""
    whole = [math.floor(100.0 * share + 1e-9) for share in shares]
    over = round(100.0 * sum(shares)) - sum(whole)
    for k in sorted(range(len(whole)), key=lambda k: whole[k] - 100.0 * shares[k])[: max(over, 0)]:
        whole[k] += 1
    plain = [percent(share) for share in shares]
    return [text if text[0] in "<>" else f"{share} %" for text, share in zip(plain, whole, strict=True)]


def _size(value: float, digits: int = 2) -> int:
    """The power of ten of the first of so many digits, once rounded to them."""
    return int(f"{abs(value):.{digits - 1}e}".partition("e")[2])
