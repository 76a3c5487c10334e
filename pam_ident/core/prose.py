"""Words as a sentence takes them."""


def capital(text: str) -> str:
    """The text as a sentence begins, or a heading."""
    return text[:1].upper() + text[1:]
