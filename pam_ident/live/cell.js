// A picture of a notebook as a figure to zoom and to point at. The first such cell brings Bokeh for all.
{
__FIGURES__
const theme = (figures) => {
const window = { matchMedia: () => ({ addEventListener: () => {} }) } // neither dark nor light: its ground is white
__THEME__
}
const bokeh = __BOKEH__
// Panel, which a later cell may bring, would take this Bokeh for its own, which has no Panel in it.
const alone = (Bokeh) => { if (!Bokeh.Panel) delete window.Bokeh; return Bokeh }
if (bokeh && !window.pamIdentBokeh) window.pamIdentBokeh = window.Bokeh ? Promise.resolve(window.Bokeh) : loaded(bokeh).then(alone)
let tries = 0
const run = async () => {
  if (window.pamIdentBokeh && document.getElementById(__NAME__)) stand(await window.pamIdentBokeh, __DATA__, [__NAME__], theme)
  else if (++tries < 600) setTimeout(run, 100)
}
if (window.DecompressionStream) run()
}
