"""The page of a batch: the table's muscles compared, outliers and trends by name."""

import json
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effects import in_words
from ..laws import get_law
from ..plot import batch_spread, batch_trend
from ..report.batch import Easel, PageTable, Part, newtons, number, render_batch
from .compare import Spread, Trend, spreads, trends
from .table import read_results

if TYPE_CHECKING:
    import pandas as pd

MOST_ROWS, MOST_MUSCLES = 200, 2000
MOST_PANELS = 12
MOST_TRENDS = 9
MEDIANS = {"rms error, median": "rmse_N", "noise floor, median": "noise_floor_N"}


def batch_page(table: str | Path, command: str) -> str:
    """The HTML of a table that `batch` wrote; `command` makes it again. Raises UsageError for another file."""
    frame = read_results(table)
    question, units = frame.attrs["question"], frame.attrs["units"]
    law = " + ".join([get_law(question["law"]).title, *map(in_words, question["effects"])])
    listed = {str(name): f"m{k}" for k, name in enumerate(frame["record"].unique()[:MOST_MUSCLES])}
    whole = (_overview(frame), _muscles(frame, listed), *_bad(frame, listed), *_doubtful(frame, listed))
    sections: list[tuple[str, tuple[Part, ...]]] = [("All records", whole)]
    found = spreads(frame, units)
    seen = trends(frame, found)
    for branch in sorted({spread.branch for spread in found}):
        name = "Both branches together" if branch == "together" else f"Branch: {branch}"
        mine = [spread for spread in found if spread.branch == branch]
        followed = [trend for trend in seen if trend.spread.branch == branch]
        sections.append(
            (name, (_spread_part(branch, mine), *_outlier_part(branch, mine, listed), *_trend_part(branch, followed)))
        )
    provenance = {
        "date (UTC)": datetime.now(UTC).strftime("%Y-%m-%d %H:%M"),
        "question": json.dumps({key: value for key, value in question.items() if value}, sort_keys=True),
        **{f"computed with ({k})": one for k, one in enumerate(frame.attrs["versions"], start=1)},
    }
    return render_batch(f"{law}: {frame['record'].nunique()} records", sections, provenance | {"command": command})


def _overview(frame: "pd.DataFrame") -> Part:
    bad = frame["error"].notna()
    verdicts = Counter(frame.loc[~bad, "verdict"].dropna())
    lacks = Counter(name for names in frame["selected"].dropna() for name in names)
    medians = frame[[*MEDIANS.values()]].median().tolist()
    facts = [
        ("records", str(frame["record"].nunique())),
        ("rows with an error", str(np.count_nonzero(bad))),
        *((name, newtons(typical)) for name, typical in zip(MEDIANS, medians, strict=True)),
        *((f"verdict {name.replace('_', ' ')}", str(count)) for name, count in sorted(verdicts.items())),
        *((f"lacks {in_words(name)}", str(count)) for name, count in lacks.most_common()),
    ]
    return Part("overview", "What was fitted", facts=tuple(facts))


def _muscles(frame: "pd.DataFrame", listed: dict[str, str]) -> Part:
    """A row a record; of several branches the first."""
    first, rows = frame.drop_duplicates("record").head(MOST_MUSCLES), []
    for row in first.astype(object).where(first.notna(), None).to_dict("records"):
        lacks = row["selected"]
        rows.append(
            (
                str(row["record"]),
                "error" if row["error"] else str(row["verdict"] or "–").replace("_", " "),
                ", ".join(map(in_words, lacks)) if lacks is not None and len(lacks) else "–",
                number(row["rmse_N"], 3),
                number(row["noise_floor_N"], 3),
            )
        )
    caption = f"Muscles ({len(rows)} of {frame['record'].nunique()})"
    head = ("record", "verdict", "lacks", "rms error (N)", "noise (N)")
    return Part("muscles", "Muscles", tables=(PageTable(caption, head, tuple(rows), (3, 4), ids=listed),))


def _bad(frame: "pd.DataFrame", listed: dict[str, str]) -> list[Part]:
    bad = frame[frame["error"].notna()]
    rows = list(zip(bad["record"], bad["branch"], bad["error"], strict=True))
    text = "These rows take no part in the comparison: bad data, or a fit that is not valid."
    return _first_rows("Errors", ("record", "branch", "what went wrong"), rows, text, listed)


