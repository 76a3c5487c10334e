"""What was assumed or left out while a record was read: facts for whoever shows the record."""

from dataclasses import dataclass, field

LEFT_OUT = {
    "empty_cells": "{rows} left out: column {column!r} is empty there (first {where})",
    "frozen_sensor": "{rows} left out: column {column!r} repeats one reading there, and jumps when it wakes or misses "
    "a motion (first {where})",
    "impossible_value": "{rows} left out: column {column!r} reads there several times what it does in all others "
    "(first {where})",
    "spike": "{rows} left out: column {column!r} jumps away there for a reading and comes back (first {where})",
    "between": "{rows} left out: column {column!r} goes from one isobar to the next there while the muscle rests "
    "(first {where})",
    "between_lengths": "{rows} left out: by column {column!r} the muscle is moved to its next length there while the "
    "pressure rests (first {where})",
    "clipped": "{rows} left out: column {column!r} is at the end of its range there or next to it (first {where})",
    "slack": "{rows} left out: column {column!r} stands at zero there while the pressure changes, as of a muscle that "
    "hangs slack (first {where})",
    "weight_stands": "{n} of {where} samples are left out: they stand at an end of the length, or a weight sticks "
    "there while the pressure changes, and friction may be anything up to its level",
    "rows_chosen": "{rows} left out: {where} does not hold there",
}
TEXTS = LEFT_OUT | {
    "decimal_point": "column {column!r}: {where} was read with a decimal point, but nothing in the file says that the "
    "point does not part thousands. Say decimal = '.' or ',' under [file] in a columns.toml",
    "absolute_pressure": "column {column!r} is absolute pressure; the air's {where} were taken off",
    "midnight": "column {column!r}: the clock passes midnight at {where}; it was let run on",
    "coarse_clock": "column {column!r}: several rows have one time; {rows} put evenly within the clock's tick "
    "(first {where})",
    "one_for_all_runs": "{column} = {where} was taken for {n} runs alike; where they differ, say so in columns.toml: "
    "[runs.'FILE'] {column} = …",
    "run_lengths": "{n} runs have an initial length of their own ({where}); their contraction is by it, and ways in mm "
    "are told of the specimen's",
    "guessed_columns": "{where}: by word and unit; if that is wrong, say in a columns.toml beside the file which is "
    "which",
    "other_table": "{column} is passed over, which may be the record: {where}. If it is, say so in a columns.toml: "
    "part under [file], and which column is what under [columns]",
    "no_clock": "the rows look like a log, one after another, but no column was read as its time: damping, lag, creep "
    "and friction would be taken for something else. {clock}",
    "lever": "{column} and shape are from torque and angle by the lever: {where}",
}
"""Code → its text, by the number `n` of rows (or runs), the `column`, and `where`, the place or the cell."""


@dataclass(frozen=True)
class Note:
    """Something that a reader of the record's results should know; `rows` were left out for it."""

    code: str
    column: str | None
    text: str
    rows: int = 0


@dataclass
class Notes:
    """Notes as they are gathered, one for a code and column however many files and rows it is of."""

    found: dict[tuple[str, str | None], tuple[int, str]] = field(default_factory=dict)

    def add(self, code: str, column: str | None, where: str, n: int = 0) -> None:
        """Something in `n` rows (or runs) of a column; the first `where` is kept."""
        before, first = self.found.get((code, column), (0, where))
        self.found[code, column] = (before + n, first)

    def told(self) -> tuple[Note, ...]:
        """The notes so far."""
        found = []
        for (code, column), (n, where) in self.found.items():
            rows = "1 row is" if n == 1 else f"{n} rows are"
            text = TEXTS[code].format(n=n, rows=rows, column=column, where=where, clock=_name_it(column, where))
            found.append(Note(code, column, text, n if code in LEFT_OUT else 0))
        return tuple(found)


def _name_it(column: str | None, passed: str) -> str:
    if column is None:
        told = f"passed over are {passed}" if passed else "no column was passed over"
        return f"Log the time; if it is there ({told}), name it time_s, or say so in a columns.toml"
    return (
        f"Column {column!r} looks like it: name it time_s or time_ms, or give it so, with the others, under [columns] "
        "of a columns.toml"
    )
