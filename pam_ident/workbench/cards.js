// A list of buttons that tells what is pointed at and what is clicked, and keeps the keyboard's place when it changes.
const show = (key) => {
  for (const doc of window.Bokeh?.documents ?? []) {
    const traces = doc.get_model_by_name("traces"), preview = doc.get_model_by_name("preview")
    const y = traces?.get_column(key)
    if (preview) preview.data = y ? { x: traces.get_column("x"), y } : { x: [], y: [] }
  }
}
const part = (kind, text, name) => Object.assign(document.createElement(kind), { textContent: text, className: name })

function card(item, model) {
  const button = part("button", "", `card ${item.kind ?? ""}`)
  button.type = "button"
  button.dataset.key = item.key
  if (item.disabled) button.setAttribute("aria-disabled", "true")
  if (item.current) button.setAttribute("aria-current", item.kind === "step" ? "step" : "true")
  button.append(part("span", item.title, "title"), part("span", item.text ?? "", "text"))
  if (item.bar !== undefined) {
    const bar = part("span", "", "bar")
    bar.setAttribute("aria-hidden", "true")
    bar.style.setProperty("--share", item.bar)
    bar.style.setProperty("--noise", item.noise)
    button.append(bar)
  }
  button.addEventListener("click", () => item.disabled || model.send_msg({ key: item.key }))
  if (item.traced) {
    for (const on of ["mouseenter", "focus"]) button.addEventListener(on, () => show(item.key))
    for (const off of ["mouseleave", "blur"]) button.addEventListener(off, () => show(""))
  }
  return button
}

export function render({ model }) {
  const list = part("div", "", "cards")
  list.setAttribute("role", "group")
  list.setAttribute("aria-label", model.label)
  list.tabIndex = -1
  const draw = () => {
    const focused = list.getRootNode().activeElement, key = focused?.dataset.key
    list.replaceChildren(...model.items.map((item) => card(item, model)))
    if (focused && (focused === list || key !== undefined)) {
      const buttons = [...list.children]
      const next = buttons.find((one) => one.dataset.key === key) ?? buttons.find((one) => !one.ariaDisabled) ?? list
      next.focus()
    }
  }
  model.on("items", draw)
  draw()
  return list
}
