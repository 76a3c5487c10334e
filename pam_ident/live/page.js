// The pictures of a report as figures to zoom and to point at.
{
__FIGURES__
const theme = (figures) => {
__THEME__
}
const text = (id) => document.getElementById(id).textContent
const run = async () => stand(await loaded(text("live-bokeh")), text("live-figures"), __NAMES__, theme)
if (window.DecompressionStream) run()
}
