// A native slider for each parameter that is held by hand.
export function render({ model }) {
  const list = document.createElement("div")
  list.className = "sliders"
  const row = (item) => {
    const field = document.createElement("div"), label = document.createElement("label")
    const slider = document.createElement("input"), value = document.createElement("output")
    const release = document.createElement("button")
    Object.assign(slider, { type: "range", min: item.low, max: item.high, step: (item.high - item.low) / 200, value: item.value })
    slider.dataset.key = item.name
    label.textContent = `${item.name} (${item.unit || "1"})`
    const say = () => { value.textContent = Number(slider.value).toPrecision(4) }
    slider.addEventListener("input", say)
    slider.addEventListener("change", () => model.send_msg({ name: item.name, value: Number(slider.value) }))
    say()
    release.type = "button"
    release.textContent = `Release ${item.name}`
    release.addEventListener("click", () => model.send_msg({ name: item.name, value: null }))
    label.append(slider)
    field.append(label, value, release)
    return field
  }
  let shown = ""
  const draw = () => {
    const now = model.items.map((item) => item.name).join()
    if (now === shown) return  // the hand on a slider knows its value best
    shown = now
    list.replaceChildren(...model.items.map(row))
    list.lastElementChild?.querySelector("input").focus()
  }
  model.on("items", draw)
  draw()
  return list
}
