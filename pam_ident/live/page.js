// The pictures of a report as figures to zoom and to point at. Until these stand, and where they cannot, the pictures do.
{
const moves = MOVES
const theme = (figures) => {
THEME
}
const unpacked = (id) => {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (one) => one.charCodeAt(0))
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text()
}
// Keys do nothing in Bokeh's layers: the buttons take their place, so Tab goes past the layers.
const skipped = (root) => {
  for (const one of root.querySelectorAll("*")) {
    if (one.tabIndex === 0) one.tabIndex = -1
    if (one.shadowRoot) skipped(one.shadowRoot)
  }
}
const steer = (place, panels) => {
  const ranges = [panels[0].x_range, panels[0].y_range, panels.at(-1).y_range]
  const beside = place.querySelector(".switches > :last-child")
  for (const [name, move] of Object.entries(moves)) {
    const button = document.createElement("button")
    button.type = "button"
    button.textContent = name
    button.addEventListener("click", () => move(...ranges))
    beside.before(button)
  }
  const boxes = [...place.querySelectorAll("fieldset input")]
  const show = () => boxes.forEach((box, k) => {
    for (const one of panels.flatMap((panel) => panel.renderers))
      if (one.name === `isobar-${k + 1}`) one.visible = box.checked
  })
  place.addEventListener("change", show)
  show()
}
const run = async () => {
  const [code, data] = await Promise.all(["live-bokeh", "live-figures"].map(unpacked))
  const script = document.createElement("script")
  script.textContent = code
  document.head.append(script)
  Bokeh.logger.set_level("warn")
  const { document: made, roots } = JSON.parse(data)
  const items = [{ docid: "report", roots, root_ids: Object.keys(roots) }]
  await Bokeh.embed.embed_items({ report: made }, items)
  for (const [id, name] of Object.entries(roots)) {
    const place = document.getElementById(name).closest("figure")
    const panels = Bokeh.documents.at(-1).get_model_by_id(id).children
    theme(panels)
    steer(place, panels)
    place.querySelector(".drawing").tabIndex = -1
    skipped(place.querySelector(".panels"))
    place.classList.add("live")
  }
}
if (window.DecompressionStream) run()
}
