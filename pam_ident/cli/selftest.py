"""pam-ident selftest."""

import typer

from . import options, text


def selftest(json: options.JsonFile = None) -> None:
    """Check this installation on certified problems.

    It then recovers known parameters and a hidden effect from simulated records. Takes some seconds.
    """
    from ..effects import in_words
    from ..schema.trials import selftest_json
    from ..validation.selftest import DIGITS, DIGITS_STDERR, FURTHEST
    from ..validation.selftest import selftest as run

    found = run()
    options.give_json(json, lambda: selftest_json(found))
    recovery = found.recovery
    named = ", ".join(map(in_words, recovery.named)) or "nothing"
    rows = [
        (s.name, str(s.start), f"{s.digits:.1f}", f"{s.digits_stderr:.1f}", "" if s.passed else "short")
        for s in found.problems
    ]
    text.say(f"certified problems of NIST, expected {DIGITS:g} digits, of standard errors {DIGITS_STDERR:g}:")
    text.say(*text.table(("problem", "start", "digits", "of std. errors", ""), rows, left=(0, 4)))
    text.say(
        f"simulated record: true parameters within {recovery.furthest:.1f} standard errors (at most {FURTHEST:g}), "
        f"verdict {text.verdict(recovery.clean_verdict)}",
        f"the same with {in_words(recovery.hidden)} hidden: named {named}",
    )
    if not found.passed:
        short = [f"{s.name} from start {s.start}" for s in found.problems if not s.passed]
        short += [] if recovery.passed else ["the simulated records"]
        text.warn(f"selftest failed: {', '.join(short)}; install again, and report it if that does not help")
        raise typer.Exit(3)
    text.say(f"selftest passed: {len(found.problems)} certified fits, parameters and a hidden effect recovered")
