const dark = window.matchMedia("(prefers-color-scheme: dark)")
const paint = () => {
  const ink = dark.matches ? "#e6e9ed" : "#1f2933", line = dark.matches ? "#3d4650" : "#d5dae1"
  const ground = dark.matches === undefined ? "white" : getComputedStyle(document.body).backgroundColor
  for (const one of figures) {
    one.border_fill_color = ground // painted over, or lines stay where a resized figure had them
    if (one.background_fill_alpha === 1) one.background_fill_color = ground
    one.outline_line_color = line
    for (const axis of [...one.below, ...one.left])
      axis.setv({ axis_label_text_font_style: "normal", axis_label_text_color: ink, major_label_text_color: ink,
                  axis_line_color: line, major_tick_line_color: line, minor_tick_line_color: null })
    for (const grid of one.center) if (grid.type.endsWith("Grid")) grid.grid_line_color = line
    for (const legend of one.above) if (legend.type.endsWith("Legend"))
      legend.setv({ background_fill_color: null, label_text_color: ink })
    if (one.title) one.title.text_color = ink
  }
}
paint()
dark.addEventListener("change", paint)