def _doubtful(frame: "pd.DataFrame", listed: dict[str, str]) -> list[Part]:
    """What looks wrong in a record, once for all its branches; tables of earlier versions do not have it."""
    if "warnings" not in frame:
        return []
    told = frame.dropna(subset="warnings").drop_duplicates("record")
    every = [(record, text) for record, texts in zip(told["record"], told["warnings"], strict=True) for text in texts]
    text = "These rows were fitted all the same. Look at their units, signs and sensors before their numbers are used."
    return _first_rows("Warnings", ("record", "what looks wrong"), every, text, listed)


def _first_rows(name: str, head: tuple[str, ...], rows: list[Any], text: str, listed: dict[str, str]) -> list[Part]:
    """A part with no more than MOST_ROWS rows, if there are any."""
    shown = tuple(rows[:MOST_ROWS])
    table = PageTable(f"{name} ({len(shown)} of {len(rows)})", head, shown, links=listed)
    return [Part(name.lower(), name, (text,), tables=(table,))] if rows else []


def _spread_part(branch: str, mine: Sequence[Spread]) -> Part:
    panels = [batch_spread.data(s.quantity, s.unit, s.value, s.stderr, s.outlier) for s in mine[:MOST_PANELS]]
    caption = (
        "Share of the muscles below each value, its own counted half, with bars of one standard error. The line is "
        "the median. Triangles stand apart: more than 3.5 robust standard deviations from it."
    )
    picture = Easel(branch, 0).hang(batch_spread.draw(panels), "spread of each parameter over the muscles", caption)
    rows = tuple(
        (
            s.quantity,
            s.unit or "1",
            str(len(s.value)),
            number(s.median, 5),
            number(s.width, 3),
            number(s.stderr_median, 3),
            str(int(s.outlier.sum())),
        )
        for s in mine
    )
    head = ("quantity", "unit", "muscles", "median", "spread", "standard error, median", "outliers")
    table = PageTable("Spread: 1.4826 times the median absolute deviation", head, rows, (2, 3, 4, 5, 6))
    text = "A spread far above the standard error is a difference between muscles, not noise of their records."
    return Part(f"{branch}-spread", "Spread", (text,), (picture,), (table,))


def _outlier_part(branch: str, mine: Sequence[Spread], listed: dict[str, str]) -> list[Part]:
    found = [
        (float(np.abs(s.value[k] - s.median) / s.width), str(s.records[k]), s.quantity, float(s.value[k]), s.median)
        for s in mine
        for k in np.flatnonzero(s.outlier)
    ]
    if not found:
        return []
    rows = tuple(
        (record, quantity, number(value, 5), number(median, 5), number(away, 3))
        for away, record, quantity, value, median in sorted(found, reverse=True)[:MOST_ROWS]
    )
    head = ("record", "quantity", "value", "median", "robust standard deviations away")
    caption = f"Values that stand apart ({len(rows)} of {len(found)}), the furthest first"
    return [Part(f"{branch}-outliers", "Outliers", tables=(PageTable(caption, head, rows, (2, 3, 4), links=listed),))]


def _trend_part(branch: str, followed: Sequence[Trend]) -> list[Part]:
    if not followed:
        return []
    panels = [
        batch_trend.data(
            t.spread.quantity if t.spread.unit in ("", "1") else f"{t.spread.quantity} ({t.spread.unit})",
            t.over,
            f"ρ {number(t.correlation, 2)}",
            t.x,
            t.spread.value,
            t.spread.outlier,
            (t.slope, t.intercept),
        )
        for t in followed[:MOST_TRENDS]
    ]
    caption = "A point a muscle, with the line of Theil and Sen; ρ is Spearman's correlation. The surest come first."
    picture = Easel(f"{branch}t", 0).hang(batch_trend.draw(panels), "parameters over what muscles differ in", caption)
    rows = tuple(
        (
            t.spread.quantity,
            t.over,
            number(t.correlation, 3),
            number(t.slope, 3),
            number(t.p_all, 2),
            "follows it" if t.found else "could be chance",
        )
        for t in followed
    )
    head = ("quantity", "over", "Spearman's ρ", "slope", "p of all trends", "verdict")
    count = sum(t.found for t in followed)
    text = f"{count} of {len(followed)} trends are no chance at 1 % (p by Holm, for all that were looked at)."
    return [Part(f"{branch}-trends", "Trends", (text,), (picture,), (PageTable("Trends", head, rows, (2, 3, 4)),))]
