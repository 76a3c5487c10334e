"""A hand on the workbench's page in a browser, and what it sees."""

import re

FOCUSED = """() => {
  let one = document.activeElement
  while (one?.shadowRoot?.activeElement) one = one.shadowRoot.activeElement
  if (!one || one === document.body) return ""
  return [one.ariaLabel, one.innerText, ...[...(one.labels ?? [])].map((label) => label.innerText)].join(" ")
}"""
"""JavaScript for what has the keyboard, in words."""


def drop(page, folder, *names):
    """Give files to the page."""
    page.locator("input[type=file]").set_input_files([folder / name for name in names])


def tried(page):
    """Wait until the candidates have been tried."""
    page.locator(".card .bar").first.wait_for()


def candidates(page):
    """Titles, probabilities and errors that the candidates would leave, in the order shown."""
    cards = page.get_by_role("group", name="Candidates").get_by_role("button").all()
    said = [(card.locator(".title").text_content(), card.locator(".text").text_content()) for card in cards]
    return [(title, text.split(" · ")[0], float(re.search(r"leaves ([\d.]+)", text)[1])) for title, text in said]


def error_now(page):
    """The present error in N, as the page tells it."""
    fact = page.locator("dl.facts div", has_text="error now").locator("dd")
    return float(re.match(r"[\d.]+", fact.text_content()).group())


def overlap(one, other):
    """Whether two boxes lie over each other by more than a pixel."""
    return all(
        min(one[k] + one[d], other[k] + other[d]) - max(one[k], other[k]) > 1
        for k, d in (("x", "width"), ("y", "height"))
    )


def specimen(page):
    """Type in the muscle where the draft asks for it."""
    for label, value in (("Initial length (mm)", "200"), ("Initial radius (mm)", "10"), ("Braid angle (°)", "25.4")):
        page.locator(".draft").get_by_label(label).fill(value)
