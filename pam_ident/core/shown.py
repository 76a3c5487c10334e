"""How what is known shows itself at the prompt and in a notebook."""

from html import escape


class Shown:
    """What has a `repr` of a few lines, which a notebook shows too."""

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"
