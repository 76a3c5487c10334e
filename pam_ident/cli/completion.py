"""Completion in bash, which cuts words at colons, as in `coulomb_friction:textbook`."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout


@contextmanager
def whole_words() -> Iterator[None]:
    """Inside, what bash asks to have completed stands in whole words; what is printed is what it lacks of them."""
    done = ""
    if os.environ.get("_PAM_IDENT_COMPLETE") == "complete_bash":
        words, at = os.environ.get("COMP_WORDS", "").split("\n"), int(os.environ.get("COMP_CWORD", "0"))
        words, at, done = _joined(words, at)
        os.environ |= {"COMP_WORDS": "\n".join(words), "COMP_CWORD": str(at)}
    if not done:
        yield
        return
    said = io.StringIO()
    try:
        with redirect_stdout(said):
            yield
    finally:
        print("\n".join(line.removeprefix(done) for line in said.getvalue().splitlines()))


def _joined(words: list[str], at: int) -> tuple[list[str], int, str]:
    """Words put together at colons, the place among them of the one at `at`, and how much of that bash has done with:
    all up to the last colon, nothing where it was not cut."""
    whole: list[str] = []
    place, done = at, ""
    for k, word in enumerate(words):
        after_colon = k > 0 and words[k - 1] == ":" and bool(word) and not word.startswith("-")
        cut = bool(whole) and (word == ":" or after_colon)
        if cut:
            whole[-1] += word
        else:
            whole.append(word)
        if k == at:
            place, done = len(whole) - 1, whole[-1][: whole[-1].rfind(":") + 1] if cut else ""
    return whole, place, done
