const moves = __MOVES__
const unpacked = (packed) => {
  const bytes = Uint8Array.from(atob(packed), (one) => one.charCodeAt(0))
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text()
}
const loaded = async (packed) => {
  const script = document.createElement("script")
  script.textContent = await unpacked(packed)
  document.head.append(script)
  Bokeh.logger.set_level("warn")
  return Bokeh
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
// Figures in the elements of these ids, in the order of their roots; until they stand, and where they cannot, pictures do.
const stand = async (Bokeh, packed, names, theme) => {
  const made = JSON.parse(await unpacked(packed))
  const ids = made.roots.map((one) => one.id)
  const roots = Object.fromEntries(ids.map((id, k) => [id, names[k]]))
  await Bokeh.embed.embed_items({ figures: made }, [{ docid: "figures", roots, root_ids: ids }])
  ids.forEach((id, k) => {
    const place = document.getElementById(names[k]).closest("figure")
    const panels = Bokeh.documents.map((one) => one.get_model_by_id(id)).findLast(Boolean).children
    theme(panels)
    if (panels[0].toolbar.tools.some((one) => one.type === "BoxZoomTool")) steer(place, panels)
    place.querySelector(".drawing").tabIndex = -1
    skipped(place.querySelector(".panels"))
    place.classList.add("live")
  })
}
